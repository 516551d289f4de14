"""How each output of an FMU compares with measured data, without what is drawn from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import pandas as pd

from ...boundary.escaping import visible
from ...boundary.json_schema import json_value
from ...drawing.labels import drawn_unit, per_si

#: Largest |FMU - direct| / (1 + |direct|) between the FMU and direct evaluation of its tire.
EVALUATION_TOLERANCE = 1e-9
#: Coefficient of determination from which a channel counts as described. It is judgement and does not affect the check.
GOOD_R2 = 0.9
#: Below this one, the error has twice the variance of the channel: a channel that only has noise is not that wrong.
WRONG_R2 = -1.0


@dataclass(frozen=True)
class Statement:
    """One of the two results of a check: `grade`, "good", "limited" or "bad", and a sentence."""

    grade: str
    text: str


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

    JSON_KEYS: ClassVar = ("unit", "measured", "rmse", "relative_rmse", "r2", "r2_uncentred", "worst")

    name: str
    unit: str
    measured: int
    rmse: float
    relative_rmse: float
    r2: float
    r2_uncentred: float
    worst: WorstPoint


@dataclass(frozen=True, repr=False)
class Compared:
    """What a check computed; its fields are described in `CheckResult`."""

    signs: ClassVar[str] = "iso"
    JSON_KEYS: ClassVar = (
        "fmu", "source", "fmi_version", "signs", "rows", "segments", "ok", "statements", "tolerance", "problems",
        "evaluation_difference", "by_name as channels",
    )  # fmt: skip

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
    not_fitted: tuple[str, ...] = ()
    without_slip: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """True if the FMU is valid, agrees with direct evaluation, and satisfies the tolerance, if any."""
        return self.of_fmu.grade == "good" and not self.beyond_tolerance

    @property
    def beyond_tolerance(self) -> tuple[CheckedChannel, ...]:
        """The channels whose error exceeds the tolerance; none without one."""
        limit = self.tolerance
        return () if limit is None else tuple(c for c in self.channels if not c.relative_rmse <= limit)

    @property
    def of_fmu(self) -> Statement:
        """Whether the FMU computes its tire, whatever the data."""
        difference = self.evaluation_difference
        if self.problems:
            return Statement("bad", "the FMU is invalid")
        if difference is None:
            return Statement("good", "the FMU is valid; it contains no tire to compare with")
        if not difference <= EVALUATION_TOLERANCE:
            return Statement("bad", f"the FMU does not compute its tire: it differs by {difference:.1e}")
        return Statement("good", "the FMU computes its tire")

    @property
    def of_tire(self) -> Statement:
        """Whether the tire describes this recording. It decides about `ok` by the tolerance only."""
        fitted = [channel for channel in self.channels if channel.name not in self.not_fitted]
        described = [channel for channel in fitted if channel.r2 >= GOOD_R2]
        judged = [channel for channel in fitted if channel in described or channel.name not in self.without_slip]
        silent = [channel.name for channel in fitted if channel not in judged]
        poor = [channel for channel in judged if channel not in described]
        numbers = ", ".join(f"{channel.name} {channel.r2:.3g}" for channel in (*described, *poor))
        if not fitted:
            grade, text = "limited", "the tire was not fitted to what this recording measures"
        elif not judged:
            grade, text = "limited", "this recording cannot show whether the tire describes it"
        elif not poor:
            grade, text = "good", "the tire describes this recording"
        elif described and all(channel.r2 > WRONG_R2 for channel in poor):
            names = ", ".join(channel.name for channel in poor)
            grade, text = (
                "limited",
                f"the tire describes this recording in part: poor fit or little variation of {names}",
            )
        else:
            grade, text = "bad", "the tire does not describe this recording"
        if self.beyond_tolerance:
            names = ", ".join(channel.name for channel in self.beyond_tolerance)
            grade, text = "bad", f"{text}; the error of {names} exceeds {self.tolerance:.3g} of the largest value"
        text += f" (R2: {numbers})" if numbers else ""
        text += f"; without slip {', '.join(silent)} shows nothing" if silent else ""
        text += f"; the tire was not fitted to {', '.join(self.not_fitted)}" if fitted and self.not_fitted else ""
        return Statement(grade, text)

    @property
    def statements(self) -> dict[str, Statement]:
        """Both statements, by what they are about."""
        return {"fmu": self.of_fmu, "tire": self.of_tire}

    @property
    def by_name(self) -> dict[str, CheckedChannel]:
        """The channels by name."""
        return {channel.name: channel for channel in self.channels}

    def to_json(self) -> dict[str, Any]:
        """Return the result as plain values for json.dump; NaN and infinity become None."""
        return dict(json_value(self))

    def __repr__(self) -> str:
        """Return the comparison as a short table."""
        return str(self)

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
