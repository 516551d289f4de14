"""Fitting a tire to measurements under physical constraints, by CasADi and IPOPT."""

from .figures import draw_figures
from .fit import fit
from .recipe import RECIPES, load_recipe
from .result import FitResult
from .validation import HeldOut, cross_validate

__all__ = ["RECIPES", "FitResult", "HeldOut", "cross_validate", "draw_figures", "fit", "load_recipe"]
