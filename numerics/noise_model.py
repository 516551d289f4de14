"""Noise model of a recording (white noise, short-range noise and slow drift), and the filter that whitens it.

Drift at the rate of the sweeps increases the variance of ordinary least squares more than all short-range noise.
Generalised least squares takes its correlation into account. The parameters are estimated from the periodogram of the
residual (Whittle, Estimation and information in stationary time series, 1953). The whitened rows are the innovations of
a Kalman filter, which bridges unused rows (Harvey, Forecasting, Structural Time Series Models and the Kalman Filter,
1989, section 3.4).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import fft, optimize

from .arrays import BoolArray, FloatArray
from .ties import graded

#: Initial correlation times of drift for the fit to a periodogram, and their bounds, s.
DRIFT_TIMES = (0.5, 2.0, 8.0)
SHORTEST, LONGEST = 0.3, 60.0
#: Prior of the share of white noise: its value, and its weight (in log variances, relative to one row).
WHITE_SHARE, WHITE_PRIOR = 0.05, 1e-3
#: Lower limit of the mean square of a weighted residual.
MIN_POWER = 1e-6
#: Time before the first row, s: much longer than any correlation.
BEFORE_START = 1e9
#: Rows of a part of the recording. The filter passes all parts at the same time and then joins them.
ROWS_OF_PART = 32
#: All channels of a recording.
ALL_CHANNELS = slice(None)


@dataclass(frozen=True)
class NoiseParts:
    """The noise of a channel in three parts.

    - `white`, `short`, `drift`: variances, in the squared unit of the residual.
    - `fading`: correlation of the short-range part from one row to the next.
    - `memory`: time over which the drift's correlation falls to 1/e.
    """

    white: float
    short: float
    drift: float
    fading: float
    memory: float

    def times(self, factor: float) -> NoiseParts:
        """Return noise with a multiple of the variances."""
        return replace(self, white=factor * self.white, short=factor * self.short, drift=factor * self.drift)


def noise_parts(residual: FloatArray, present: BoolArray, step: float) -> NoiseParts:
    """Estimate the noise of a channel from its residual.

    `residual`, shape (n,): at approximately equal time steps. `present`, shape (n,): false for rows that are not used.

    >>> rng = np.random.default_rng(3)
    >>> from scipy.signal import lfilter
    >>> drift = lfilter([np.sqrt(1.0 - 0.99**2)], [1.0, -0.99], rng.standard_normal(6000))
    >>> found = noise_parts(drift + rng.standard_normal(6000), np.ones(6000, dtype=bool), 0.02)
    >>> bool(0.6 < found.drift < 1.6), bool(1.0 < found.memory < 4.0)
    (True, True)
    """
    rows = np.where(present, residual, 0.0)
    power = np.abs(fft.rfft(rows))[1:-1] ** 2 / max(int(present.sum()), 1)
    wave = np.cos(2.0 * np.pi * fft.rfftfreq(len(rows))[1:-1])
    whole = max(float(np.sum(rows**2)) / max(int(present.sum()), 1), MIN_POWER)

    def loss(x: FloatArray) -> tuple[float, FloatArray]:
        """Return Whittle's likelihood and its gradient: by differences, rounding errors would change the result."""
        noise = _noise(x)
        spectrum, slopes = np.full_like(wave, noise.white), [np.full_like(wave, noise.white)]
        decay = float(np.exp(-step / noise.memory))
        rates = [noise.fading * (1.0 - noise.fading), decay * step / noise.memory]  # of the decays, by their logarithms
        for variance, fade in ((noise.short, noise.fading), (noise.drift, decay)):
            below = 1.0 - 2.0 * fade * wave + fade**2
            part = variance * (1.0 - fade**2) / below
            spectrum += part
            slopes += [part, (2.0 * (wave - fade) * part - 2.0 * fade * variance) / below]
        along = (1.0 - power / (whole * spectrum)) / spectrum / len(wave)
        white, short, of_short, drift, of_drift = (float(along @ slope) for slope in slopes)
        prior = float(x[0] - np.log(WHITE_SHARE))
        gradient = [white + 2.0 * WHITE_PRIOR * prior, short, drift, of_short * rates[0], of_drift * rates[1]]
        return float(np.mean(np.log(spectrum) + power / (whole * spectrum))) + WHITE_PRIOR * prior**2, np.array(
            gradient
        )

    bounds = [(-9.0, 0.0), (-7.0, 0.7), (-13.0, 1.1), (-4.0, 3.0), (np.log(SHORTEST), np.log(LONGEST))]
    solutions = [
        optimize.minimize(
            loss, [np.log(WHITE_SHARE), -0.2, -2.3, 0.0, np.log(memory)], jac=True, method="L-BFGS-B", bounds=bounds
        )
        for memory in DRIFT_TIMES
    ]
    best = _noise(min(solutions, key=lambda solution: graded(float(solution.fun))).x)
    return replace(best, white=whole * best.white, short=whole * best.short, drift=whole * best.drift)


def _noise(x: FloatArray) -> NoiseParts:
    """Return the noise of logarithms of the variances, the logit of fading, and the logarithm of the memory."""
    white, short, drift, memory = (float(value) for value in np.exp(x[[0, 1, 2, 4]]))
    return NoiseParts(white, short, drift, float(1.0 / (1.0 + np.exp(-x[3]))), memory)


