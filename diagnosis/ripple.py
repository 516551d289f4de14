"""Traces of the bench in a channel: a ripple once per revolution, and steps of quantisation."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tirefmu.tires.transient import rolled_distance

from .recording.signals import Signals

FloatArray = npt.NDArray[np.float64]

#: Radii tried, as shares of the unloaded one: rolling radii; and beside them, what noise does at no revolution.
ROLLING = np.linspace(0.92, 1.06, 15)
BESIDE = np.concatenate([np.linspace(0.72, 0.86, 8), np.linspace(1.13, 1.3, 8)])
#: Revolutions over which the phase is held: no radius is known better.
REVOLUTIONS = 12.0
FEWEST_ROWS = 40
#: The ripple's power over that beside it.
STANDS_OUT = 3.0


def ripple(signals: Signals, residual: FloatArray, radius: float) -> dict[str, float]:
    """Return the amplitude of what turns once with the wheel, by channel; channels without it are left out.

    Parameters
    ----------
    signals : Signals
    residual : ndarray, shape (n_channels, n)
        What the tire and slow disturbances leave, N and N m.
    radius : float
        Unloaded, m; the rolling radius is sought about it.

    Returns
    -------
    dict of str to float
        N and N m.
    """
    if not signals.timed or "V" not in signals.recorded:
        return {}
    rows = signals.rows
    distance = rolled_distance(signals.t, signals.inputs[signals.names.index("V")])[rows]
    t = signals.t[rows]
    usual = float(np.median(np.diff(t)))
    turn = np.floor(distance / (2.0 * np.pi * radius * REVOLUTIONS))
    run = np.cumsum(np.diff(t, prepend=t[0]) > 5.0 * usual)
    window = np.unique(np.stack([turn, run]), axis=1, return_inverse=True)[1].ravel()
    told = {}
    for name, rest, there in zip(signals.channels, residual, signals.present, strict=True):
        power = [_power(rest, there, window, distance / (radius * share)) for share in (*ROLLING, *BESIDE)]
        most, beside = max(power[: len(ROLLING)]), float(np.median(power[len(ROLLING) :]))
        if most > STANDS_OUT * beside > 0.0:
            told[name] = float(np.sqrt(most - beside))
    return told


def _power(
    rest: FloatArray, there: npt.NDArray[np.bool_], window: npt.NDArray[np.int64], angle: FloatArray
) -> float:  # fmt: skip
    """Return the mean squared amplitude of a wave of that angle, fitted window by window."""
    use = there & (np.bincount(window, weights=there)[window] >= FEWEST_ROWS)
    if not use.any():
        return 0.0
    at, count = window[use], np.bincount(window[use])
    full = count > 0
    level = np.where(full, np.bincount(at, weights=rest[use]) / np.maximum(count, 1), 0.0)
    wave = (rest[use] - level[at]) * np.exp(1j * angle[use])
    size = [np.bincount(at, weights=part) for part in (wave.real, wave.imag)]
    return float(np.mean((2.0 * np.hypot(*size)[full] / count[full]) ** 2))


def quantisation(values: FloatArray) -> float:
    """Return the step of a quantised channel, 0 where there is none.

    Parameters
    ----------
    values : ndarray, shape (n,)

    Examples
    --------
    >>> raw = np.random.default_rng(1).normal(0, 100, 2000)
    >>> quantisation(np.round(raw / 2.5) * 2.5), quantisation(raw)
    (2.5, 0.0)
    """
    known = np.unique(values[np.isfinite(values)])
    steps = np.diff(known)
    steps = steps[steps > 1e-9 * max(float(np.ptp(known)), 1e-300)] if len(known) > 1 else steps
    if len(steps) < 20:
        return 0.0
    step = float(steps.min())
    multiple = steps / step
    even = np.abs(multiple - np.round(multiple)) < 0.02 * multiple
    return step if np.quantile(multiple, 0.9) < 100.0 and bool(np.mean(even) > 0.98) else 0.0
