"""What the data say of a finished fit: where it misses, what the data leave open, and where they contradict themselves.

Reckoned when first asked for: a fit in a loop need not pay for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .consistency import Disagreement, disagreeing_files, disagreeing_segments, sweep_differences
from .residuals import Residuals
from .ripple import Ripple, ripple
from .slip_stiffness import SlipStiffness, slip_stiffnesses
from .undetermined import Undetermined, at_bounds, undetermined

#: Rows from which a condition is told by itself.
FEWEST_ROWS = 20


@dataclass(frozen=True)
class ConditionFit:
    """How well a channel is met in one held condition of a recording.

    Attributes
    ----------
    recording, channel, unit : str
    at : dict of str to float
        The levels of what was held at several: load, inclination, pressure.
    rows : int
    rmse, mean : float
        Root mean square and mean of measured less computed.
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
    """What the data say of a fit.

    Attributes
    ----------
    conditions : tuple of ConditionFit
    stiffnesses : tuple of SlipStiffness
    undetermined : tuple of Undetermined
    files, segments, sweeps : tuple of Disagreement
        Recordings against each other, segments against others of their condition, up- against down-sweeps.
    ripples : tuple of Ripple
    """

    conditions: tuple[ConditionFit, ...] = ()
    stiffnesses: tuple[SlipStiffness, ...] = ()
    undetermined: tuple[Undetermined, ...] = ()
    files: tuple[Disagreement, ...] = ()
    segments: tuple[Disagreement, ...] = ()
    sweeps: tuple[Disagreement, ...] = ()
    ripples: tuple[Ripple, ...] = ()

    def worst(self, recording: str, channel: str) -> ConditionFit | None:
        """Return the condition that a channel of a recording misses most; None where there are not several."""
        conditions = [each for each in self.conditions if (each.recording, each.channel) == (recording, channel)]
        return max(conditions, key=lambda each: each.rmse) if len(conditions) > 1 else None


def find(
    residuals: Residuals,
    free: Sequence[str],
    sets: Sequence[tuple[str, ...]],
    bounded: Sequence[str],
    effective: Mapping[str, float],
) -> Findings:
    """Look at what a fit misses.

    Parameters
    ----------
    residuals : Residuals
    free : sequence of str
        The coefficients that the data had to determine.
    open_ : sequence of tuple of str
        Sets of them that the data leave open.
    bounded : sequence of str
        Coefficients on a bound; not among `free`.
    effective : mapping of str to float
        Independent rows of each channel.

    Returns
    -------
    Findings
    """
    reasons = undetermined(residuals, free, sets, effective)
    reasons += at_bounds(residuals, [*free, *bounded], bounded, effective)
    return Findings(
        by_condition(residuals), slip_stiffnesses(residuals), reasons,
        disagreeing_files(residuals), disagreeing_segments(residuals), sweep_differences(residuals), ripple(residuals),
    )  # fmt: skip


def by_condition(residuals: Residuals) -> tuple[ConditionFit, ...]:
    """Tell how well each channel of each recording is met, condition by condition.

    Parameters
    ----------
    residuals : Residuals

    Returns
    -------
    tuple of ConditionFit
        None where nothing was held at several levels.
    """
    if not residuals.levels:
        return ()
    units = {output.name: output.unit for output in residuals.tire.book.outputs}
    records = []
    for number, source in enumerate(residuals.sources):
        for channel in residuals.channels:
            values = residuals.measured_minus_computed[channel]
            here = np.flatnonzero((residuals.recording == number) & np.isfinite(values))
            conditions, index = np.unique(residuals.condition[here], return_inverse=True)
            rows = np.bincount(index, minlength=len(conditions))
            squares, sums = (np.bincount(index, each, len(conditions)) for each in (values[here] ** 2, values[here]))
            for k in np.flatnonzero(rows >= FEWEST_ROWS):
                rmse, mean = float(np.sqrt(squares[k] / rows[k])), residuals.sign(channel) * float(sums[k] / rows[k])
                at = residuals.at(int(conditions[k]))
                records.append(ConditionFit(source, channel, units[channel], at, int(rows[k]), rmse, mean))
    return tuple(records)
