"""Preprocessed recordings of a fit: one table, excluded rows, weights of rows."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from ...boundary.errors import DataError, FitError, UnknownName
from ...measurements import EXCLUSION_REASONS, DataFinding, Recording, data_findings, exclude_rows, group_by_condition
from ...measurements.checks.rows.row_exclusion import check_inputs
from ...measurements.operating_conditions.levels import held_levels
from ...measurements.row_selection.selected import matching
from ...measurements.state_starts import with_fitted_starts
from ...numerics.arrays import BoolArray, FloatArray
from ...symbolic.model import Model
from ...tires.evaluation import Conventions, evaluate
from ...tires.tire import Tire

#: A channel is fitted if at least one of these inputs varies by `MIN_VARIATION`; My always.
EXCITED_BY = {"Fx": ("kappa",), "Fy": ("alpha",), "Mz": ("alpha",), "Mx": ("alpha", "gamma"), "My": ()}
MIN_VARIATION = 0.01
#: Weights of rows: equal for each operating condition of a recording, equal for each row, equal for each operating
#: condition with each channel of a recording weighted by its effective sample size, or as for conditions with errors
#: relative to the load.
ROWS = ("condition", "equal", "independent", "load")
#: Smallest load, relative to the largest, to which errors are relative. Judgement: a row near lift-off is all noise.
MIN_LOAD = 0.1


@dataclass(frozen=True)
class ExcludedRows:
    """Rows of a recording that were not fitted; the goodness of fit includes them.

    - `recording`, `reason`, `meaning`: the reason is a name of `tirefmu.measurements.EXCLUSION_REASONS`.
    - `rows`, `of`: number of excluded rows, and of all rows.
    - `findings`: details with row numbers.
    """

    recording: str
    reason: str
    meaning: str
    rows: int
    of: int
    findings: tuple[str, ...]

    def __str__(self) -> str:
        """Return a summary in one line."""
        return f"{self.recording}: {self.rows} of {self.of} rows excluded: {self.reason} ({self.meaning})"


@dataclass(frozen=True)
class FitData:
    """The data of a fit.

    - `table`: all rows, in adapted SAE, with the columns ``recording`` and ``segment`` (numbers), ``included`` (whether
      the row is fitted) and ``weight`` (mean 1 over the included rows of a recording). Channels that are not fitted are
      NaN.
    - `notes`: channels that are not fitted.
    - `findings`: problems in the recordings.
    """

    table: pd.DataFrame
    excluded_rows: tuple[ExcludedRows, ...]
    notes: tuple[str, ...]
    findings: tuple[DataFinding, ...] = ()

    @property
    def fitted(self) -> pd.DataFrame:
        """The included rows."""
        included = self.table["included"].to_numpy()
        return self.table if included.all() else self.table[included]


def prepare(
    recordings: Sequence[Recording],
    model: Model,
    *,
    screening: bool = True,
    rows: str = "condition",
    factors: Mapping[str, float] | None = None,
) -> FitData:
    """Combine recordings in one table, mark excluded rows, and set the weights of rows.

    `screening`: whether to exclude rows (`tirefmu.measurements.exclude_rows`). `rows`: weights of rows: a name of
    `ROWS`. `factors`: of the weights, by the expression of their rows. Raises `UnknownName` if `rows` is not a name of
    `ROWS`. Raises `DataError` if a recording has no measured output, or every row is excluded. Raises `FitError` if no
    output varies over a varying slip.
    """
    if rows not in ROWS:
        raise UnknownName("weighting of rows", rows, ROWS)
    tables: list[pd.DataFrame] = []
    excluded_rows: list[ExcludedRows] = []
    for part in recordings:
        part.measured()  # raises if no output is measured, and suggests columns that may be misnamed channels
        if "Fz" not in part.table:
            raise DataError(f"{part.source}: no load Fz: name its column (--columns Fz=NAME), or add one")
        check_inputs(part)  # before they are compared with levels
    unfitted: list[str] = []
    segments = 0
    for number, recording in enumerate(recordings):
        included, excluded = _screened(recording) if screening else (np.ones(len(recording), dtype=np.bool_), ())
        excluded_rows += excluded
        weight = _weights(recording, included, rows)
        for expression, factor in (factors or {}).items():
            weight = np.where(matching(recording, expression), factor, 1.0) * weight
            weight = weight / weight[included].mean() if included.any() else weight
        segment = recording.segment_numbers() + segments
        segments = int(segment[-1]) + 1
        table, unfitted_here = _without_information(recording.with_signs("adapted-sae").table, included, model)
        unfitted += [f"{recording.source}: {note}" for note in unfitted_here]
        tables.append(table.assign(recording=number, segment=segment, included=included, weight=weight))
    data = pd.concat(tables, ignore_index=True) if len(tables) > 1 else tables[0].reset_index(drop=True)
    if not data["included"].any():
        raise DataError(f"all rows are excluded (--all-rows includes them): {'; '.join(map(str, excluded_rows))}")
    outputs = [quantity.name for quantity in model.outputs]
    if not any(name in data and data.loc[data["included"], name].notna().any() for name in outputs):
        raise FitError(
            "; ".join([f"none of {', '.join(outputs)} is measured over a varying slip: nothing to fit", *unfitted])
        )
    return FitData(data, tuple(excluded_rows), tuple(unfitted), tuple(data_findings(recordings)))


def with_states(data: FitData, tire: Tire, free: Collection[str] = ()) -> pd.DataFrame:
    """Return the included rows of a fit with the states of a tire as columns.

    Excluded rows are simulated, too: a state remembers them. States with a fitted start begin each segment with the
    value that the measured forces determine (`tirefmu.measurements.state_starts`).

    `tire`: in adapted SAE, as the data. `free`: coefficients that are estimated together with fitted starts, but not
    returned.
    """
    names = list(tire.states)
    recordings = data.table.groupby("recording", sort=False)
    parts = [with_fitted_starts(tire, Recording(part, tire.signs, str(name)), free).table for name, part in recordings]
    courses = pd.concat([evaluate(tire, part, Conventions(tire.signs))[names] for part in parts])
    fitted = data.fitted
    return fitted.assign(**courses.loc[fitted.index])


def _weights(recording: Recording, included: BoolArray, rows: str) -> FloatArray:
    """Return the weights of rows by the name of a weighting, with mean 1 over the included rows."""
    if rows == "equal":
        return np.ones(len(recording))
    weight = group_by_condition(recording).weights(included)
    if rows == "load" and "Fz" in recording.table and included.any():
        load = np.abs(_levelled(recording.table["Fz"]))
        weight = weight / np.maximum(load, MIN_LOAD * load[included].max()) ** 2
        weight = weight / weight[included].mean()
    return weight


def _levelled(column: pd.Series) -> FloatArray:
    """Return each value's nearest level, because noise of the load must not weight rows; a swept channel as it is."""
    values, levels = column.to_numpy(dtype=np.float64), np.array(held_levels(column))
    if not levels.size:
        return values
    return np.asarray(levels[np.searchsorted(0.5 * (levels[1:] + levels[:-1]), values)])


