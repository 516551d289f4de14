"""What the window shows of the tables: columns, time histories with the state of each row, operating conditions."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...boundary.errors import TirefmuError
from ...boundary.escaping import excerpt, toml_string
from ...drawing.labels import drawn_unit, drawn_value
from ...measurements import (
    CHANNELS,
    EXCLUSION_REASONS,
    Recording,
    data_findings,
    exclude_rows,
    held_levels,
    recording_from,
)
from ...measurements.checks.columns.check import MAX_READINGS
from ...measurements.checks.columns.explanation import explanation
from ...measurements.checks.columns.meanings import column_meanings
from ...measurements.inspection.inspection import inspected
from ...measurements.inspection.tables import channel_table, title
from ...measurements.row_selection.selected import matching
from ...measurements.units import UNITS_OF_TABLES
from ..project.project_file import Project

#: States of a row, in the order of their codes in `series`.
STATES = ("fitted", "excluded by the project", "held out", *EXCLUSION_REASONS)
#: Upper limit of the rows of a time history; of more, every k-th is shown.
MAX_SHOWN = 100_000
#: Inputs of the grid of operating conditions: across, down, one grid for each.
GRID = ("Fz", "gamma", "p")


@lru_cache(maxsize=32)
def _read(path: Path, changed: int, size: int, meaning: str) -> Recording:
    return recording_from(path, **json.loads(meaning))


def recording_of(path: Path, project: Project) -> Recording:
    """Return all rows of a table; a file that has not changed is read once. Raises `TirefmuError`."""
    try:
        status = path.stat()
    except OSError as error:
        raise TirefmuError(f"{path}: cannot be read ({error.strerror or error})") from error
    meaning = {key: project.get("data", key) for key in ("signs", "columns", "units")}
    return _read(path, status.st_mtime_ns, status.st_size, json.dumps(meaning))


def selected_recordings(project: Project, *, fitted: bool) -> list[Recording]:
    """Return the recordings of the steps, or with `fitted` those of the fit. Raises `TirefmuError`."""
    rows = project.rows(fitted=fitted)
    return [recording_from(recording_of(path, project), where=rows) for path in project.tables]


@dataclass(frozen=True)
class RowStates:
    """The state of each row of a recording.

    - `codes`, shape (n,): indices of `STATES`.
    """

    codes: NDArray[np.uint8]

    @classmethod
    def of(cls, recording: Recording, project: Project) -> RowStates:
        """Return the states of all rows of a recording. Raises `TirefmuError` for an invalid selection."""
        codes = np.zeros(len(recording), dtype=np.uint8)
        rows, fitted = project.rows(), project.rows(fitted=True)
        used = np.ones(len(recording), dtype=np.bool_) if rows is None else matching(recording, rows)
        if used.any():
            part = recording if used.all() else recording_from(recording, where=rows)
            reasons = exclude_rows(part).reasons
            numbers = {reason: STATES.index(reason) for reason in EXCLUSION_REASONS}
            codes[used] = [numbers.get(reason, 0) for reason in reasons]
        codes[~used] = 1
        if fitted != rows and fitted is not None:
            codes[used & ~matching(recording, fitted)] = 2
        return cls(codes)

    @property
    def counts(self) -> dict[str, int]:
        """Rows of each state that occurs."""
        numbers = np.bincount(self.codes, minlength=len(STATES))
        return {state: int(number) for state, number in zip(STATES, numbers, strict=True) if number}


def tables_view(project: Project) -> list[dict[str, Any]]:
    """Return what is shown of each table: a summary, or the error in place of it."""
    recordings: list[Recording | str] = []
    for path in project.tables:
        try:
            recordings.append(recording_of(path, project))
        except TirefmuError as error:
            recordings.append(excerpt(error))
    # An expression is applied to every table.
    common = [
        name for name in GRID if all(isinstance(recording, str) or name in recording.table for recording in recordings)
    ]
    return [
        _table_view(path, recording, common, project)
        for path, recording in zip(project.tables, recordings, strict=True)
    ]


def _table_view(path: Path, recording: Recording | str, common: Sequence[str], project: Project) -> dict[str, Any]:
    shown: dict[str, Any] = {"name": path.name, "meanings": _meanings(recording, project)}
    if isinstance(recording, str):
        return shown | {"error": recording}
    try:
        states = RowStates.of(recording, project)
        inspection = inspected(recording)
    except TirefmuError as error:
        return shown | {"error": excerpt(error)}
    header, rows = channel_table(inspection)
    return shown | {
        "title": title(inspection),
        "signs": recording.signs,
        "counts": states.counts,
        "columns": {"header": header, "rows": rows},
        "corrections": corrections(recording, project),
        "channels": [name for name in CHANNELS if name in recording.table and name != "t"],
        "ignored": [excerpt(name, 40) for name in map(str, recording.table.columns) if name not in CHANNELS][:50],
        "findings": [{"text": str(finding), "serious": finding.serious} for finding in data_findings([recording])],
        "grid": condition_grid(recording, states, common),
    }


def _meanings(recording: Recording | str, project: Project) -> list[dict[str, Any]]:
    """Return what each column was taken for, and what the project has in its place."""
    meanings = (
        {} if isinstance(recording, str) else {meaning.channel: meaning for meaning in column_meanings(recording)}
    )
    columns, units = project.get("data", "columns", {}), project.get("data", "units", {})
    return [
        {
            "channel": name,
            "taken_for": meanings[name].taken_for if name in meanings else "no column",
            "evidence": meanings[name].evidence if name in meanings else "",
            "column": columns.get(name, ""),
            "unit": units.get(name, ""),
            "units": list(UNITS_OF_TABLES.get(channel.quantity, ())),
        }
        for name, channel in CHANNELS.items()
    ]


def corrections(recording: Recording, project: Project) -> list[dict[str, Any]]:
    """Return the readings that explain a refused table: each in words, with the keys of ``[data]`` that apply it."""
    columns, units = project.get("data", "columns", {}), project.get("data", "units", {})
    readings = []
    for hypothesis in explanation(recording).better[:MAX_READINGS]:
        reading = hypothesis.hypothesis
        keys: dict[str, Any] = {"signs": reading.signs} if reading.signs != recording.signs else {}
        if reading.interpretation.columns:
            keys["columns"] = columns | {
                name: _composed(columns, source) for name, source in reading.interpretation.columns.items()
            }
        if reading.interpretation.units:
            keys["units"] = units | dict(reading.interpretation.units)
        readings.append({"text": reading.described(recording.signs), "keys": keys})
    return readings


def _composed(columns: Mapping[str, str], source: str) -> str:
    """Return the column of the file that has a channel, or with a minus the channel with the other sign.

    >>> _composed({"Fy": "-FYC"}, "-Fy"), _composed({"Fy": "FYC"}, "-Fy"), _composed({}, "Fx")
    ('FYC', '-FYC', 'Fx')
    """
    name = source.removeprefix("-")
    column = columns.get(name, name)
    reversed_sign = source.startswith("-") != column.startswith("-")
    return f"{'-' if reversed_sign else ''}{column.removeprefix('-')}"


def series(recording: Recording, channel: str, project: Project) -> dict[str, Any]:
    """Return a time history: samples from 1, values in the unit of figures, states, first and last row of sweeps.

    Columns are base64 texts of little-endian numbers. Raises `TirefmuError` if the recording lacks the channel.
    """
    if channel not in CHANNELS or channel not in recording.table:
        raise TirefmuError(f"{recording.source} has no channel {excerpt(channel, 40)}")
    step = -(-len(recording) // MAX_SHOWN)
    values = drawn_value(channel, recording.table[channel].to_numpy(dtype=np.float64)[::step])
    codes = RowStates.of(recording, project).codes[::step]
    inspection = inspected(recording)
    clock = recording.table["t"].to_numpy(dtype=np.float64)[::step] if "t" in recording.table else None
    return {
        "step": step,
        "unit": drawn_unit(channel),
        "values": _encoded(values, "<f4"),
        "t": None if clock is None else _encoded(clock, "<f4"),
        "codes": _encoded(codes, "<u1"),
        "sweeps": [[sweep.first, sweep.last, " and ".join(sweep.moving)] for sweep in inspection.sweeps],
    }


def _encoded(values: NDArray[Any], kind: str) -> str:
    return b64encode(values.astype(kind).tobytes()).decode("ascii")


def rows_expression(source: str, first: int, last: int, *, inside: bool) -> str:
    """Return the expression of consecutive rows of a file, or of its rows outside of them.

    `source`: name of the file. `first`, `last`: numbers of rows from 1.

    >>> rows_expression("run.csv", 3, 9, inside=True)
    'file == "run.csv" and sample in 3..9'
    """
    if '"' in source or not source.isprintable():
        raise TirefmuError("rows of a file with such a name are not selected: rename it")
    return f"file == {toml_string(source)} and sample {'in' if inside else 'not in'} {first}..{last}"


def condition_grid(recording: Recording, states: RowStates, inputs: Sequence[str] = GRID) -> list[dict[str, Any]]:
    """Return the cells of load x camber x pressure that have rows: levels, rows, states, expression of its rows.

    `inputs`: channels of the recording, of `GRID`.
    """
    numbers, edges = [], {}
    for name in inputs:
        values = recording.table[name].to_numpy(dtype=np.float64)
        values = -values if name == "Fz" and recording.signs == "sae" else values
        edges[name] = _edges(held_levels(recording.table[name].abs() if name == "Fz" else recording.table[name]))
        numbers.append(np.clip(np.searchsorted(edges[name][0], values, side="right") - 1, 0, None))
    if not numbers:
        return []
    combinations, cell_of = np.unique(np.stack(numbers), axis=1, return_inverse=True)
    cells = []
    for index, place in enumerate(combinations.T):
        codes = states.codes[cell_of.ravel() == index]
        parts = [f"file == {toml_string(recording.source)}"] + [
            _between(name, edges[name][0][at], edges[name][0][at + 1]) for name, at in zip(inputs, place, strict=True)
        ]
        levels = {name: drawn_value(name, edges[name][1][at]) for name, at in zip(inputs, place, strict=True)}
        cells.append(
            {
                "levels": {name: None if level != level else round(level, 3) + 0.0 for name, level in levels.items()},
                "units": {name: drawn_unit(name) for name in inputs},
                "rows": len(codes),
                "fitted": int(np.count_nonzero(codes == 0)),
                "excluded": int(np.count_nonzero(codes == 1)),
                "held_out": int(np.count_nonzero(codes == 2)),
                "expression": " and ".join(part for part in parts if part),
            }
        )
    return cells


def _edges(levels: Sequence[float]) -> tuple[list[float], list[float]]:
    """Return the edges between levels, and the levels; a channel without levels is one cell."""
    if not len(levels):
        return [-inf, inf], [float("nan")]
    ordered = sorted(levels)
    middles = [0.5 * (a + b) for a, b in pairwise(ordered)]
    return [-inf, *middles, inf], list(ordered)


def _between(name: str, low: float, high: float) -> str:
    """Return the expression of a range in the unit of figures; empty for all values."""
    unit = drawn_unit(name).replace("-", "")
    parts = [f"{name} > {drawn_value(name, low):.6g} {unit}"] if low > -inf else []
    parts += [f"{name} <= {drawn_value(name, high):.6g} {unit}"] if high < inf else []
    return " and ".join(parts)
