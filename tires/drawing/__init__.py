"""Figures of a tire, and the style that all figures share."""

from .tire_figures import draw, plot, usual_loads

__all__ = ["draw", "plot", "usual_loads"]
