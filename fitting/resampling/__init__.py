"""Repeated solutions near the solution of a fit: bootstrap, bounds moved outward, second solutions."""
