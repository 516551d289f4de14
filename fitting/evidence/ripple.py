"""What repeats with the wheel's revolution: runout, imbalance, non-uniformity of the tire.

The wheel turns by V (1 + kappa) / R_e, and R_e is looked for in each recording: the radius at which what the fit
misses repeats best, in short stretches, over all channels together. What stretches show at other radii is noise, and
is taken off.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import nan, tau

import numpy as np
import numpy.typing as npt

from .residuals import Residuals

FloatArray = npt.NDArray[np.float64]

#: How long a stretch is, and how many at most are looked at in a recording.
STRETCH, MOST_STRETCHES = 2.5, 60
#: The radii that are tried, as shares of the tire's own, and how many.
RADII, TRIED = (0.5, 1.6), 160
#: The fewest samples in a revolution, and revolutions in a stretch.
FEWEST_SAMPLES, FEWEST_TURNS = 4.0, 4.0
#: The fewest rows of a stretch.
SHORTEST = 16
#: A ripple stands out where its power is this many times what the other radii show (median).
STANDS_OUT = 5.0


@dataclass(frozen=True)
class Ripple:
    """What a channel of a recording does once per revolution.

    Attributes
    ----------
    recording, channel, unit : str
    amplitude : float
        Of the first harmonic, in the channel's unit, without what noise adds.
    share : float
        Of the mean square that the fit misses.
    frequency : float
        1/s, of the wheel, on average.
    radius : float
        m, at which it repeats.
    stands_out : bool
        Whether it is more than other periods show.
    """

    recording: str
    channel: str
    unit: str
    amplitude: float
    share: float
    frequency: float
    radius: float
    stands_out: bool


def ripple(residuals: Residuals) -> tuple[Ripple, ...]:
    """Look for what repeats with the wheel's revolution.

    Parameters
    ----------
    residuals : Residuals

    Returns
    -------
    tuple of Ripple
        One for each recording and channel; none where the data have no clock or no speed.
    """
    own = residuals.tire.values.get("UNLOADED_RADIUS", nan)
    if not {"t", "V"} <= set(residuals.table.columns) or not own > 0:
        return ()
    radii = own * np.geomspace(*RADII, TRIED)
    return tuple(each for number in range(len(residuals.sources)) for each in _of_recording(residuals, number, radii))


def _of_recording(residuals: Residuals, number: int, radii: FloatArray) -> Iterator[Ripple]:
    """Yield the ripple of each channel of a recording."""
    here = residuals.recording == number
    channels = [name for name in residuals.channels if np.isfinite(residuals.missed[name][here]).any()]
    stretches = list(_stretches(residuals, here, channels))
    if not stretches:
        return
    power, square, speed = _spectra(stretches[:: -(-len(stretches) // MOST_STRETCHES)], radii)
    known = np.isfinite(power).all(axis=1)
    if not known.any():
        return
    usual = np.median(power[known], axis=0)
    best = int(np.flatnonzero(known)[np.argmax((power[known] / np.maximum(usual, 1e-30)).sum(axis=1))])
    above = np.maximum(power[best] - usual, 0.0)
    seconds = float(np.median(np.diff(residuals.table["t"].to_numpy(dtype=float)[here])))
    units = {output.name: output.unit for output in residuals.tire.book.outputs}
    for i, channel in enumerate(channels):
        yield Ripple(
            residuals.sources[number], channel, units[channel], float(above[i] ** 0.5),
            float(above[i] / 2.0 / square[i]) if square[i] > 0 else 0.0, float(speed / seconds / (tau * radii[best])),
            float(radii[best]), bool(power[best, i] > STANDS_OUT * usual[i]),
        )  # fmt: skip


def _spectra(stretches: list[tuple[FloatArray, FloatArray]], radii: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return the mean squared amplitude by radius and channel, the mean square missed, and the way from row to row."""
    channels = stretches[0][1].shape[1]
    power, square, advances = np.zeros((len(radii), channels)), np.zeros(channels), 0.0
    for way, missed in stretches:
        advance = float(way[-1] - way[0]) / (len(way) - 1)
        too_fast = tau * radii < FEWEST_SAMPLES * advance
        too_slow = tau * radii * FEWEST_TURNS > way[-1] - way[0]
        window = np.hanning(len(way))
        place = way - way.mean()
        slow = np.vander(place / place[-1], 3)
        centred = (missed - slow @ np.linalg.lstsq(slow, missed, rcond=None)[0]) * window[:, None]
        turning = np.exp(-1j * place / radii[:, None])
        power += np.abs(2.0 * turning @ centred / window.sum()) ** 2
        power[too_fast | too_slow] = np.nan
        square += np.mean(missed**2, axis=0)
        advances += advance
    count = len(stretches)
    return power / count, square / count, advances / count


def _stretches(
    residuals: Residuals, here: npt.NDArray[np.bool_], channels: list[str]
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield the way that the wheel rolled, shape (n,), and what was missed on it, shape (n, n_channels)."""
    t, speed = (residuals.table[name].to_numpy(dtype=float) for name in ("t", "V"))
    if "kappa" in residuals.table:
        speed = speed * (1.0 + residuals.table["kappa"].to_numpy(dtype=float))
    missed = np.stack([residuals.missed[name] for name in channels], axis=1) if channels else np.zeros((len(t), 0))
    usual = float(np.median(np.diff(t[here]))) if here.sum() > 1 else 0.0
    length = int(STRETCH / usual) if usual > 0 else 0
    if length < SHORTEST or not channels:
        return
    rows = np.flatnonzero(here)
    for segment in np.split(rows, np.flatnonzero(np.diff(residuals.segment[rows])) + 1):
        for start in range(0, len(segment) - length + 1, length):
            piece = segment[start : start + length]
            if np.all(speed[piece] > 0) and np.isfinite(missed[piece]).all():
                yield np.cumsum(speed[piece]) * usual, missed[piece]
