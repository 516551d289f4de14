"""Smoothing of measured inputs by local parabolas with an adaptive window for each row.

Noise of a slip is confounded with relaxation and with reduced stiffness. A window across a step is worse than no
smoothing. Therefore the window of each row is widened as long as its estimates agree (intersection of confidence
intervals: Goldenshluger and Nemirovski, On spatially adaptive estimation of nonparametric regression, 1997; Katkovnik,
1999).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.signal import savgol_coeffs, savgol_filter

FloatArray = npt.NDArray[np.float64]

#: Half widths of the windows, in rows.
HALF_WIDTHS = (2, 3, 4, 6, 9, 13, 18)
#: Rows of the local parabola from which the noise is estimated.
WINDOW = 11
#: Rows of a narrower parabola. A channel is sampled too coarsely to be smoothed if the noise about the wide parabola
#: exceeds that about the narrow one by this factor: then it contains the curvature of the channel.
NARROW_WINDOW, COARSE = 5, 1.5
#: Largest difference of agreeing estimates, in standard deviations.
AGREEMENT = 1.0
#: Distance of a row from each prediction by its neighbors, in standard deviations, above which it is a spike.
#: Convention: rare for normally distributed noise.
SPIKE = 3.5
#: Weights with which the line through five rows predicts the next one.
LINE = np.array([-0.4, -0.1, 0.2, 0.5, 0.8])


def smoothed(values: FloatArray) -> tuple[FloatArray, float]:
    """Return a channel without its short-range noise, and the standard deviation of this noise.

    Parameters
    ----------
    values : ndarray, shape (n,)
        At approximately equal time steps.

    Returns
    -------
    ndarray, shape (n,)
    float
        0 if the channel was not smoothed.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> ramp = np.concatenate([np.linspace(0.0, 1.0, 300), np.ones(300)])
    >>> clean, noise = smoothed(ramp + 0.01 * rng.standard_normal(600))
    >>> bool(np.sqrt(np.mean((clean - ramp) ** 2)) < 0.005), abs(noise - 0.01) < 0.002
    (True, True)
    """
    n = len(values)
    if n < 4 * HALF_WIDTHS[-1] or np.ptp(values) == 0.0:
        return values, 0.0
    deviation, correlation = noise_of(values)
    if deviation == 0.0 or deviation > COARSE * noise_of(values, NARROW_WINDOW)[0]:
        return values, 0.0
    values = _without_spikes(values, deviation)
    lower, upper = values - 3.0 * deviation, values + 3.0 * deviation  # a row next to a step is not changed
    best, widening = values.copy(), np.ones(n, dtype=bool)
    for half in HALF_WIDTHS:
        width = 2 * half + 1
        line = savgol_filter(values, width, 2)
        spread = deviation * np.sqrt(_variance_factor(width, correlation))
        lower, upper = np.maximum(lower, line - AGREEMENT * spread), np.minimum(upper, line + AGREEMENT * spread)
        widening &= lower <= upper
        best[widening] = line[widening]
    return best, deviation


def _without_spikes(values: FloatArray, deviation: float) -> FloatArray:
    """Return values with each isolated spike replaced by the mean of its neighbors.

    A spike agrees neither with the line through the rows before nor with that through the rows after it, nor with the
    mean of its neighbors. The first row after a step and the turning point of a sweep agree with one of them.
    """
    n, length = len(values), len(LINE)
    inner = values[length : n - length]
    middle = 0.5 * (values[length - 1 : n - length - 1] + values[length + 1 : n - length + 1])
    before = np.convolve(values, LINE[::-1], mode="valid")[: n - 2 * length]
    after = np.convolve(values, LINE, mode="valid")[length + 1 :]
    isolated = np.abs(inner - middle) > SPIKE * deviation * np.sqrt(1.5)
    for line in (before, after):
        isolated &= np.abs(inner - line) > SPIKE * deviation * np.sqrt(1.0 + LINE @ LINE)
    return np.concatenate([values[:length], np.where(isolated, middle, inner), values[n - length :]])


def noise_of(values: FloatArray, window: int = WINDOW) -> tuple[float, float]:
    """Return the standard deviation of the noise, and its correlation between neighboring rows."""
    away = -savgol_coeffs(window, 2)
    away[window // 2] += 1.0
    residual = values - savgol_filter(values, window, 2)
    typical = 1.4826 * float(np.median(np.abs(residual)))
    if typical == 0.0:  # exact except for steps
        return 0.0, 0.0
    regular = np.where(np.abs(residual) < 2.5 * typical, residual, 0.0)
    lag = float(np.sum(regular[1:] * regular[:-1])) / float(np.sum(regular**2))
    of_white = float(away[1:] @ away[:-1]) / float(away @ away)
    correlation = float(np.clip(lag - of_white, 0.0, 0.9))
    rows = np.arange(window)
    factor = float(away @ correlation ** np.abs(rows[:, None] - rows) @ away)
    return typical / float(np.sqrt(factor)), correlation


def _variance_factor(width: int, correlation: float) -> float:
    """Return the variance at the center of a local parabola for noise of variance 1 with geometric correlation."""
    weights = savgol_coeffs(width, 2)
    rows = np.arange(width)
    return float(weights @ correlation ** np.abs(rows[:, None] - rows) @ weights)