class Whitening:
    """Filter that transforms rows with coloured noise to rows with white noise of variance 1.

    `noise`: of rows weighted by `root`. `t`, shape (n,). `root`, shape (n_channels, n): weights; 0 for rows that are
    not used. Drift is constant in N, so the weighted drift is proportional to them.
    """

    def __init__(self, noise: tuple[NoiseParts, ...], t: FloatArray, root: FloatArray) -> None:
        present = root > 0.0
        typical = np.sqrt(np.sum(root**2, axis=1) / np.maximum(present.sum(axis=1), 1))
        size = root / np.maximum(typical, 1e-300)[:, None]
        steps = np.diff(t, prepend=t[0])
        typical_step = float(np.median(steps[1:]))
        steps = np.maximum(steps, typical_step)
        steps[0] = BEFORE_START
        decay = np.array(
            [[channel.fading ** (steps / typical_step), np.exp(-steps / channel.memory)] for channel in noise]
        )
        gain, variance = np.empty_like(decay), np.empty(root.shape)
        for i, channel in enumerate(noise):
            gain[i], variance[i] = _kalman_gains(channel, decay[i], size[i], present[i])
        root = np.where(present, 1.0 / np.sqrt(variance), 0.0)
        responses = _responses(*map(_divided, (decay, gain, size)))
        #: Of the innovations of a part, over their standard deviations, and of the states at its end: to the rows of
        #: the part, then to the states at its beginning.
        self._innovations, self._ends = responses[0] * _divided(root)[..., None], responses[1]

    def __call__(self, rows: FloatArray, channels: slice = ALL_CHANNELS) -> FloatArray:
        """Return whitened rows.

        `rows`, shape (n_channels, n, m): weighted. `channels`: those that they are of.
        """
        if rows.ndim == 2:
            return self(rows[:, :, None], channels)[:, :, 0]
        parts, ends = _divided(rows, axis=1), self._ends[channels]
        of_rows, transfer = ends[..., :-2] @ parts, ends[..., -2:]
        begins = np.zeros_like(of_rows)
        for k in range(1, begins.shape[1]):
            begins[:, k] = of_rows[:, k - 1] + transfer[:, k - 1] @ begins[:, k - 1]
        innovations = self._innovations[channels]
        whole = innovations[..., :-2] @ parts
        whole += innovations[..., -2:] @ begins
        return whole.reshape(len(rows), parts.shape[1] * ROWS_OF_PART, rows.shape[2])[:, : rows.shape[1]]


def _responses(decay: FloatArray, gain: FloatArray, size: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how the innovations of each part, and the states at its end, respond to its rows and to the states before.

    `decay`, `gain`, shape (n_channels, 2, n_parts, ROWS_OF_PART): of short-range noise and drift. `size`, shape
    (n_channels, n_parts, ROWS_OF_PART). Returns: shape (n_channels, n_parts, ROWS_OF_PART, ROWS_OF_PART + 2) and
    (n_channels, n_parts, 2, ROWS_OF_PART + 2).
    """
    states = np.zeros((*size.shape[:2], 2, ROWS_OF_PART + 2))
    states[..., -2:] = np.eye(2)
    innovations = np.zeros((*size.shape, ROWS_OF_PART + 2))
    for k in range(ROWS_OF_PART):
        states *= np.moveaxis(decay[:, :, :, k], 1, 2)[..., None]
        new = innovations[:, :, k]
        new[..., k] = 1.0
        new -= states[:, :, 0] + size[:, :, k, None] * states[:, :, 1]
        states += np.moveaxis(gain[:, :, :, k], 1, 2)[..., None] * new[:, :, None]
    return innovations, states


def _kalman_gains(
    noise: NoiseParts, decay: FloatArray, size: FloatArray, present: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Return the gains of both states, shape (2, n), and the variance of each innovation of a channel.

    Plain numbers: a row follows from the one before, and arrays of two states would take ten times as long.
    """
    gains, variances = [], []
    short = cross = drift = 0.0
    for a, b, weight, used in zip(*decay.tolist(), size.tolist(), present.tolist(), strict=True):
        short = a * a * short + noise.short * (1.0 - a * a)
        cross *= a * b
        drift = b * b * drift + noise.drift * (1.0 - b * b)
        seen_short, seen_drift = short + cross * weight, cross + drift * weight
        variance = seen_short + seen_drift * weight + noise.white
        gain = (seen_short / variance, seen_drift / variance) if used else (0.0, 0.0)
        gains.append(gain)
        variances.append(variance)
        short -= gain[0] * seen_short
        cross -= gain[0] * seen_drift
        drift -= gain[1] * seen_drift
    return np.array(gains).T, np.array(variances)


def _divided(rows: FloatArray, axis: int = -1) -> FloatArray:
    """Return a copy with an axis of rows divided into parts and ROWS_OF_PART, the last part filled with 0."""
    axis %= rows.ndim
    before, n, after = rows.shape[:axis], rows.shape[axis], rows.shape[axis + 1 :]
    n_parts = -(-n // ROWS_OF_PART)
    filled = np.zeros((*before, n_parts * ROWS_OF_PART, *after))
    filled[(*(slice(None),) * axis, slice(n))] = rows
    return filled.reshape(*before, n_parts, ROWS_OF_PART, *after)
