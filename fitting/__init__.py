"""Fitting a tire to measurements under physical constraints, by CasADi and IPOPT."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..boundary.on_demand import on_demand
from .fit import fit
from .options import FitOptions

if TYPE_CHECKING:
    from .checks.diagnostics import Findings
    from .cross_validation import assign_folds, cross_validate
    from .family import Family
    from .fit_result import FitResult
    from .options import declared_options
    from .problem.recipe import RECIPES, load_recipe
    from .reporting.figures import draw_figures
    from .results.records import HeldOut
    from .stage import StageSolver

__all__ = [
    "RECIPES", "Findings", "FitOptions", "FitResult", "HeldOut", "assign_folds", "cross_validate", "draw_figures",
    "fit", "load_recipe",
]  # fmt: skip

__getattr__, __dir__ = on_demand(__name__)
