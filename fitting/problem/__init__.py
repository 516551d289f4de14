"""The least-squares problem of a stage: weighted residuals, loss, regularization, recipes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .ellipse import ellipse_values
    from .loss import LOSSES, robust_scale
    from .prior import Prior
    from .recipe import FreeCoefficient, recipe_schema
    from .rows import Rows
    from .slope_targets import SlopeTarget
    from .weighted_residuals import Problem, Ridge
    from .weights import MIN_NOISE, emphasis, equal_weights, limits_of, noise_weights

__getattr__, __dir__ = on_demand(__name__)
