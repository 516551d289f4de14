"""Ripple of the residuals once per wheel revolution, for each recording."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import nan

import numpy as np

from ...numerics.wheel_periodicity import once_per_revolution
from .residuals import Residuals


@dataclass(frozen=True)
class Ripple:
    """Ripple of a channel of a recording once per wheel revolution.

    - `amplitude`: of the first harmonic, in the channel's unit, without the contribution of noise.
    - `share`: share of the mean squared residual.
    - `frequency`: mean frequency of the wheel, 1/s.
    - `radius`: rolling radius at which the residuals repeat, m.
    - `stands_out`: whether it is significant in comparison with other periods.
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
    """Return the ripple of each recording and channel.

    Returns: one for each recording and channel; empty if the data have no time or no speed.
    """
    radius = residuals.tire.values.get("UNLOADED_RADIUS", nan)
    if not {"t", "V"} <= set(residuals.table.columns) or not radius > 0:
        return ()
    return tuple(
        ripple_of_recording
        for number in range(len(residuals.sources))
        for ripple_of_recording in _of_recording(residuals, number, radius)
    )


def _of_recording(residuals: Residuals, number: int, radius: float) -> Iterator[Ripple]:
    rows = residuals.recording == number
    channels = [name for name in residuals.channels if np.isfinite(residuals.measured_minus_computed[name][rows]).any()]
    if not channels:
        return
    t, speed = (residuals.table[name].to_numpy(dtype=float)[rows] for name in ("t", "V"))
    if "kappa" in residuals.table:
        speed = speed * (1.0 + residuals.table["kappa"].to_numpy(dtype=float)[rows])
    values = np.stack([residuals.measured_minus_computed[name][rows] for name in channels])
    periodic = once_per_revolution(t, speed, values, residuals.segment[rows], radius)
    if periodic is None:
        return
    for i, channel in enumerate(channels):
        yield Ripple(
            residuals.sources[number], channel, residuals.units[channel],
            float(periodic.amplitude[i]), float(periodic.share[i]),
            periodic.frequency, periodic.radius, bool(periodic.significant[i]),
        )  # fmt: skip
