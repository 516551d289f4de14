"""The rows of a stage: those that meet its conditions, a random sample or all of them, also those in files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from tirefmu.tires.tire import Tire

from .constraints.physical import operating_range
from .data.fit_data import FitData
from .problem.recipe import Stage
from .problem.rows import Rows, StoredRows


def rows_of_stage(stage: Stage, rows: Rows, data: FitData, tire: Tire, channels: Sequence[str]) -> Rows:
    """Return the rows of a stage from those in memory: a random sample, or all rows, also those in files.

    Parameters
    ----------
    stage : Stage
    rows : Rows
        The rows in memory that meet the conditions of the stage.
    data : FitData
    tire : Tire
    channels : sequence of str
        The channels of the stage.

    Returns
    -------
    Rows
    """
    if not data.stored:
        return rows.sample(stage.rows) if stage.rows else rows
    drawn = Rows.of(selected(stage, data.drawn, channels), tire, channels)
    if stage.rows:
        return drawn.sample(stage.rows)

    def parts(number: int) -> Iterator[Rows]:
        for part in data.parts(number):
            table = selected(stage, part[part["included"]], channels)
            if len(table):
                yield Rows.of(table, tire, channels)

    numbers = np.unique(rows.group).tolist()
    return StoredRows(
        rows.inputs, rows.measured, rows.group, rows.segment, rows.weight,
        parts=parts, drawn=drawn, totals={number: sum(map(len, parts(number))) for number in numbers},
    )  # fmt: skip


def selected(stage: Stage, table: pd.DataFrame, channels: Sequence[str]) -> pd.DataFrame:
    """Return the rows of a table that meet the conditions of a stage and have one of its channels."""
    chosen = stage.select(table)
    if not channels:
        return chosen[:0]
    present = chosen[list(channels)].notna().any(axis=1)
    return chosen if present.all() else chosen[present]


def ranges_of(data: FitData, tire: Tire) -> dict[str, tuple[float, float]]:
    """Return the range of each input of a tire in all rows."""
    ranges = operating_range(data.fitted, tire)
    for stored in data.stored.values():
        for name, (least, most) in stored.limits.items():
            if name in ranges:
                ranges[name] = min(ranges[name][0], least), max(ranges[name][1], most)
    return ranges
