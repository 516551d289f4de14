"""The table of a fit load by load: error, friction and slip stiffness of each force, and the errors of both."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import nan, sqrt

import numpy as np

from ..evidence.characteristics import Characteristic
from ..evidence.slip_stiffness import FORCES, SlipStiffness
from ..results.fit_result import FitResult

#: Loads of different readings that belong together, relative difference.
SAME_LOAD = 0.08


@dataclass(frozen=True)
class LoadRow:
    """A force at one load, averaged over the other conditions.

    - `rmse`, `above_floor`: root mean square error, and the same over the noise floor of the channel.
    - `friction`, `friction_error`: of the data, and relative error of the tire; NaN if not read.
    - `stiffness`, `stiffness_error`: the same of the slip stiffness.
    """

    recording: str
    channel: str
    unit: str
    load: float
    rmse: float
    above_floor: float
    friction: float = nan
    friction_error: float = nan
    stiffness: float = nan
    stiffness_unit: str = ""
    stiffness_error: float = nan


def load_rows(result: FitResult) -> Iterator[LoadRow]:
    """Yield each force of each recording at each measured load; nothing with one load."""
    findings = result.findings
    for c in result.channels:
        if c.channel not in FORCES.values():
            continue
        conditions = [
            condition
            for condition in findings.conditions
            if (condition.recording, condition.channel) == (c.recording, c.channel)
        ]
        for load in sorted({condition.at["Fz"] for condition in conditions if "Fz" in condition.at}, key=abs):
            here = [condition for condition in conditions if condition.at["Fz"] == load]
            rmse = sqrt(
                sum(condition.rows * condition.rmse**2 for condition in here)
                / sum(condition.rows for condition in here)
            )
            frictions = [
                characteristic for characteristic in findings.characteristics
                if characteristic.quantity == "peak friction" and characteristic.shown
                and _belongs(characteristic, c.recording, c.channel, load)
            ]  # fmt: skip
            slopes = [
                slip_stiffness
                for slip_stiffness in findings.stiffnesses
                if _belongs(slip_stiffness, c.recording, c.channel, load)
            ]
            friction, friction_error = _mean(frictions)
            stiffness, stiffness_error = _mean(slopes)
            unit = slopes[0].unit if slopes else ""
            ratio = rmse / c.noise_floor if c.noise_floor > 0.0 else nan
            yield LoadRow(
                c.recording, c.channel, c.unit, abs(load), rmse, ratio, friction, friction_error,
                stiffness, unit, stiffness_error,
            )  # fmt: skip


def _belongs(read: Characteristic | SlipStiffness, recording: str, channel: str, load: float) -> bool:
    return (read.recording, read.channel) == (recording, channel) and abs(read.load / abs(load) - 1.0) < SAME_LOAD


def _mean(read: list[Characteristic] | list[SlipStiffness]) -> tuple[float, float]:
    """Return the mean of the data and the relative error of the mean of the tire."""
    if not read:
        return nan, nan
    data, tire = (float(np.mean([getattr(row, name) for row in read])) for name in ("read", "fitted"))
    return data, tire / data - 1.0
