"""Diagnostics of a fit: residuals by operating condition, identifiability, inconsistent data.

They are computed at the first access, so they cost nothing if they are not used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...measurements.checks.recordings.coverage import ChannelCoverage
from ...numerics.ties import graded
from .characteristics import Characteristic, characteristics
from .clipping import Clipped, clipped_channels
from .consistency import Disagreement, disagreeing_files, disagreeing_segments, sweep_differences
from .continuity import Discontinuity, discontinuities
from .coverage import coverage
from .residuals import Residuals
from .ripple import Ripple, ripple
from .slip_stiffness import SlipStiffness, slip_stiffnesses
from .undetermined import Undetermined, at_bounds, undetermined

#: Fewest rows of an operating condition that is reported.
MIN_ROWS = 20


@dataclass(frozen=True)
class ConditionFit:
    """Goodness of fit of a channel in one operating condition of a recording.

    - `at`: the levels of inputs with several levels: load, inclination, pressure.
    - `rmse`, `mean`: root mean square and mean of measured minus computed.
    """

    recording: str
    channel: str
    unit: str
    at: dict[str, float]
    rows: int
    rmse: float
    mean: float


@dataclass(frozen=True)
class Findings:
    """Diagnostics of a fit.

    Attributes
    ----------
    conditions : tuple of ConditionFit
        Goodness of fit at each operating condition.
    stiffnesses : tuple of SlipStiffness
        Slip stiffness, measured and computed, in each operating condition.
    characteristics : tuple of Characteristic
        Peak friction, its slip, and trail, measured and computed, in each operating condition.
    discontinuities : tuple of Discontinuity
        Jumps and kinks of the tire over the tested slips.
    clipped : tuple of Clipped
        Channels that are cut off at the end of a sensor's range.
    coverage : tuple of ChannelCoverage
        What the rows determine of the tire, and what they never show.
    undetermined : tuple of Undetermined
        Coefficients that the data do not determine, with the reason.
    files, segments, sweeps : tuple of Disagreement
        Differences between recordings, between segments of one operating condition, between up- and down-sweeps.
    ripples : tuple of Ripple
        Residuals that repeat with each revolution of the wheel.
    """

    conditions: tuple[ConditionFit, ...] = ()
    stiffnesses: tuple[SlipStiffness, ...] = ()
    characteristics: tuple[Characteristic, ...] = ()
    discontinuities: tuple[Discontinuity, ...] = ()
    clipped: tuple[Clipped, ...] = ()
    coverage: tuple[ChannelCoverage, ...] = ()
    undetermined: tuple[Undetermined, ...] = ()
    files: tuple[Disagreement, ...] = ()
    segments: tuple[Disagreement, ...] = ()
    sweeps: tuple[Disagreement, ...] = ()
    ripples: tuple[Ripple, ...] = ()

    def worst(self, recording: str, channel: str) -> ConditionFit | None:
        """Return the operating condition with the largest error of a channel; None if there is only one."""
        conditions = [
            condition
            for condition in self.conditions
            if (condition.recording, condition.channel) == (recording, channel)
        ]
        return max(conditions, key=lambda condition: graded(condition.rmse)) if len(conditions) > 1 else None


def find(
    residuals: Residuals,
    free: Sequence[str],
    sets: Sequence[tuple[str, ...]],
    bounded: Sequence[str],
    effective: Mapping[str, float],
) -> Findings:
    """Compute the diagnostics of a fit.

    `free`: the free coefficients. `sets`: sets of them that are not identifiable. `bounded`: coefficients at a bound;
    among `free` as well if it is not known. `effective`: effective sample size of each channel.
    """
    reasons = undetermined(residuals, free, sets, effective)
    reasons += at_bounds(residuals, list(dict.fromkeys((*free, *bounded))), bounded, effective)
    return Findings(
        by_condition(residuals), slip_stiffnesses(residuals), characteristics(residuals), discontinuities(residuals),
        clipped_channels(residuals), coverage(residuals), reasons,
        disagreeing_files(residuals), disagreeing_segments(residuals), sweep_differences(residuals), ripple(residuals),
    )  # fmt: skip


def by_condition(residuals: Residuals) -> tuple[ConditionFit, ...]:
    """Return the goodness of fit of each channel and recording by operating condition.

    Returns: empty if no input has several levels.
    """
    if not residuals.levels:
        return ()
    records = []
    for number, source in enumerate(residuals.sources):
        for channel in residuals.channels:
            values = residuals.measured_minus_computed[channel]
            here = np.flatnonzero((residuals.recording == number) & np.isfinite(values))
            conditions, index = np.unique(residuals.condition[here], return_inverse=True)
            rows = np.bincount(index, minlength=len(conditions))
            squares, sums = (
                np.bincount(index, weights, len(conditions)) for weights in (values[here] ** 2, values[here])
            )
            for k in np.flatnonzero(rows >= MIN_ROWS):
                rmse, mean = float(np.sqrt(squares[k] / rows[k])), residuals.sign(channel) * float(sums[k] / rows[k])
                at = residuals.at(int(conditions[k]))
                records.append(ConditionFit(source, channel, residuals.units[channel], at, int(rows[k]), rmse, mean))
    return tuple(records)
