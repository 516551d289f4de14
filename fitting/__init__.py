"""Fitting a tire to measurements under physical constraints, by CasADi and IPOPT."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .checks.diagnostics import Findings
from .cross_validation import assign_folds, cross_validate
from .fit import fit
from .fit_result import FitResult
from .options import FitOptions
from .problem.recipe import RECIPES, load_recipe
from .results.records import HeldOut

__all__ = [
    "RECIPES", "Findings", "FitOptions", "FitResult", "HeldOut", "assign_folds", "cross_validate", "draw_figures",
    "fit", "load_recipe",
]  # fmt: skip

if TYPE_CHECKING:
    from .reporting.figures import draw_figures


def __getattr__(name: str) -> Any:
    """Load what draws figures at its first use: it takes as long as a fit of few rows."""
    if name != "draw_figures":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .reporting.figures import draw_figures

    return draw_figures
