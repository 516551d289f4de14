"""Tires for other programs: code in their language (`printout.py`), property files that they accept."""
