"""The preprocessed recording: signals, disturbances, measurement artefacts, and simulation of a tire over it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .disturbances import CROSS_TALK, disturbances_of, load_error_responses, reported_disturbances
    from .measurement_artefacts import quantisation, ripple
    from .outliers import OUTLIER
    from .signals import FORMULA_SIGNS, HOLDOUT_EVERY, signals_of
    from .simulation import Simulator
    from .skew import between_rows

__getattr__, __dir__ = on_demand(__name__)
