"""RaceLogic VBOX logs (``.vbo``): sections in brackets, names in ``[column names]``, rows separated by blanks."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ....boundary.errors import DataError
from ....numerics.arrays import FloatArray
from ..columns.cells import DAY, has_decimal_commas, numbers, rows_of_cells
from ..columns.content import DECIMAL_COMMAS, Column, Content, is_unit
from ..columns.layout import SAMPLED
from ..encoding import encoding_of

#: Units of ``[header]`` ("velocity kmh", "Lat accel g") with another meaning elsewhere.
_UNITS = {"ms": "m/s"}


def read_vbo(path: Path) -> Content:
    """Return the content of a VBOX log; times are those of the day in s, positions in minutes, west positive.

    Raises `DataError` if a section is missing, or a row has another number of cells than there are names.
    """
    sections: dict[str, list[tuple[int, str]]] = {}
    rows: list[tuple[int, str]] = []
    with path.open(encoding=encoding_of(path)) as file:
        for number, line in enumerate(file, start=1):
            text = line.strip()
            if text.startswith("[") and text.endswith("]"):
                rows = sections.setdefault(text[1:-1].strip().casefold(), [])
            elif text:
                rows.append((number, text))
    for name in ("column names", "data"):
        if name not in sections:
            raise DataError(f"{path}: no section [{name}]: not a VBOX log")
    names = " ".join(text for _, text in sections["column names"]).split()
    data = sections["data"]
    commas = has_decimal_commas(text.split() for _, text in data[:SAMPLED])
    cells = rows_of_cells(((number, text.split()) for number, text in data), names, str(path), commas=commas)
    long_names = [text for _, text in sections.get("header", [])]
    units = _units(names, long_names, [text for _, text in sections.get("channel units", [])])

    def location(row: int) -> str:
        return f"line {data[row][0]}"

    columns = []
    for i, name in enumerate(names):
        if name.casefold() == "time":
            day = _time_of_day(numbers(cells[:, i], str(path), "column time", location)[0])
            columns.append(Column(name, day, "s", "t"))
        else:
            columns.append(Column(name, cells[:, i], units.get(name, "")))
    return Content(tuple(columns), location, "vbo", about=DECIMAL_COMMAS if commas else {})


def _units(names: list[str], long_names: list[str], declared: list[str]) -> dict[str, str]:
    """Return units by column: of ``[header]``, whose lines are in the order of the columns, and of ``[channel units]``.

    The latter belong to the last columns, those of other devices.
    """
    units = {}
    if len(long_names) == len(names):
        for name, long_name in zip(names, long_names, strict=True):
            _, blank, unit = long_name.strip().rpartition(" ")
            if blank and is_unit(unit) and not unit.isdigit():
                units[name] = _UNITS.get(unit.casefold(), unit)
    else:
        units = {name: "km/h" for name in names if name == "velocity" and "velocity kmh" in long_names}
    return units | dict(zip(reversed(names), reversed(declared), strict=False))


def _time_of_day(values: FloatArray) -> FloatArray:
    """Return seconds of HHMMSS.sss; the day continues behind midnight."""
    hours, rest = np.divmod(values, 10000.0)
    minutes, seconds = np.divmod(rest, 100.0)
    day = 3600.0 * hours + 60.0 * minutes + seconds
    return np.asarray(day + DAY * np.cumsum(np.diff(day, prepend=day[:1]) < -0.5 * DAY))
