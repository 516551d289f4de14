"""Figures, text and HTML report of a fit."""
