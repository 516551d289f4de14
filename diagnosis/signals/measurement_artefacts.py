"""Errors of a recording: disturbances, ripple once per wheel revolution, quantisation, ignored columns."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...measurements import Recording
from ...numerics.arrays import FloatArray
from ...numerics.smoothing import HALF_WIDTHS
from ...numerics.wheel_periodicity import once_per_revolution
from ...symbolic.channels import OUTPUTS
from ...tires.states.transient import segment_starts
from ...tires.tire import Tire
from .disturbances import Disturbances, reported_disturbances
from .predicted_temperature import SURROUNDINGS, TEMPERATURE
from .signals import Signals


def recording_errors(
    recording: Recording, signals: Signals, disturbances: Disturbances, values: FloatArray, residual: FloatArray,
    tire: Tire,
) -> dict[str, Any]:  # fmt: skip
    """Return the disturbances and measurement artefacts of a recording.

    `values`, shape (n_disturbances,): their estimates. `residual`, shape (n_channels, n): residual of the tire and the
    disturbances, N and N m. `tire`: the baseline model. Returns: as `Diagnosis.recording`.
    """
    table = recording.table
    used = {"t", "distance", *tire.inputs, *OUTPUTS, *(SURROUNDINGS if TEMPERATURE in signals.origin.derived else ())}
    waves = [i for i, name in enumerate(disturbances.names) if name.startswith("wave")]
    turning = residual + disturbances.columns[:, :, waves] @ values[waves]
    return reported_disturbances(disturbances, values, signals) | {
        "ripple": ripple(signals, turning, tire.values["UNLOADED_RADIUS"]),
        "quantisation": {name: quantisation(table[name].to_numpy(np.float64)) for name in signals.channels},
        "compared_every": int(np.diff(signals.table_rows).min()),
        "smoothing_windows": [2 * half + 1 for half in HALF_WIDTHS] if any(signals.origin.noise.values()) else [],
        "left_aside": dict(signals.excluded_channels),
        "derived_columns": sorted(signals.origin.derived & set(table)),
        "ignored_columns": [str(name) for name in table if name not in used],
    }


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
