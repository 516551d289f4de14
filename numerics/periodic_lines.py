"""Periodic disturbances of a recording at any frequency in time or any wavelength in distance.

A line is a narrow peak in the spectrum of a residual: a wave with constant frequency and phase over the whole
recording (an imbalance, the texture of a road, mains hum). A tire responds to the frequencies of its inputs, so that a
peak that the simulated forces have as well is not a disturbance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import fft
from scipy.ndimage import median_filter

from .arrays import BoolArray, FloatArray
from .ties import graded

#: Largest number of lines of a recording.
MAX_LINES = 4
#: Probability that the spectrum of noise has such a peak at any frequency.
BY_CHANCE = 1e-6
#: Least share of the mean squared residual of a channel.
MIN_SHARE = 0.03
#: Half width of the neighborhood of a peak, in independent frequencies.
NEIGHBORHOOD = 20
#: Zero padding: number of frequencies for each independent one.
FINER = 4
#: Fewest periods in the recording, and fewest samples per period.
MIN_PERIODS, MIN_SAMPLES = 20.0, 2.5
#: A peak of the simulated forces is one that exceeds its neighborhood by this factor.
SIMULATED_PEAK = 8.0


@dataclass(frozen=True)
class PeriodicLine:
    """A periodic disturbance.

    - `over`: "t" or "distance".
    - `frequency`: in 1/s or 1/m.
    """

    over: str
    frequency: float

    def waves(self, at: FloatArray) -> FloatArray:
        """Return cosine and sine, shape (2, n).

        `at`, shape (n,): time, s, or distance, m.
        """
        phase = 2.0 * np.pi * self.frequency * at
        return np.stack([np.cos(phase), np.sin(phase)])


def periodic_lines(
    axes: dict[str, FloatArray], residual: FloatArray, present: BoolArray, simulated: FloatArray
) -> list[PeriodicLine]:
    """Return the lines of residuals, the largest first.

    `axes`, shape (n,): time and distance rolled ("t", "distance"), ascending. `residual`, shape (n_channels, n).
    `present`, shape (n_channels, n): false for rows that are not used. `simulated`, shape (n_channels, n): forces of
    the model.

    >>> t, rng = np.arange(4000) / 50.0, np.random.default_rng(0)
    >>> force = 100.0 * np.sin(0.7 * t)
    >>> rest = rng.standard_normal(4000) + np.sin(2.0 * np.pi * 4.9 * t)
    >>> lines = periodic_lines({"t": t}, rest[None], np.ones((1, 4000), dtype=bool), force[None])
    >>> [(line.over, round(line.frequency, 2)) for line in lines]
    [('t', 4.9)]
    """
    rest = np.where(present, residual, 0.0)
    lines: list[PeriodicLine] = []
    while len(lines) < MAX_LINES:
        peaks = [peak for over, at in axes.items() if (peak := _largest_peak(over, at, rest, simulated)) is not None]
        if not peaks:
            break
        _, line = max(peaks, key=lambda peak: graded(peak[0]))
        waves = line.waves(axes[line.over])
        amplitudes = np.linalg.lstsq(waves.T, rest.T, rcond=None)[0].T
        waved = np.where(present, amplitudes @ waves, 0.0)
        share = np.mean(waved**2, axis=1) / np.maximum(np.mean(rest**2, axis=1), 1e-300)
        if share.max() < MIN_SHARE:
            break
        lines.append(line)
        rest = rest - waved
    return lines


def _largest_peak(
    over: str, at: FloatArray, rest: FloatArray, simulated: FloatArray
) -> tuple[float, PeriodicLine] | None:
    """Return the largest significant peak and its ratio to the neighborhood, or None."""
    steps = np.diff(at)
    step = float(np.median(steps[steps > 0.0])) if np.any(steps > 0.0) else 0.0
    if step <= 0.0 or len(at) < 100:
        return None
    n = int((at[-1] - at[0]) / step) + 1
    if n > 20 * len(at):
        return None
    grid = at[0] + step * np.arange(n)
    size = fft.next_fast_len(FINER * n)
    frequency = fft.rfftfreq(size, step)
    power, forced = (_ratios(_resampled(grid, at, rows), size) for rows in (rest, simulated))
    usable = (frequency * (at[-1] - at[0]) > MIN_PERIODS) & (frequency * step * MIN_SAMPLES < 1.0)
    if not usable.any():
        return None
    unforced = np.all(_widest(forced) < SIMULATED_PEAK, axis=0)
    score = np.where(usable & unforced, power.max(axis=0), 0.0)
    best = int(np.argmax(graded(score)))
    threshold = np.log2(len(rest) * max(int(usable.sum()) / FINER, 1.0) / BY_CHANCE)
    return (float(score[best]), PeriodicLine(over, float(frequency[best]))) if score[best] > threshold else None


def _resampled(grid: FloatArray, at: FloatArray, rows: Sequence[FloatArray] | FloatArray) -> FloatArray:
    """Return rows at equal steps, without their mean, and tapered at both ends."""
    values = np.stack([np.interp(grid, at, row) for row in rows])
    return np.asarray((values - values.mean(axis=1, keepdims=True)) * np.hanning(len(grid)))


def _ratios(rows: FloatArray, size: int) -> FloatArray:
    """Return the power at each frequency relative to the median of its neighborhood."""
    power = np.abs(fft.rfft(rows, size, axis=1)) ** 2
    width = 2 * NEIGHBORHOOD * FINER + 1
    typical = np.stack([median_filter(row, size=width, mode="nearest") for row in power])
    return np.asarray(power / np.maximum(typical, 1e-12 * power.max(axis=1, keepdims=True) + 1e-300))


def _widest(ratios: FloatArray) -> FloatArray:
    """Return the largest ratio within one independent frequency."""
    shifted = [np.roll(ratios, k, axis=1) for k in range(-FINER, FINER + 1)]
    return np.asarray(np.max(shifted, axis=0))
