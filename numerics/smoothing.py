"""Smoothing of measured inputs by local parabolas with an adaptive window for each row.

Noise of a slip is confounded with relaxation and with reduced stiffness. A window across a step is worse than no
smoothing. Therefore the window of each row is widened as long as its estimates agree (intersection of confidence
intervals: Goldenshluger and Nemirovski, On spatially adaptive estimation of nonparametric regression, 1997; Katkovnik,
1999).
"""

from __future__ import annotations

from functools import cache

import numpy as np

from .arrays import FloatArray

#: Half widths of the windows, in rows.
HALF_WIDTHS = (2, 3, 4, 6, 9, 13, 18)
#: Fewest rows that are smoothed: two windows of the noise. A window is at most half of the rows wide.
FEW_ROWS = 22
#: Rows of the local parabola from which the noise is estimated.
WINDOW = 11
#: Rows of a narrower parabola. A channel is sampled too coarsely to be smoothed if the noise about the wide parabola
#: exceeds that about the narrow one by this factor: then it contains the curvature of the channel.
NARROW_WINDOW, COARSE = 5, 1.5
#: Largest difference of agreeing estimates, in standard deviations.
AGREEMENT = 1.0
#: Distance of a row from the line through its four neighbors above which it is a spike, in standard deviations.
#: Convention: rare for normally distributed noise.
SPIKE = 3.5
#: Largest distance of the neighbors themselves. Derived: below it, the turning point of a parabola is no spike.
STRAIGHT = 2.0


def rate_of(values: FloatArray, t: FloatArray) -> FloatArray:
    """Return the rate of change over time of values, shape (..., n), by central differences; 0 where time stands still.

    >>> rate_of(np.array([0.0, 1.0, 2.0, 2.0]), np.array([0.0, 0.5, 1.0, 1.0])).tolist()
    [2.0, 2.0, 0.0, 0.0]
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.nan_to_num(np.gradient(values, t, axis=-1), posinf=0.0, neginf=0.0))


def smoothed(values: FloatArray) -> tuple[FloatArray, float]:
    """Return a channel without its short-range noise, and the standard deviation of this noise.

    `values`, shape (n,): at approximately equal time steps. Returns the channel, shape (n,), and the standard
    deviation: 0 if the channel was not smoothed.

    >>> rng = np.random.default_rng(1)
    >>> ramp = np.concatenate([np.linspace(0.0, 1.0, 300), np.ones(300)])
    >>> clean, noise = smoothed(ramp + 0.01 * rng.standard_normal(600))
    >>> bool(np.sqrt(np.mean((clean - ramp) ** 2)) < 0.005), abs(noise - 0.01) < 0.002
    (True, True)
    """
    n = len(values)
    if n < FEW_ROWS or np.ptp(values) == 0.0:
        return values, 0.0
    deviation, correlation = noise_of(values)
    if deviation == 0.0 or deviation > COARSE * noise_of(values, NARROW_WINDOW)[0]:
        return values, 0.0
    values = without_spikes(values, deviation)
    lower, upper = values - 3.0 * deviation, values + 3.0 * deviation  # a row next to a step is not changed
    best, widening = values.copy(), np.ones(n, dtype=bool)
    for half in (half for half in HALF_WIDTHS if 4 * half <= n):
        width = 2 * half + 1
        line = parabolas(values, width)
        spread = deviation * np.sqrt(_variance_factor(width, correlation))
        lower, upper = np.maximum(lower, line - AGREEMENT * spread), np.minimum(upper, line + AGREEMENT * spread)
        widening &= lower <= upper
        best[widening] = line[widening]
    return best, deviation


def without_spikes(values: FloatArray, deviation: float) -> FloatArray:
    """Return values with each isolated spike replaced by the mean of its four neighbors, which lie on a line."""
    neighbors = np.stack([values[:-4], values[1:-3], values[3:-1], values[4:]])
    mean, places = neighbors.mean(axis=0), np.array([-2.0, -1.0, 1.0, 2.0])[:, None]
    slope = np.sum(places * neighbors, axis=0) / np.sum(places**2)
    is_straight = np.abs(neighbors - mean - slope * places).max(axis=0) < STRAIGHT * deviation
    inner = values[2:-2]
    is_spike = is_straight & (np.abs(inner - mean) > SPIKE * deviation * np.sqrt(1.25))
    return np.concatenate([values[:2], np.where(is_spike, mean, inner), values[-2:]])


def noise_of(values: FloatArray, window: int = WINDOW) -> tuple[float, float]:
    """Return the standard deviation of the noise, and its correlation between neighboring rows."""
    away = -_parabola_weights(window)[window // 2]
    away[window // 2] += 1.0
    residual = values - parabolas(values, window)
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
    weights = _parabola_weights(width)[width // 2]
    rows = np.arange(width)
    return float(weights @ correlation ** np.abs(rows[:, None] - rows) @ weights)


def parabolas(values: FloatArray, width: int) -> FloatArray:
    """Return the least-squares parabolas of the windows around each row, at that row (Savitzky-Golay filter).

    The first and the last windows also give the rows at the ends. `scipy.signal.savgol_filter` returns the same;
    loading scipy.signal takes longer than smoothing a recording.

    `values`, shape (n,). `width`: rows of a window: odd, at most n. Returns shape (n,).

    >>> parabolas(np.array([0.0, 1.0, 4.0, 9.0, 16.0, 25.0]), 5).round(9).tolist()
    [0.0, 1.0, 4.0, 9.0, 16.0, 25.0]
    """
    weights, half = _parabola_weights(width), width // 2
    inner = np.convolve(values, weights[half][::-1], "valid")
    first, last = weights[:half] @ values[:width], weights[half + 1 :] @ values[-width:]
    return np.concatenate([first, inner, last])


@cache
def _parabola_weights(width: int) -> FloatArray:
    """Return the weights of the rows of a window in its parabola at each of its rows, shape (width, width)."""
    basis, _ = np.linalg.qr(np.vander(np.arange(width) - width // 2, 3).astype(np.float64))
    return np.asarray(basis @ basis.T)
