"""FSAE Tire Test Consortium (Calspan) files in MATLAB format, and other MATLAB vectors, tables and timetables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.errors import DataError
from ...numerics.arrays import FloatArray
from . import native_reader
from .columns.cells import numbers
from .columns.content import Column, Content, listed
from .columns.frames import frame_columns
from .loggers.modelica_result import is_result, result_content
from .ttc_channels import bench_content, has_bench_names

#: Names of the times of a struct, in lower case.
TIMES = ("t", "time", "timestamp")
#: Names of the values and the unit in a struct of one quantity, in lower case, as of exports of MoTeC i2.
VALUE_FIELDS, UNIT_FIELDS = ("value", "values", "data"), ("unit", "units")
EXTRA = "mat-io, which the extra 'matlab' installs: pip install 'tirefmu[matlab]'"


def read_mat(path: Path) -> Content:
    """Return the content of a ``.mat`` file: a file of the FSAE TTC, or other channels.

    The channels are those of a Modelica tool's result, variables of the file, or fields of a struct, a table or a
    timetable, whose row times are the time.
    Units are those of the ``channel`` struct of the TTC or of the table. Dates of all clocks count from the earliest
    one. Fields that are known to be unreliable (RUN of the wrong length, an empty tireid) are not used.

    Raises `DataError` if the file is not a MATLAB file, or if mat-io is not installed and the file has a table or
    version 7.3.
    """
    fields = _load(path)
    if is_result(fields):
        try:
            return result_content(fields)
        except (IndexError, ValueError):
            raise DataError(f"{path}: names and tables of this result of a Modelica tool do not fit") from None
    units = dict(_channel_units(fields))
    columns: list[Column] = []
    texts: dict[str, Any] = {}
    structs = {name: {} if name == "channel" else dict(_fields(value)) for name, value in fields.items()}
    origin = _earliest(chain(fields.values(), *(inside.values() for inside in structs.values())))
    for name, value in fields.items():
        inside = structs[name]
        texts |= {key: inside[key] for key in ("tireid", "testid", "source") if key in inside}
        if isinstance(value, pd.DataFrame):
            columns += [replace(column, group=name) for column in frame_columns(value, dict(_table_units(value)))]
        columns += _columns(name, inside, origin)
        if (cells := _vector(value)) is not None:
            columns.append(Column(name, cells))
    texts = {key: fields.get(key, texts.get(key)) for key in ("tireid", "testid", "source")}
    columns = [replace(column, unit=column.unit or units.get(column.header, "")) for column in columns]
    columns = _with_own_times(columns, origin)
    used = {
        "channel",
        *texts,
        *(column.header for column in columns),
        *(column.group.partition(".")[0] for column in columns),
    }
    others = [name for name in fields if name not in used]
    content = Content(tuple(columns), ignored=(f"variables {listed(others)}",) if others else ())
    if not has_bench_names([column.header for column in columns]):
        return content
    about = {("credit" if key == "source" else key): _text(value) for key, value in texts.items()}
    return bench_content(replace(content, signs="sae", about=about), path.name)


def _columns(name: str, inside: Mapping[str, Any], origin: np.datetime64 | None) -> Iterator[Column]:
    """Yield the columns of a variable from the fields of its structs.

    The values of a struct of one quantity, with or without times, have its name, and the unit of its field of units.
    """
    structs: dict[str, dict[str, Any]] = {}
    for key, part in inside.items():
        group, _, field = f"{name}.{key}".rpartition(".")
        structs.setdefault(group, {})[field] = part
    for group, parts in structs.items():
        vectors = {field: cells for field, part in parts.items() if (cells := _vector(part)) is not None}
        values = [field for field in vectors if field.casefold() not in TIMES]
        if len(values) == 1 and values[0].casefold() in VALUE_FIELDS:
            (field,) = values
            unit = next((_text(part) for name, part in parts.items() if name.casefold() in UNIT_FIELDS), "")
            clocks = [_times(cells, origin) for name, cells in vectors.items() if name != field]
            times = next((times for times in clocks if len(times) == len(vectors[field])), None)
            outer, _, header = group.rpartition(".")
            yield Column(header, vectors[field], unit, group=outer, times=times)
        else:
            yield from (Column(field, cells, group=group) for field, cells in vectors.items())


def _with_own_times(columns: list[Column], origin: np.datetime64 | None) -> list[Column]:
    """Return the columns of several timetables or structs with the times of their own one; others unchanged."""
    clocks = [
        column for column in columns if column.meant == "t" or (column.group and column.header.casefold() in TIMES)
    ]
    if len({clock.group for clock in clocks}) < 2:
        return columns
    times = {clock.group: _times(clock.cells, origin) for clock in clocks}
    unchosen = [column for column in columns if column not in clocks]
    return [
        replace(column, times=times[column.group]) if len(column.cells) == len(times.get(column.group, ())) else column
        for column in unchosen
    ]


def _times(cells: Any, origin: np.datetime64 | None) -> FloatArray:
    return numbers(cells, "", "", str, clock=True, origin=origin)[0]


def _earliest(values: Iterable[Any]) -> np.datetime64 | None:
    """Return the earliest date of vectors and of row times; None if there is none."""
    vectors = (value.index.to_numpy() if isinstance(value, pd.DataFrame) else _vector(value) for value in values)
    dates = [np.fmin.reduce(cells) for cells in vectors if cells is not None and cells.dtype.kind == "M" and len(cells)]
    return min(dates, default=None)


def _load(path: Path) -> Mapping[str, Any]:
    try:
        loaded = native_reader.load("matlab", path)
    except native_reader.MissingPackage as content:
        raise DataError(f"{path}: {content} need {EXTRA}") from None
    return {name: value for name, value in loaded.items() if not name.startswith("__")}


def _struct(value: Any) -> dict[str, Any]:
    """Return the fields of a struct of one element; none for other values."""
    cell = value.flat[0] if isinstance(value, np.ndarray) and value.size == 1 else value
    names = getattr(cell, "_fieldnames", None) or getattr(getattr(cell, "dtype", None), "names", None) or ()
    return {name: getattr(cell, name) if hasattr(cell, "_fieldnames") else cell[name] for name in names}


def _fields(value: Any, prefix: str = "", depth: int = 4) -> Iterator[tuple[str, Any]]:
    """Yield the fields of a struct, and those of structs in it behind the names of these."""
    for name, part in _struct(value).items():
        yield f"{prefix}{name}", part
        if depth:
            yield from _fields(part, f"{prefix}{name}.", depth - 1)


def _vector(value: Any) -> Any:
    """Return the cells of a variable that is a row or column vector of numbers, dates or durations, otherwise None."""
    if isinstance(value, np.ndarray) and value.dtype.kind in "fiuMm" and value.size == max(value.shape, default=1):
        return np.ravel(value)
    return None


def _channel_units(fields: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield name and unit of the channels in the struct of the FSAE TTC."""
    channel = _struct(fields.get("channel"))
    names, spelled = (np.ravel(channel.get(part, np.empty(0))) for part in ("name", "units"))
    for name, unit in zip(names, spelled, strict=False):
        yield _text(name), _text(unit)


def _table_units(table: pd.DataFrame) -> Iterator[tuple[str, str]]:
    """Yield name and unit of the variables of a table or a timetable."""
    given = next((table.attrs[key] for key in ("VariableUnits", "varUnits") if len(table.attrs.get(key, ()))), ())
    for name, unit in zip(table, np.ravel(np.asarray(given, dtype=object)), strict=False):
        if _text(unit):
            yield str(name), _text(unit)


def _text(value: Any) -> str:
    """Return the text in nested MATLAB cells and structs; empty if there is none."""
    while isinstance(value, np.ndarray) and value.dtype.names is None:
        if not value.size:
            return ""
        value = value.flat[0]
    inside = _struct(value)
    if inside:
        return ", ".join(text for text in map(_text, inside.values()) if text)
    return "" if value is None else str(value)
