"""The result of `check`: how each output of an FMU compares with measured data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite, isnan
from typing import Any

import pandas as pd

from ...boundary.escaping import visible
from ...drawing.labels import drawn_unit, per_si
from ...tires.notebook import html_summary, html_table

#: Largest |FMU - direct| / (1 + |direct|) between the FMU and direct evaluation of its tire.
EVALUATION_TOLERANCE = 1e-9
#: Coefficient of determination from which a channel counts as described. It is judgement and does not affect the check.
GOOD_R2 = 0.9


@dataclass(frozen=True)
class WorstPoint:
    """The row with the largest error of a channel.

    Attributes
    ----------
    row : int
        Of the recording, starting at 0.
    t : float or None
        s; None if the recording has no time.
    condition : mapping of str to float
        The inputs of this row, SI, ISO signs.
    measured, simulated : float
        Values of the channel there, SI.
    """

    row: int
    t: float | None
    condition: Mapping[str, float]
    measured: float
    simulated: float


@dataclass(frozen=True)
class CheckedChannel:
    """Goodness of fit of one output of the FMU.

    Attributes
    ----------
    name, unit : str
        The output and its SI unit.
    measured : int
        Number of rows with a measured value.
    rmse : float
        Root mean squared error, in the channel's unit.
    relative_rmse : float
        RMSE as a share of the largest measured magnitude.
    r2, r2_uncentred : float
        1 - SSE / sum of squares about the mean, about zero; NaN if that sum is 0.
    worst : WorstPoint
        The row with the largest error.
    """

    name: str
    unit: str
    measured: int
    rmse: float
    relative_rmse: float
    r2: float
    r2_uncentred: float
    worst: WorstPoint


@dataclass(frozen=True, repr=False)
class CheckResult:
    """The result of `check`.

    Attributes
    ----------
    fmu, source : str
        Names of the FMU and of the recording.
    fmi_version : str
        As the FMU states it, such as "3.0".
    rows, segments : int
        Number of simulated rows, and of segments with a new initialization.
    channels : tuple of Channel
        The measured outputs of the FMU.
    evaluation_difference : float or None
        Largest |FMU - direct| / (1 + |direct|) over all rows and outputs, where direct is the direct evaluation of the
        embedded tire; None without an embedded tire.
    problems : tuple of str
        Problems found by fmpy's validation.
    tolerance : float or None
        Largest allowed `Channel.relative_rmse`.
    simulated : pandas.DataFrame
        The FMU's outputs by row, ISO signs.
    recording : pandas.DataFrame
        The same rows of the recording: ``t`` (equal steps if it had none), inputs and measured outputs, ISO signs.
    starts : tuple of int
        The first row of each segment.
    """

    fmu: str
    source: str
    fmi_version: str
    rows: int
    segments: int
    channels: tuple[CheckedChannel, ...]
    evaluation_difference: float | None
    problems: tuple[str, ...]
    tolerance: float | None = None
    simulated: pd.DataFrame = field(default_factory=pd.DataFrame, repr=False)
    recording: pd.DataFrame = field(default_factory=pd.DataFrame, repr=False)
    starts: tuple[int, ...] = ()

    @property
    def ok(self) -> bool:
        """True if the FMU is valid, agrees with direct evaluation, and satisfies the tolerance, if any."""
        accurate = self.evaluation_difference is None or self.evaluation_difference <= EVALUATION_TOLERANCE
        within_tolerance = self.tolerance is None or all(c.relative_rmse <= self.tolerance for c in self.channels)
        return not self.problems and accurate and within_tolerance

    @property
    def verdict(self) -> str:
        """What was checked of the FMU, in one line; how well its tire describes the data is `agreement`."""
        if not self.ok:
            return "check failed"
        equal = "" if self.evaluation_difference is None else " and computes its tire as direct evaluation does"
        within = "" if self.tolerance is None else f"; every error is within {self.tolerance:.3g} of the largest value"
        return f"check passed: the FMU is valid{equal}{within}"

    @property
    def poorly_described(self) -> tuple[str, ...]:
        """The channels with an R2 below `GOOD_R2`, or without one."""
        return tuple(channel.name for channel in self.channels if not channel.r2 >= GOOD_R2)

    @property
    def agreement(self) -> str:
        """How well the tire of the FMU describes the data, in one line."""
        described = [channel for channel in self.channels if channel.name not in self.poorly_described]
        poor = [channel for channel in self.channels if channel.name in self.poorly_described]
        good, bad = (", ".join(f"{channel.name} {channel.r2:.3f}" for channel in some) for some in (described, poor))
        below = f"below {GOOD_R2}: {bad} (poorly described, or hardly varies here)" if bad else ""
        return f"agreement with the data, R2: {'; '.join(filter(None, (good, below)))}"

    def to_json(self) -> dict[str, Any]:
        """Return the result as plain values for json.dump; NaN and infinity become None."""
        return {
            "fmu": self.fmu,
            "source": self.source,
            "fmi_version": self.fmi_version,
            "signs": "iso",
            "rows": self.rows,
            "segments": self.segments,
            "ok": self.ok,
            "tolerance": self.tolerance,
            "problems": list(self.problems),
            "evaluation_difference": self.evaluation_difference
            if isfinite(self.evaluation_difference or 0.0)
            else None,
            "channels": {channel.name: _channel_json(channel) for channel in self.channels},
        }

    def __repr__(self) -> str:
        """Return the comparison as a short table."""
        return str(self)

    def _repr_html_(self) -> str:
        """Return the comparison as HTML with the picture of the first channel, for a notebook."""
        first, _, *rest = str(self).split("\n")
        rows = [(c.name, c.measured, c.rmse, c.unit, c.relative_rmse, c.r2, c.r2_uncentred) for c in self.channels]
        header = ["channel", "rows", "RMSE", "unit", "of max", "R2", "R2 uncentred"]
        from ...drawing.picture import html_image  # imports matplotlib, which is slow
        from .figures import check_figures

        notes = html_summary("\n".join(rest[len(rows) :]))
        return html_summary(first, html_table(header, rows), notes, *map(html_image, check_figures(self)[:1]))

    def __str__(self) -> str:
        lines = [
            f"{self.fmu} (FMI {self.fmi_version}) against {self.source}: {self.rows} rows, "
            f"{self.segments} segment{'s'[: self.segments != 1]}, ISO signs",
            f"{'channel':<8}{'rows':>8}{'RMSE':>14}{'of max':>10}{'R2':>10}{'R2 uncentred':>14}  worst point",
        ]
        for channel in self.channels:
            worst = channel.worst
            at = ", ".join(_drawn(name, value) for name, value in worst.condition.items())
            lines.append(
                f"{channel.name:<8}{channel.measured:>8}{channel.rmse:>10.4g} {channel.unit:<3}"
                f"{channel.relative_rmse:>10.2%}{channel.r2:>10.4f}{channel.r2_uncentred:>14.4f}"
                f"  row {worst.row}: measured {worst.measured:.4g}, FMU {worst.simulated:.4g} at {at}"
            )
        if self.evaluation_difference is not None:
            lines.append(f"largest relative difference from direct evaluation: {self.evaluation_difference:.1e}")
        lines += [f"invalid: {problem}" for problem in self.problems] or ["fmpy validation: no problems"]
        return "\n".join(visible(line) for line in lines)


def _drawn(name: str, value: float) -> str:
    """Return a value with the unit in which it is drawn: degrees, kPa."""
    unit = drawn_unit(name)
    return f"{name} {value * per_si(name):.4g}{'' if unit == '-' else f' {unit}'}"


def _channel_json(channel: CheckedChannel) -> dict[str, Any]:
    """Return a channel as plain values for JSON."""
    numbers = {name: getattr(channel, name) for name in ("rmse", "relative_rmse", "r2", "r2_uncentred")}
    worst = channel.worst
    return {
        "unit": channel.unit,
        "measured": channel.measured,
        **{name: None if isnan(value) else value for name, value in numbers.items()},
        "worst": {
            "row": worst.row,
            "t": worst.t,
            "condition": dict(worst.condition),
            "measured": worst.measured,
            "simulated": None if isnan(worst.simulated) else worst.simulated,
        },
    }
