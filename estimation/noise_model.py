"""Noise model of a recording (white noise, short-range noise and slow drift), and the filter that whitens it.

Drift at the rate of the sweeps increases the variance of ordinary least squares more than all short-range noise.
Generalised least squares takes its correlation into account. The parameters are estimated from the periodogram of the
residual (Whittle, Estimation and information in stationary time series, 1953). The whitened rows are the innovations of
a Kalman filter, which bridges unused rows (Harvey, Forecasting, Structural Time Series Models and the Kalman Filter,
1989, section 3.4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import fft, optimize

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

#: Initial correlation times of drift for the fit to a periodogram, and their bounds, s.
DRIFT_TIMES = (0.5, 2.0, 8.0)
SHORTEST, LONGEST = 0.3, 60.0
#: Prior of the share of white noise: its value, and its weight (in log variances, relative to one row).
WHITE_SHARE, WHITE_PRIOR = 0.05, 1e-3
#: Lower limit of the mean square of a weighted residual.
LEAST_POWER = 1e-6
#: Time before the first row, s: much longer than any correlation.
BEFORE_START = 1e9


@dataclass(frozen=True)
class NoiseParts:
    """The noise of a channel in three parts.

    Attributes
    ----------
    white, short, drift : float
        Variances, in the squared unit of the residual.
    fading : float
        Correlation of the short-range part from one row to the next.
    memory : float, s
        Time over which the drift's correlation falls to 1/e.
    """

    white: float
    short: float
    drift: float
    fading: float
    memory: float


def noise_parts(residual: FloatArray, present: BoolArray, step: float) -> NoiseParts:
    """Estimate the noise of a channel from its residual.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        At approximately equal time steps.
    present : ndarray of bool, shape (n,)
        False for rows that are not used.
    step : float, s

    Returns
    -------
    NoiseParts

    Examples
    --------
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
    whole = max(float(np.sum(rows**2)) / max(int(present.sum()), 1), LEAST_POWER)

    def parts(x: FloatArray) -> NoiseParts:
        white, short, drift, memory = (float(value) for value in np.exp(x[[0, 1, 2, 4]]))
        return NoiseParts(white * whole, short * whole, drift * whole, float(1.0 / (1.0 + np.exp(-x[3]))), memory)

    def loss(x: FloatArray) -> float:
        spectrum = _spectrum(parts(x), wave, step)
        prior = WHITE_PRIOR * float(x[0] - np.log(WHITE_SHARE)) ** 2
        return float(np.mean(np.log(spectrum / whole) + power / spectrum)) + prior

    bounds = [(-9.0, 0.0), (-7.0, 0.7), (-13.0, 1.1), (-4.0, 3.0), (np.log(SHORTEST), np.log(LONGEST))]
    solutions = [
        optimize.minimize(
            loss, [np.log(WHITE_SHARE), -0.2, -2.3, 0.0, np.log(memory)], method="L-BFGS-B", bounds=bounds
        )
        for memory in DRIFT_TIMES
    ]
    return parts(min(solutions, key=lambda one: float(one.fun)).x)


def _spectrum(noise: NoiseParts, wave: FloatArray, step: float) -> FloatArray:
    """Return the power at frequencies with the cosine `wave` of the phase per row."""
    total = np.full_like(wave, noise.white)
    for variance, decay in ((noise.short, noise.fading), (noise.drift, float(np.exp(-step / noise.memory)))):
        total += variance * (1.0 - decay**2) / (1.0 - 2.0 * decay * wave + decay**2)
    return total


class Whitening:
    """Filter that transforms rows with coloured noise to rows with white noise of variance 1.

    Parameters
    ----------
    noise : sequence of NoiseParts, one a channel
        Of rows weighted by `root`.
    t : ndarray, shape (n,), s
    root : ndarray, shape (n_channels, n)
        Weights; 0 for rows that are not used. Drift is constant in N, so the weighted drift is proportional to them.
    """

    def __init__(self, noise: tuple[NoiseParts, ...], t: FloatArray, root: FloatArray) -> None:
        present = root > 0.0
        typical = np.sqrt(np.sum(root**2, axis=1) / np.maximum(present.sum(axis=1), 1))
        self._size = np.ascontiguousarray((root / np.maximum(typical, 1e-300)[:, None]).T)
        steps = np.diff(t, prepend=t[0])
        typical_step = float(np.median(steps[1:]))
        steps = np.maximum(steps, typical_step)
        steps[0] = BEFORE_START
        fading, memory = np.array([one.fading for one in noise]), np.array([one.memory for one in noise])
        self._decay = np.stack([fading ** (steps[:, None] / typical_step), np.exp(-steps[:, None] / memory)], axis=1)
        self._gain = np.zeros_like(self._decay)
        variance = np.ones(self._size.shape)
        white, start = np.array([one.white for one in noise]), np.array([[one.short, one.drift] for one in noise]).T
        state = np.zeros((2, 2, len(noise)))
        for k, (decay, size) in enumerate(zip(self._decay, self._size, strict=True)):
            state = decay[:, None] * state * decay[None, :]
            state[0, 0] += start[0] * (1.0 - decay[0] ** 2)
            state[1, 1] += start[1] * (1.0 - decay[1] ** 2)
            seen = state[:, 0] + state[:, 1] * size
            variance[k] = seen[0] + seen[1] * size + white
            self._gain[k] = np.where(present[:, k], seen / variance[k], 0.0)
            state = state - self._gain[k][:, None] * seen[None, :]
        self._root = np.where(present, 1.0 / np.sqrt(variance.T), 0.0)

    def __call__(self, rows: FloatArray) -> FloatArray:
        """Return whitened rows.

        Parameters
        ----------
        rows : ndarray, shape (n_channels, n, m) or (n_channels, n)
            Weighted.
        """
        if rows.ndim == 2:
            return self(rows[:, :, None])[:, :, 0]
        given = np.ascontiguousarray(rows.transpose(1, 0, 2))
        innovation = np.empty_like(given)
        short, drift = np.zeros(given.shape[1:]), np.zeros(given.shape[1:])
        decay, gain, size = self._decay[..., None], self._gain[..., None], self._size[..., None]
        for k in range(len(given)):
            short *= decay[k, 0]
            drift *= decay[k, 1]
            new = given[k] - short - size[k] * drift
            innovation[k] = new
            short += gain[k, 0] * new
            drift += gain[k, 1] * new
        return np.asarray(innovation.transpose(1, 0, 2) * self._root[:, :, None])
