"""Checks of a fit and its data: residuals, curves, consistency, what the data determine."""
