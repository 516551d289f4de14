"""The table of a fit load by load: error, friction and slip stiffness of each force, and the errors of both.

Errors are those of single operating conditions: their means would cancel.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import nan, sqrt

import numpy as np

from ..checks.characteristics import Characteristic
from ..checks.diagnostics import Findings
from ..checks.slip_stiffness import FORCES, SlipStiffness
from ..results.fitted import Fitted

#: Loads of different readings that belong together, relative difference.
SAME_LOAD = 0.08


@dataclass(frozen=True)
class LoadRow:
    """A force at one load.

    - `rmse`, `above_floor`: root mean square error, and the same over the noise floor of the channel.
    - `friction`: peak friction in the conditions at this load.
    - `stiffness`: slip stiffness in these.
    """

    recording: str
    channel: str
    unit: str
    load: float
    rmse: float
    above_floor: float
    friction: Spread | None = None
    stiffness: Spread | None = None


@dataclass(frozen=True)
class Spread:
    """A quantity in the operating conditions at one load.

    - `read`, `fitted`: means of the data and of the tire, in `unit`.
    - `errors`: smallest and largest relative error of the tire in one condition.
    """

    conditions: int
    unit: str
    read: float
    fitted: float
    errors: tuple[float, float]

    @property
    def error_text(self) -> str:
        """The range of the errors.

        >>> Spread(2, "N", 1.0, 1.0, (-0.064, 0.052)).error_text, Spread(1, "N", 1.0, 1.1, (0.1, 0.1)).error_text
        ('-6.4 to +5.2 %', '+10.0 %')
        """
        low, high = (f"{100.0 * error:+.1f}" for error in self.errors)
        return f"{low} %" if low == high else f"{low} to {high} %"


def stiffness_by_load(findings: Findings) -> Iterator[tuple[str, str, float, Spread]]:
    """Yield recording, force, load and slip stiffness, over the conditions at each load."""
    by_load: dict[tuple[str, str, float], list[SlipStiffness]] = {}
    for stiffness in findings.stiffnesses:
        key = stiffness.recording, stiffness.channel, abs(stiffness.at.get("Fz", stiffness.load))
        by_load.setdefault(key, []).append(stiffness)
    for (recording, channel, load), stiffnesses in by_load.items():
        spread = _spread(stiffnesses)
        if spread is not None:
            yield recording, channel, load, spread


def load_rows(result: Fitted) -> Iterator[LoadRow]:
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
            ratio = rmse / c.noise_floor if c.noise_floor > 0.0 else nan
            yield LoadRow(
                c.recording, c.channel, c.unit, abs(load), rmse, ratio, _spread(frictions), _spread(slopes)
            )  # fmt: skip


def _belongs(read: Characteristic | SlipStiffness, recording: str, channel: str, load: float) -> bool:
    return (read.recording, read.channel) == (recording, channel) and abs(read.load / abs(load) - 1.0) < SAME_LOAD


def _spread(read: Sequence[Characteristic] | Sequence[SlipStiffness]) -> Spread | None:
    """Return the quantity over some conditions; None if it was read in none."""
    if not read:
        return None
    means = [float(np.mean([getattr(entry, name) for entry in read])) for name in ("read", "fitted")]
    errors = [entry.off for entry in read]
    return Spread(len(read), read[0].unit, means[0], means[1], (min(errors), max(errors)))
