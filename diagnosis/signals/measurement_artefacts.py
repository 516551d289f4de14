"""Errors of a recording that no fit removes: ripple once per wheel revolution, quantisation."""

from __future__ import annotations

import numpy as np

from ...numerics.arrays import FloatArray
from ...numerics.wheel_periodicity import once_per_revolution
from ...tires.states.transient import segment_starts
from .signals import Signals


def ripple(signals: Signals, residual: FloatArray, radius: float) -> dict[str, float]:
    """Return the amplitude of the ripple once per wheel revolution, by channel; channels without it are omitted.

    `residual`, shape (n_channels, n): residual of the tire and the slow disturbances, N and N m. `radius`: unloaded
    radius, m; the rolling radius is searched around it (`once_per_revolution`). Returns: N and N m.
    """
    if not signals.timed or "V" not in signals.origin.recorded or len(signals.rows) < 2:
        return {}
    t = signals.t[signals.rows]
    inputs = signals.named()
    speed = inputs["V"] * (1.0 + inputs.get("kappa", 0.0))
    measured = [i for i, there in enumerate(signals.present) if there.any()]
    segment = np.cumsum(segment_starts(t), dtype=np.int64)
    observed = np.where(signals.present, residual, np.nan)[measured]
    wave = once_per_revolution(t, speed, observed, segment, radius)
    if wave is None:
        return {}
    return {
        signals.channels[i]: float(amplitude)
        for i, amplitude, significant in zip(measured, wave.amplitude, wave.significant, strict=True)
        if significant
    }


def quantisation(values: FloatArray) -> float:
    """Return the quantisation step of a channel, 0 if it is not quantised.

    `values`, shape (n,).

    >>> raw = np.random.default_rng(1).normal(0, 100, 2000)
    >>> quantisation(np.round(raw / 2.5) * 2.5), quantisation(raw)
    (2.5, 0.0)
    """
    distinct = np.unique(values[np.isfinite(values)])
    steps = np.diff(distinct)
    steps = steps[steps > 1e-9 * max(float(np.ptp(distinct)), 1e-300)] if len(distinct) > 1 else steps
    if len(steps) < 20:
        return 0.0
    step = float(steps.min())
    multiple = steps / step
    even = np.abs(multiple - np.round(multiple)) < 0.02 * multiple
    return step if np.quantile(multiple, 0.9) < 100.0 and bool(np.mean(even) > 0.98) else 0.0
