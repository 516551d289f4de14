"""Recordings made ready for a fit: one table, what is set aside, how much each row counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.measurements import (
    EXCLUSION_REASONS,
    Recording,
    convention_notes,
    coverage_notes,
    exclude_rows,
    group_by_condition,
    identity_notes,
)
from tirefmu.symbolic.errors import DataError, FitError, UnknownName
from tirefmu.symbolic.model import Model

from .same_tire import tire_notes

#: The inputs of which one has to vary by 0.01 for a channel to tell something of the tire; none for My.
EXCITED_BY = {"Fx": ("kappa",), "Fy": ("alpha",), "Mz": ("alpha",), "Mx": ("alpha", "gamma"), "My": ()}
LEAST_VARIATION = 0.01
#: How rows may count: each held condition of a recording the same, each row the same, or each condition the same and
#: each recording's channel by the independent rows that it is worth.
ROWS = ("condition", "equal", "independent")


@dataclass(frozen=True)
class ExcludedRows:
    """Rows of a recording that were not fitted; scores count them all the same.

    Attributes
    ----------
    recording, reason, meaning : str
        The reason is a name of `tirefmu.measurements.EXCLUSION_REASONS`.
    rows, of : int
        How many, of how many.
    findings : tuple of str
        What was found, and in which rows.
    """

    recording: str
    reason: str
    meaning: str
    rows: int
    of: int
    findings: tuple[str, ...]

    def __str__(self) -> str:
        """Say it in a line."""
        return f"{self.recording}: {self.rows} of {self.of} rows set aside: {self.reason} ({self.meaning})"


@dataclass(frozen=True)
class FitData:
    """The data of a fit.

    Attributes
    ----------
    table : pandas.DataFrame
        Every row, in adapted SAE, with the columns ``recording`` and ``segment`` (numbers), ``kept`` (whether it is
        fitted) and ``weight`` (how much it counts, on average 1 over a recording's kept rows). Channels that a
        recording tells nothing of are NaN.
    excluded_rows : tuple of ExcludedRows
    notes : tuple of str
        What looks odd, what the data cannot tell, what is not fitted.
    rows : str
        How rows count: a name of `ROWS`.
    """

    table: pd.DataFrame
    excluded_rows: tuple[ExcludedRows, ...]
    notes: tuple[str, ...]
    rows: str = "condition"

    @property
    def fitted(self) -> pd.DataFrame:
        """The rows that are fitted."""
        included = self.table["included"].to_numpy()
        return self.table if included.all() else self.table[included]


def prepare(
    recordings: Sequence[Recording], book: Model, *, screening: bool = True, rows: str = "condition"
) -> FitData:
    """Put recordings into one table, set aside what says nothing of the steady tire, weigh what repeats.

    Parameters
    ----------
    recordings : sequence of Recording
    book : Model
    screening : bool
        Whether to set rows aside (`tirefmu.measurements.exclude_rows`).
    rows : str
        How they count: a name of `ROWS`.

    Returns
    -------
    FitData

    Raises
    ------
    UnknownName
        If rows cannot count like that.
    DataError
        If a recording has no measured output, or every row is set aside.
    FitError
        If no output is measured over a varying slip.
    """
    if rows not in ROWS:
        raise UnknownName("way for rows to count", rows, ROWS)
    tables: list[pd.DataFrame] = []
    excluded_rows: list[ExcludedRows] = []
    for each in recordings:
        each.measured()  # raises where there is none, and suggests which column may be a misnamed channel
    notes = [note for each in recordings for note in (*convention_notes(each), *coverage_notes(each))]
    notes += identity_notes(recordings) or tire_notes(recordings)
    unfitted: list[str] = []
    segments = 0
    for number, recording in enumerate(recordings):
        included, found = _screened(recording) if screening else (np.ones(len(recording), dtype=np.bool_), ())
        excluded_rows += found
        weight = np.ones(len(recording)) if rows == "equal" else group_by_condition(recording).weights(included)
        segment = _segment_numbers(recording) + segments
        segments = int(segment[-1]) + 1
        table, unfitted_channels = _without_constant_slip(recording.with_signs("adapted-sae").table, included, book)
        unfitted += [f"{recording.source}: {what}" for what in unfitted_channels]
        tables.append(table.assign(recording=number, segment=segment, included=included, weight=weight))
    data = pd.concat(tables, ignore_index=True)
    if not data["included"].any():
        raise DataError(f"no row is left to fit (--all-rows keeps them): {'; '.join(map(str, excluded_rows))}")
    outputs = [quantity.name for quantity in book.outputs]
    if not any(name in data and data.loc[data["included"], name].notna().any() for name in outputs):
        raise FitError(
            "; ".join([f"none of {', '.join(outputs)} is measured over a varying slip: nothing to fit", *unfitted])
        )
    return FitData(data, tuple(excluded_rows), (*notes, *unfitted), rows)


def _screened(recording: Recording) -> tuple[npt.NDArray[np.bool_], tuple[ExcludedRows, ...]]:
    """Return which rows are kept, and a line for each reason why others are not."""
    found = exclude_rows(recording)
    return found.included, tuple(
        ExcludedRows(
            recording.source, reason, EXCLUSION_REASONS[reason], count, len(recording),
            tuple(finding for finding in found.notes if finding.startswith(f"{reason}:")),
        )
        for reason, count in found.counts.items()
    )  # fmt: skip


def _segment_numbers(recording: Recording) -> npt.NDArray[np.int64]:
    pieces = recording.segments()
    return np.repeat(np.arange(len(pieces)), [piece.stop - piece.start for piece in pieces])


def _without_constant_slip(
    table: pd.DataFrame, included: npt.NDArray[np.bool_], book: Model
) -> tuple[pd.DataFrame, list[str]]:
    """Take out channels whose slip a recording does not vary."""
    notes = []
    fitted = table if included.all() else table[included]
    for channel in (quantity.name for quantity in book.outputs if quantity.name in table):
        by = EXCITED_BY[channel]
        if by and not any(slip in table and _width(fitted[slip]) >= LEAST_VARIATION for slip in by):
            table = table.assign(**{channel: np.nan})
            notes.append(f"{channel} is not fitted, {' or '.join(by)} does not vary there")
    return table, notes


def _width(column: pd.Series) -> float:
    return float(np.ptp(column.to_numpy())) if len(column) else 0.0
