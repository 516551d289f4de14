"""Recordings in files: readers of each format, and writing of tables."""
