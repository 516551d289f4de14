"""Estimation methods of the fit and the diagnosis: damped Gauss-Newton, noise models, resampling, periodicity."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .block_regression import autocovariance, block_sums, coloured_covariance, regression
    from .correlation import correlation_length, effective_sample_size
    from .forecast import Forecast, seconds_left
    from .gauss_newton import Damping, best_step, minimize, restore
    from .noise_model import ROWS_OF_PART, NoiseParts, Whitening, noise_parts
    from .slip_slope import SLOPE_WINDOW, read_slope
    from .smoothing import parabolas, smoothed, without_spikes
    from .ties import BITS, graded
    from .wheel_periodicity import once_per_revolution

__getattr__, __dir__ = on_demand(__name__)
