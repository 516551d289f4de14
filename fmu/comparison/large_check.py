"""Comparison of an FMU with a large table, part by part: `check` for tables that do not fit into memory."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.escaping import excerpt
from ...measurements.checks.columns.check import check_columns
from ...measurements.large_table import LargeTable
from ...measurements.recording import Recording
from ...measurements.thresholds import LOGGING_GAP
from ...tires import TABLE_OUTPUTS
from ...tires.signs import convert_signs
from ..simulation.archive import unpacked
from ..simulation.simulate import read_description, simulate
from .channel_errors import ChannelErrors
from .check import STEP, columns_of, compared_columns, directly, largest_difference, unit_of
from .resources import axes_of_inputs, embedded_tire
from .result import CheckResult

FloatArray = npt.NDArray[np.float64]


def check_large(
    fmu_path: str | os.PathLike[str],
    table: LargeTable,
    *,
    tolerance: float | None = None,
    timeout: float | None = None,
) -> CheckResult | None:
    """Simulate an FMU over a large table in parts and compare it with the data and with its embedded tire.

    The memory does not depend on the number of rows, except for 12 bytes a row with a column t. The FMU is initialized
    again at the start of each part as well, which has no influence if the rows are independent.

    `tolerance`, `timeout`: as for `check`; the time limit is that of a part. The result lacks the tables of all rows.
    None if the FMU has no embedded tire, or if its results depend on earlier rows: then the table cannot be divided.
    Raises `FmuError`, `DataError`: as `check`.
    """
    check_columns(table.survey, fitted=False)
    with unpacked(fmu_path) as folder:
        description = read_description(fmu_path, folder)
        variables = {variable.name: variable for variable in description.modelVariables}
        tire = embedded_tire(folder, fmu_path, columns_of(variables, TABLE_OUTPUTS, "output"))
        if tire is None or not table.rows_are_independent(tire):
            return None
        axes, starts = axes_of_inputs(folder, fmu_path), _starts(table)
        present, measured, outputs = compared_columns(variables, table.survey, fmu_path)
        errors = {name: ChannelErrors(name) for name in measured}
        difference, first = 0.0, 0
        problems: tuple[str, ...] = ()
        for part in table.parts():
            rows = Recording(part, table.signs, table.survey.source).with_signs("iso").table
            time = rows["t"].to_numpy() if "t" in rows else STEP * np.arange(first, first + len(rows), dtype=np.float64)
            runs = list(_runs(starts, first, len(rows)))
            inputs = convert_signs(rows, "iso", axes)[present].to_numpy(dtype=np.float64)
            simulation = simulate(fmu_path, folder, time, inputs, present, outputs, runs, timeout)
            simulated = convert_signs(pd.DataFrame(simulation.outputs, columns=outputs), axes, "iso")
            used = rows[present].assign(t=time)
            direct = directly(tire, [used.iloc[run] for run in runs])
            difference = max(difference, largest_difference(direct, simulated))
            for name in measured:
                errors[name] = errors[name].merged(ChannelErrors.of(name, rows, simulated, present, first))
            problems, first = simulation.problems, first + len(rows)
    return CheckResult(
        fmu=Path(fmu_path).name,
        source=table.survey.source,
        fmi_version=excerpt(description.fmiVersion),
        rows=table.rows,
        segments=len(starts),
        channels=tuple(error.channel(unit_of(variables[name])) for name, error in errors.items()),
        evaluation_difference=difference,
        problems=problems,
        tolerance=tolerance,
    )


def _starts(table: LargeTable) -> list[int]:
    """Return the first row of each segment, as `Recording.segments` finds them.

    The median step is that of steps in single precision, which need half the memory.
    """
    if "t" not in table.columns:
        return [0]
    steps = np.concatenate([step.astype(np.float32) for _, step in _steps(table)])
    forward = steps[steps > 0.0]
    longest = LOGGING_GAP * float(np.median(forward, overwrite_input=True)) if len(forward) else np.inf
    cuts = [first + np.flatnonzero((step > longest) | (step < 0.0)) for first, step in _steps(table)]
    return [0, *np.concatenate(cuts).tolist()]


def _steps(table: LargeTable) -> Iterator[tuple[int, FloatArray]]:
    """Yield the steps of time that end in the rows of each part, and the row in which the first of them ends."""
    before, first = np.empty(0), 0
    for part in table.parts():
        time = part["t"].to_numpy()
        yield first + (not before.size), np.diff(time, prepend=before)
        before, first = time[-1:], first + len(time)


def _runs(starts: list[int], first: int, count: int) -> Iterator[slice]:
    """Yield the rows of each segment in a part, counted from its first row."""
    inside = np.unique([0, count, *(start - first for start in starts if first < start < first + count)])
    for start, stop in pairwise(inside.tolist()):
        yield slice(start, stop)