def _screened(recording: Recording) -> tuple[BoolArray, tuple[ExcludedRows, ...]]:
    """Return which rows are included, and the excluded rows by reason."""
    exclusions = exclude_rows(recording)
    return exclusions.included, tuple(
        ExcludedRows(
            recording.source, reason, EXCLUSION_REASONS[reason], count, len(recording),
            tuple(finding for finding in exclusions.notes if finding.startswith(f"{reason}:")),
        )
        for reason, count in exclusions.counts.items()
    )  # fmt: skip


def _without_information(table: pd.DataFrame, included: BoolArray, model: Model) -> tuple[pd.DataFrame, list[str]]:
    """Set channels to NaN that have no information in a recording: the slip or the channel does not vary.

    A channel of zeros has no scale for its noise, and no Magic Formula has a constant force over a varying slip.
    Returns notes on these channels, too.
    """
    notes = []
    fitted = table if included.all() else table[included]
    for channel in (quantity.name for quantity in model.outputs if quantity.name in table):
        by = EXCITED_BY[channel]
        if by and not any(slip in table and _width(fitted[slip]) >= MIN_VARIATION for slip in by):
            table = table.assign(**{channel: np.nan})
            notes.append(f"{channel} is not fitted, {' or '.join(by)} does not vary there")
            continue
        values = fitted[channel].dropna().to_numpy(dtype=float)
        if len(values) and np.ptp(values) == 0.0 and (by or values[0] == 0.0):
            table = table.assign(**{channel: np.nan})
            notes.append(f"{channel} is not fitted, it is {values[0]:.4g} in every row")
    return table, notes


def _width(column: pd.Series) -> float:
    return float(np.ptp(column.to_numpy())) if len(column) else 0.0
