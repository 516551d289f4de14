"""Intervals from repeated solutions near the solution of a fit: bootstrap and profile likelihood."""
