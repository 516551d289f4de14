"""Fitting a tire to measurements under physical constraints, by CasADi and IPOPT."""

from .figures import draw_figures
from .findings import Findings
from .fit import fit
from .recipe import RECIPES, load_recipe
from .result import FitResult, HeldOut
from .validation import cross_validate, deal

__all__ = [
    "RECIPES", "Findings", "FitResult", "HeldOut", "cross_validate", "deal", "draw_figures", "fit", "load_recipe",
]  # fmt: skip
