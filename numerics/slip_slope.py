"""The slip stiffness: the slope of measured points at zero slip, read without a tire model, with its standard error."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import nan, radians

import numpy as np
from scipy.linalg.lapack import dposv, dtbtrs
from scipy.optimize import brentq

from .arrays import BoolArray, FloatArray, IntArray
from .correlation import correlation_length

#: Half the width of the window in which a slope at zero slip is read: wide enough to average ripple and noise of the
#: slip, narrow enough for a cubic.
SLOPE_WINDOW = {"kappa": 0.04, "alpha": radians(2.0)}
#: Fewest rows in a window, and in each of its quarters: without rows near zero, or on one side, no slope is read.
MIN_POINTS, MIN_IN_QUARTER = 12, 2
#: Largest correlation of neighboring rows that is estimated: a correlation length of 200 rows, longer than a pass.
MAX_CORRELATED = 0.99


@dataclass(frozen=True)
class Slope:
    """A slope at zero slip.

    - `value`: NaN if the rows do not determine it.
    - `error`: its standard error under residuals that are correlated in time, also those of a curve that is not a
      cubic.
    - `rows`, shape (m,): the rows from which it was read.
    - `influence`, shape (m,): derivative of the value by the force of these rows: ``value = influence @ force[rows]``.
    """

    value: float
    error: float
    rows: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    influence: FloatArray = field(default_factory=lambda: np.zeros(0))


def read_slope(slip: FloatArray, force: FloatArray, window: float) -> Slope:
    """Read the slope of measured points at zero slip.

    A cubic is fitted to the points in the window with tricube weights by distance from zero and Huber weights against
    outliers: local regression after Cleveland, J. Am. Stat. Assoc. 74 (1979). The slope is linear in the forces. Its
    variance is the larger of two estimates: the variance of the residuals times their correlation length, which holds
    for any correlation that is short compared with a pass of the slip, and that of autoregressive noise, which accounts
    for the part of the noise that the cubic follows.

    `slip`, `force`, shape (n,): in the order of time; NaN is ignored. `window`: half width, in the unit of the slip.
    Returns: NaN if a quarter of the window has no rows, or the window fewer than 12.

    >>> slip = np.linspace(-1.0, 1.0, 201)
    >>> found = read_slope(slip, np.sin(3.0 * slip), 0.3)
    >>> round(found.value, 2), found.error < 0.01
    (3.0, True)
    """
    inside = np.flatnonzero(np.isfinite(slip) & np.isfinite(force) & (np.abs(slip) < window))
    x, y = slip[inside] / window, force[inside]
    quarters = np.bincount(np.clip((2.0 * (x + 1.0)).astype(int), 0, 3), minlength=4)
    if len(x) < MIN_POINTS or quarters.min() < MIN_IN_QUARTER:
        return Slope(nan, nan)
    powers = x[:, None] ** np.arange(4)
    tricube: FloatArray = (1.0 - np.abs(x) ** 3) ** 3
    residual, weight = y, tricube
    for _ in range(20):
        weighted = powers * weight[:, None]
        _, solution, singular = dposv(powers.T @ weighted, y @ weighted)
        if singular:  # as many points as powers, or equal slips
            root = np.sqrt(weight)
            solution = np.linalg.lstsq(powers * root[:, None], y * root, rcond=None)[0]
        residual = y - powers @ solution
        size = np.abs(residual)
        knee = 1.345 * 1.4826 * float(np.median(size))
        # A knee of 0 means that half of the points are exact: no outlier weights.
        weight = tricube * (knee / np.maximum(size, knee)) if knee > 0.0 else tricube
    weighted = powers * weight[:, None]
    solve = weighted @ np.linalg.pinv(powers.T @ weighted)  # coefficients = force @ solve
    influence = solve[:, 1]
    passes = np.cumsum(np.diff(inside, prepend=inside[0]) > 1, dtype=np.int64)  # each time the slip crosses the window
    variance = float(np.sum((influence * residual) ** 2)) * len(x) / (len(x) - 4)
    variance *= max(correlation_length(residual, passes), 1.0)
    error = np.sqrt(max(variance, _autoregressive_variance(residual, powers, solve, passes)))
    return Slope(float(influence @ y) / window, float(error) / window, inside, influence / window)


def _autoregressive_variance(residual: FloatArray, powers: FloatArray, solve: FloatArray, passes: IntArray) -> float:
    """Return the variance of the slope under noise that is autoregressive of order 1 within each pass.

    The noise has the correlation rho of neighbors for which the expected correlation of the residuals, from which the
    cubic has taken a part, is the observed one (method of moments).
    """
    power = float(residual @ residual)
    if power == 0.0:
        return 0.0
    together = np.diff(passes) == 0

    def expected(rho: float) -> tuple[float, float, float]:
        """Return lagged and plain sum of products of the residuals, and variance of the slope, of unit noise."""
        noise = _autoregressive(solve, rho, together)
        inner = solve.T @ noise  # covariance of the coefficients of the cubic
        followed = powers @ inner
        lagged = rho - np.sum(powers[:-1] * noise[1:] + (noise - followed)[:-1] * powers[1:], axis=1)
        plain = 1.0 - np.sum(powers * (2.0 * noise - followed), axis=1)
        return float(np.sum(lagged[together])), float(np.sum(plain)), float(inner[1, 1])

    observed = float(np.sum((residual[1:] * residual[:-1])[together])) / power

    def excess(rho: float) -> float:
        lagged, plain, _ = expected(rho)
        return lagged / plain - observed

    if excess(0.0) >= 0.0:
        rho = 0.0
    elif excess(MAX_CORRELATED) <= 0.0:
        rho = MAX_CORRELATED
    else:
        rho = float(brentq(excess, 0.0, MAX_CORRELATED, xtol=1e-4))
    _, plain, variance = expected(rho)
    return power / plain * variance


def _autoregressive(columns: FloatArray, rho: float, together: BoolArray) -> FloatArray:
    """Return the product of the correlation matrix and columns, shape (n, m): rho^|i - j| within each pass, else 0.

    `together` states for each row but the last whether the next one is of the same pass.
    """
    if rho == 0.0:
        return columns
    step = np.ones((2, len(columns)))
    step[1, :-1] = np.where(together, -rho, 0.0)
    forward, _ = dtbtrs(step, columns, uplo="L", diag="U")
    step[1, :-1] = step[1, -2::-1]
    backward = dtbtrs(step, columns[::-1], uplo="L", diag="U")[0][::-1]
    return np.asarray(forward + backward - columns)
