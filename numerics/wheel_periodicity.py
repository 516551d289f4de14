"""Periodicity of residuals with the wheel revolution: runout, imbalance, non-uniformity of the tire.

The rotation angle of the wheel is distance / R_e. The effective rolling radius R_e is estimated: at this radius the
residuals of all channels of a recording have the largest periodic power, averaged over short intervals. The power at
other radii is noise and is subtracted.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import tau

import numpy as np
from scipy.special import chdtri

from .arrays import BoolArray, FloatArray, IntArray
from .ties import graded

#: Length of an interval, s, and largest number of intervals of a recording that are evaluated.
STRETCH, MAX_STRETCHES = 2.5, 60
#: Range of the tested radii, relative to the expected radius, and their number.
RADII, TRIED = (0.5, 1.6), 160
#: Fewest samples per revolution, and fewest revolutions per interval.
MIN_SAMPLES, MIN_TURNS = 4.0, 4.0
#: Fewest rows of an interval, and least share of measured rows of each channel.
MIN_ROWS, MEASURED = 16, 0.8
#: A channel is significantly periodic if the ratio of its power to the median over all radii exceeds `SIGNIFICANT`, and
#: noise exceeds the ratio at any radius with a probability of at most `BY_CHANCE`.
SIGNIFICANT, BY_CHANCE = 5.0, 1e-3


@dataclass(frozen=True, eq=False)
class Periodicity:
    """Periodic part of the channels of a recording once per revolution.

    - `radius`: effective rolling radius, m.
    - `frequency`: mean frequency of the wheel, 1/s.
    - `amplitude`, shape (n_channels,): of the first harmonic, in the channel's unit, without the contribution of noise.
    - `share`, shape (n_channels,): share of the mean squared residual.
    - `significant`, shape (n_channels,): whether the power is significant in comparison with other radii.
    """

    radius: float
    frequency: float
    amplitude: FloatArray
    share: FloatArray
    significant: BoolArray


def once_per_revolution(
    t: FloatArray, speed: FloatArray, residual: FloatArray, segment: IntArray, radius: float
) -> Periodicity | None:
    """Estimate the periodic part of residuals with the wheel revolution.

    `t`, shape (n,): with approximately equal steps within a segment. `speed`, shape (n,): circumferential speed of the
    wheel. `residual`, shape (n_channels, n): NaN for rows that are not used. `segment`, shape (n,): number of the
    segment without gaps of each row. `radius`: expected rolling radius; `RADII` is the search range. Returns: none if
    no interval is long enough for any radius.

    >>> t, rng = np.arange(6000) / 100.0, np.random.default_rng(0)
    >>> turning = 3.0 * np.sin(10.0 * t / 0.2) + rng.standard_normal(6000)
    >>> found = once_per_revolution(t, np.full(6000, 10.0), turning[None], np.zeros(6000, dtype=int), 0.25)
    >>> round(found.radius, 2), found.amplitude.round(1).tolist(), found.significant.tolist()
    (0.2, [3.0], [True])
    """
    step = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    stretches = list(_stretches(speed, residual, segment, step))
    if not stretches:
        return None
    radii = radius * np.geomspace(*RADII, TRIED)
    chosen = stretches[:: -(-len(stretches) // MAX_STRETCHES)]
    power, square, advance = _spectra(chosen, radii)
    finite = np.isfinite(power).all(axis=1)
    if not finite.any():
        return None
    typical = np.median(power[finite], axis=0)
    best = int(np.flatnonzero(finite)[np.argmax(graded((power[finite] / np.maximum(typical, 1e-30)).sum(axis=1)))])
    above = np.maximum(power[best] - typical, 0.0)
    share = np.where(square > 0.0, above / 2.0 / np.where(square > 0.0, square, 1.0), 0.0)
    frequency = float(advance / step / (tau * radii[best]))
    significant = power[best] > _threshold(len(chosen)) * typical
    return Periodicity(float(radii[best]), frequency, np.sqrt(above), share, significant)


def _threshold(stretches: int) -> float:
    """Return the significant ratio of power to its median: noise power is chi-squared, two degrees per interval."""
    by_chance, median = chdtri(2 * stretches, [BY_CHANCE / TRIED, 0.5])
    return max(SIGNIFICANT, float(by_chance / median))


def _stretches(
    speed: FloatArray, residual: FloatArray, segment: IntArray, step: float
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield the rolled distance, shape (n,), and the residuals, shape (n, n_channels), of each interval."""
    length = int(STRETCH / step) if step > 0 else 0
    if length < MIN_ROWS or not len(residual):
        return
    for rows in np.split(np.arange(len(speed)), np.flatnonzero(np.diff(segment)) + 1):
        for start in range(0, len(rows) - length + 1, length):
            piece = rows[start : start + length]
            mask = np.isfinite(residual[:, piece])
            if np.all(speed[piece] > 0) and mask.mean(axis=1).min() >= MEASURED:
                complete = [
                    values if finite.all() else np.interp(piece, piece[finite], values[finite])
                    for values, finite in zip(residual[:, piece], mask, strict=True)
                ]
                yield np.cumsum(speed[piece]) * step, np.stack(complete, axis=1)


def _spectra(stretches: list[tuple[FloatArray, FloatArray]], radii: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return the mean squared amplitude by radius and channel, the mean square, and the distance per row."""
    channels = stretches[0][1].shape[1]
    power, square, advances = np.zeros((len(radii), channels)), np.zeros(channels), 0.0
    for distance, residual in stretches:
        advance = float(distance[-1] - distance[0]) / (len(distance) - 1)
        too_fast = tau * radii < MIN_SAMPLES * advance
        too_slow = tau * radii * MIN_TURNS > distance[-1] - distance[0]
        window = np.hanning(len(distance))
        position = distance - distance.mean()
        slow = np.vander(position / position[-1], 3)
        centred = (residual - slow @ np.linalg.lstsq(slow, residual, rcond=None)[0]) * window[:, None]
        turning = np.exp(-1j * position / radii[:, None])
        power += np.abs(2.0 * turning @ centred / window.sum()) ** 2
        power[too_fast | too_slow] = np.nan
        square += np.mean(residual**2, axis=0)
        advances += advance
    count = len(stretches)
    return power / count, square / count, advances / count
