"""Fitting a tire to measurements under physical constraints, by CasADi and IPOPT."""

from .cross_validation import assign_folds, cross_validate
from .evidence.diagnostics import Findings
from .fit import fit
from .problem.recipe import RECIPES, load_recipe
from .reporting.figures import draw_figures
from .results.fit_result import FitResult
from .results.records import HeldOut

__all__ = [
    "RECIPES", "Findings", "FitResult", "HeldOut", "assign_folds", "cross_validate", "draw_figures", "fit",
    "load_recipe",
]  # fmt: skip
