"""The slope of measured points at zero slip, read without a tire model, with its standard error."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan, radians

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.correlation import correlation_length

FloatArray = npt.NDArray[np.float64]

#: Half the width of the window in which a slope at zero slip is read: wide enough to average ripple and noise of the
#: slip, narrow enough for a cubic.
SLOPE_WINDOW = {"kappa": 0.04, "alpha": radians(2.0)}
#: Fewest rows in a window, and in each of its quarters: without rows near zero, or on one side, no slope is read.
FEWEST, FEWEST_IN_QUARTER = 12, 2


@dataclass(frozen=True)
class Slope:
    """A slope at zero slip.

    Attributes
    ----------
    value : float
        NaN if the rows do not determine it.
    error : float
        Its standard error under residuals that are correlated in time, also those of a curve that is not a cubic.
    """

    value: float
    error: float


def read_slope(slip: FloatArray, force: FloatArray, window: float) -> Slope:
    """Read the slope of measured points at zero slip.

    A cubic is fitted to the points in the window with tricube weights by distance from zero and Huber weights against
    outliers: local regression after Cleveland, J. Am. Stat. Assoc. 74 (1979). The slope is linear in the forces; its
    variance is that of their residuals times their correlation length.

    Parameters
    ----------
    slip, force : ndarray, shape (n,)
        In the order of time; NaN is ignored.
    window : float
        Half width, in the unit of the slip.

    Returns
    -------
    Slope
        NaN if a quarter of the window has no rows, or the window fewer than 12.

    Examples
    --------
    >>> slip = np.linspace(-1.0, 1.0, 201)
    >>> found = read_slope(slip, np.sin(3.0 * slip), 0.3)
    >>> round(found.value, 2), found.error < 0.01
    (3.0, True)
    """
    inside = np.flatnonzero(np.isfinite(slip) & np.isfinite(force) & (np.abs(slip) < window))
    x, y = slip[inside] / window, force[inside]
    quarters = np.bincount(np.clip((2.0 * (x + 1.0)).astype(int), 0, 3), minlength=4)
    if len(x) < FEWEST or quarters.min() < FEWEST_IN_QUARTER:
        return Slope(nan, nan)
    powers = x[:, None] ** np.arange(4)
    tricube: FloatArray = (1.0 - np.abs(x) ** 3) ** 3
    coefficients: FloatArray = np.zeros(4)
    residual, weight = y, tricube
    for _ in range(20):
        root = np.sqrt(weight)
        solution = np.linalg.lstsq(powers * root[:, None], y * root, rcond=None)[0]
        coefficients = np.asarray(solution, dtype=np.float64)
        residual = y - powers @ coefficients
        knee = 1.345 * 1.4826 * float(np.median(np.abs(residual)))
        # A knee of 0 means that half of the points are exact: no outlier weights.
        weight = tricube * np.minimum(1.0, knee / np.maximum(np.abs(residual), knee)) if knee > 0.0 else tricube
    influence = np.linalg.pinv(powers.T @ (powers * weight[:, None]))[1] @ (powers * weight[:, None]).T
    passes = np.cumsum(np.diff(inside, prepend=inside[0]) > 1)  # each time the slip crosses the window
    variance = float(np.sum((influence * residual) ** 2)) * len(x) / (len(x) - 4)
    error = np.sqrt(variance * max(correlation_length(residual, passes), 1.0))
    return Slope(float(coefficients[1]) / window, float(error) / window)
