"""What a recording contains, as tables: channels, sweeps, operating conditions, excluded rows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ...boundary.escaping import excerpt, visible
from ...boundary.json_schema import json_value
from ...boundary.named_options import named
from ...numerics.arrays import BoolArray, FloatArray, IndexArray
from ...symbolic.channels import CHANNELS
from ..checks.columns.check import check_columns
from ..checks.columns.meanings import ColumnMeaning, column_meanings
from ..checks.recordings.data_findings import data_findings
from ..checks.recordings.finding import DataFinding, verdict_on
from ..checks.rows.row_exclusion import RowExclusion, exclude_rows
from ..operating_conditions.grouping import group_by_condition
from ..operating_conditions.levels import held_levels
from ..operating_conditions.phases import Phase, phases
from ..operating_conditions.time_series import sample_interval
from ..recording import Recording
from ..table_argument import TableLike, recordings_from

#: s, time over which the speed of a sweep is measured. A sweep of a bench takes several seconds.
RATE_TIME = 0.5
#: Channels that a bench holds or that follow the test, whose slow change is of interest.
DRIFTING = ("p", "V", "T")
#: Fraction of the rows at either end of a condition, between which the drift is computed.
END_SHARE = 0.1


@dataclass(frozen=True)
class ChannelSummary:
    """One channel of a recording, in SI units (deg C for T).

    `unit_from`: "declared in the file", or why the unit was assumed. `rows`, `missing`: number of rows with a value,
    and without. `levels`: levels at which an input was held; empty if it was swept, and for an output.
    """

    name: str
    meaning: str
    unit: str
    unit_from: str
    rows: int
    missing: int
    lowest: float
    median: float
    highest: float
    levels: tuple[float, ...]


@dataclass(frozen=True)
class SweepSummary:
    """One sweep: consecutive rows in which inputs move steadily.

    `number`, `first`, `last`: number of the sweep, first and last sample, from 1, as in ``--where``. `moving`: the
    swept inputs. `lowest`, `highest`, `rate`: range of each, and its median speed per second, in SI units. `held`:
    medians of the other inputs, in SI units.
    """

    number: int
    first: int
    last: int
    moving: tuple[str, ...]
    lowest: tuple[float, ...]
    highest: tuple[float, ...]
    rate: tuple[float, ...]
    held: dict[str, float]


@dataclass(frozen=True)
class ConditionSummary:
    """One operating condition.

    `held`: levels of the held inputs, in SI units; Fz is the load, positive in every sign convention. `moving`: the
    swept inputs; "points" for separate steady points. `rows`, `sweeps`: number of rows, and of consecutive stretches of
    rows. `drift`: change of p, V and T from the first to the last tenth of the rows, in SI units.
    """

    held: dict[str, float]
    moving: tuple[str, ...]
    rows: int
    sweeps: int
    seconds: float
    drift: dict[str, float]


@dataclass(frozen=True, eq=False)
class Inspection:
    """The contents of one recording.

    `interval`, `duration`: median step of the clock and recorded time without interruptions, s. `segments`: number of
    stretches without interruption. `longest_gap`: s, the longest interruption; 0 without one. `conditions`: without the
    rows of transitions, sorted by pressure, camber and load. `exclusion`: the rows that ``fit`` would exclude.
    `meanings`: what each column was taken for.
    `held`: rows outside transitions, shape (n,).
    """

    recording: Recording
    channels: tuple[ChannelSummary, ...]
    interval: float
    duration: float
    segments: int
    longest_gap: float
    sweeps: tuple[SweepSummary, ...]
    conditions: tuple[ConditionSummary, ...]
    exclusion: RowExclusion
    meanings: tuple[ColumnMeaning, ...]
    held: BoolArray

    def to_json(self) -> dict[str, Any]:
        """Return the contents as JSON values; a range or drift without a number is null."""
        recording = self.recording
        content = {
            "source": recording.source,
            "rows": len(recording),
            "signs": recording.signs,
            "units": recording.about.get("units", ""),
            "ignored": recording.about.get("ignored", ""),
            "tire": recording.about.get("tireid", ""),
            "selected": recording.about.get("selected", ""),
            "sample_interval": self.interval,
            "duration": self.duration,
            "segments": self.segments,
            "longest_gap": self.longest_gap,
            "channels": self.channels,
            "columns": self.meanings,
            "sweeps": self.sweeps,
            "conditions": self.conditions,
            "excluded_rows": self.exclusion.counts,
            "excluded_held_rows": np.count_nonzero(self.held & ~self.exclusion.included),
        }
        return dict(json_value(content))


class InspectionResult(NamedTuple):
    """The contents of recordings of one tire, and the problems in the data."""

    recordings: tuple[Inspection, ...]
    findings: tuple[DataFinding, ...]

    @property
    def ok(self) -> bool:
        """Whether no finding is serious."""
        return not any(finding.serious for finding in self.findings)

    @property
    def verdict(self) -> str:
        """What the findings mean for a fit, in one line."""
        return verdict_on(self.findings)

    def to_json(self) -> dict[str, Any]:
        """Return the result as JSON values."""
        return {
            "ok": self.ok,
            "verdict": self.verdict,
            "findings": json_value(self.findings),
            "recordings": [inspection.to_json() for inspection in self.recordings],
        }

    def __repr__(self) -> str:
        """Return the verdict, the findings, and a line for each recording."""
        contents = (
            f"  {excerpt(i.recording.source)}: {len(i.recording)} rows, {len(i.conditions)} operating conditions"
            for i in self.recordings
        )
        return "\n".join([self.verdict, *(f"  {visible(str(finding))}" for finding in self.findings), *contents])


@named()
def inspect(
    tables: TableLike | Iterable[TableLike],
    *,
    signs: str | None = None,
    where: str | None = None,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> InspectionResult:
    """Return what recordings of one tire contain, lack and contradict.

    Parameters
    ----------
    tables : path, DataFrame or Recording, or a sequence of them
        Each with at least one measured output.
    signs, where, columns, units
        As for `tirefmu.measurements.recordings_from`.

    Returns
    -------
    InspectionResult
        Channels, sweeps and operating conditions of each recording, and the findings.

    Raises
    ------
    DataError
        If a table cannot be read, has no measured output, or contradicts its sign convention or its units.
    UnknownName, WrongType
        As for `tirefmu.measurements.recordings_from`.

    Examples
    --------
    >>> from tirefmu.measurements import VirtualBench, alpha_sweeps
    >>> from tirefmu.tires import published
    >>> result = inspect(VirtualBench(published("trento_hoosier")).run(alpha_sweeps([220.0, 700.0])))
    >>> result.ok, [channel.name for channel in result.recordings[0].channels][:3]
    (True, ['t', 'kappa', 'alpha'])
    """
    recordings = recordings_from(tables, signs=signs, where=where, columns=columns, units=units)
    for recording in recordings:
        recording.measured()  # raises for a table without a measured output
        check_columns(recording)
    return InspectionResult(tuple(map(inspected, recordings)), tuple(data_findings(recordings)))


def inspected(recording: Recording) -> Inspection:
    """Return the contents of one recording."""
    pieces = recording.segments()
    clock = recording.table["t"].to_numpy(dtype=np.float64) if "t" in recording.table else None
    interval = sample_interval(recording, max(pieces, key=lambda piece: piece.stop - piece.start))
    gaps = [clock[piece.start] - clock[piece.start - 1] for piece in pieces[1:]] if clock is not None else []
    all_phases = phases(recording)
    return Inspection(
        recording,
        tuple(_channel(recording, name) for name in CHANNELS if name in recording.table),
        interval,
        interval * len(recording),
        len(pieces),
        float(max([0.0, *gaps])),
        tuple(_sweeps(recording, all_phases)),
        tuple(_conditions(recording, all_phases, interval)),
        exclude_rows(recording),
        tuple(column_meanings(recording)),
        _held(recording, all_phases),
    )


def _channel(recording: Recording, name: str) -> ChannelSummary:
    declared, column = CHANNELS[name], recording.table[name]
    values = column.dropna().to_numpy(dtype=np.float64)
    low, middle, high = (float(v) for v in np.quantile(values, (0.0, 0.5, 1.0))) if len(values) else (np.nan,) * 3
    in_file = name in recording.about.get("declared", "").split()
    reason = "declared in the file" if in_file else recording.about.get("units") or "SI, as no unit is declared"
    levels = held_levels(column) if declared.role != "output" and name not in ("t", "T") else []
    return ChannelSummary(
        name, declared.meaning, declared.unit, reason, len(values), len(column) - len(values), low + 0.0,
        middle + 0.0, high + 0.0, tuple(level + 0.0 for level in levels),
    )  # fmt: skip


def _sweeps(recording: Recording, all_phases: Sequence[Phase]) -> list[SweepSummary]:
    sweeps: list[SweepSummary] = []
    for phase in (phase for phase in all_phases if phase.kind == "sweep"):
        moved = [recording.table[name].to_numpy(dtype=np.float64)[phase.rows] for name in phase.moving]
        step = sample_interval(recording, phase.rows)
        sweeps.append(
            SweepSummary(
                len(sweeps) + 1, phase.rows.start + 1, phase.rows.stop, phase.moving,
                tuple(float(values.min()) for values in moved), tuple(float(values.max()) for values in moved),
                tuple(_rate(values, step) for values in moved), dict(phase.held),
            )
        )  # fmt: skip
    return sweeps


def _rate(values: FloatArray, step: float) -> float:
    """Return the median speed of an input, over times that are long compared with noise."""
    lag = min(max(1, round(RATE_TIME / step)), len(values) - 1)
    return float(np.median(np.abs(values[lag:] - values[:-lag]))) / (lag * step) if lag else 0.0


def _conditions(recording: Recording, all_phases: Sequence[Phase], interval: float) -> list[ConditionSummary]:
    groups, steady = group_by_condition(recording), _held(recording, all_phases)
    conditions = []
    for number, (held, moving) in enumerate(zip(groups.conditions, groups.moving, strict=True)):
        rows = np.flatnonzero((groups.labels == number) & steady)
        if not len(rows):
            continue
        levels = {name: abs(level) if name == "Fz" else level + 0.0 for name, level in held}
        conditions.append(
            ConditionSummary(
                levels, moving, len(rows), _stretches(rows), interval * len(rows),
                {name: _drift(recording.table[name], rows) for name in DRIFTING if name in recording.table},
            )
        )  # fmt: skip
    order = ("p", "V", "gamma", "kappa", "alpha", "Fz")
    return sorted(conditions, key=lambda condition: [condition.held.get(name, -np.inf) for name in order])


def _held(recording: Recording, all_phases: Sequence[Phase]) -> BoolArray:
    """Return the rows in which no held input changes from one level to another."""
    held = np.ones(len(recording), dtype=np.bool_)
    for phase in all_phases:
        held[phase.rows] = phase.kind != "transition"
    return held


def _drift(column: pd.Series, rows: IndexArray) -> float:
    """Return the change of a channel from the first to the last tenth of some rows in the order of time.

    It is the difference of the medians; NaN without a number at either end.
    """
    values = column.to_numpy(dtype=np.float64)[rows]
    count = max(1, round(END_SHARE * len(values)))
    ends = values[:count], values[-count:]
    if any(not np.isfinite(end).any() for end in ends):
        return np.nan
    return float(np.nanmedian(ends[1]) - np.nanmedian(ends[0]))


def _stretches(rows: IndexArray) -> int:
    """Return the number of stretches of consecutive rows."""
    return int(np.count_nonzero(np.diff(rows) > 1)) + (len(rows) > 0)
