"""What a diagnosis concludes: the result and the parts that it consists of."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .adequacy import Adequacy, adequacies
    from .extrapolation import MAX_CHANGE, Extrapolation, extrapolations, outside
    from .findings import CoefficientInterval, FoundEffect
    from .fit_error import (
        DeliveredResiduals,
        computed_by,
        delivered_residuals,
        density_gain,
        error_splits,
        fit_errors,
        reasons_against,
        residual_of,
    )
    from .improved_tire import tire_of
    from .parts import Identifiability
    from .residual_location import residual_maps, time_course
    from .verdict import headline_text, verdict_sentences

__getattr__, __dir__ = on_demand(__name__)
