"""Fitting a tire to measurements under physical constraints, by CasADi and IPOPT."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..boundary.on_demand import on_demand
from .fit import fit
from .options import FitOptions

if TYPE_CHECKING:
    from .checks.diagnostics import Findings
    from .cross_validation import assign_folds, cross_validate
    from .fit_result import FitResult
    from .problem.recipe import RECIPES, load_recipe
    from .reporting.figures import draw_figures
    from .results.records import HeldOut

__all__ = [
    "RECIPES", "Findings", "FitOptions", "FitResult", "HeldOut", "assign_folds", "cross_validate", "draw_figures",
    "fit", "load_recipe",
]  # fmt: skip

#: The module of each name that loads pandas, CasADi or Matplotlib.
_ON_DEMAND = {
    "Findings": "checks.diagnostics", "assign_folds": "cross_validation", "cross_validate": "cross_validation",
    "FitResult": "fit_result", "RECIPES": "problem.recipe", "load_recipe": "problem.recipe",
    "draw_figures": "reporting.figures", "HeldOut": "results.records",
}  # fmt: skip

__getattr__, __dir__ = on_demand(__name__, _ON_DEMAND)
