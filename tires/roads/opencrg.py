"""Reading of OpenCRG files with text data: a road as a grid of heights along a reference line."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ...boundary.bounded_file import read_bounded
from ...boundary.errors import DataError, nearest, path_from, reading
from ...boundary.escaping import quoted
from .road import Road

FloatArray = npt.NDArray[np.float64]

#: Characters of a number by the format of the data; a record has 80.
_WIDTHS, _RECORD = {"LRFI": 10, "LDFI": 20}, 80
_BINARY = ("KRBI", "KDBI")
_LARGEST_FILE = 500_000_000
_PARAMETERS = ("REFERENCE_LINE_", "LONG_SECTION_V_")
#: Blocks that change the road; only their default values are read.
_CHANGES = {
    "ROAD_CRG_MODS": {"GRID_NAN_MODE": 2.0},
    "ROAD_CRG_OPTS": {"BORDER_MODE_U": 2.0, "BORDER_MODE_V": 2.0},
    "ROAD_CRG_FILE": {},
}
_SECTION = re.compile(r"long section\s+(?:at v\s*=\s*([-+.\deE]+)|(\d+))$", re.IGNORECASE)
_REFERENCE = {"reference line phi": "phi", "reference line banking": "banking", "reference line slope": "slope"}


@dataclass
class _Header:
    """What the header of a file states."""

    parameters: dict[str, float] = field(default_factory=dict)
    width: int = 0
    channels: list[str] = field(default_factory=list)
    sections: list[float | None] = field(default_factory=list)


def read_crg(path: str | Path) -> Road:
    """Read a road from an OpenCRG file with text data (LRFI or LDFI).

    The heights contain the banking and the slope of the reference line. Missing heights at the sides are equal to the
    nearest heights towards the reference line. Raises `DataError` if the file cannot be read, has binary data, changes
    the road by modifiers, another border mode or another file, or contains something that is not a number; the message
    names file and line.

    Source: ASAM OpenCRG 1.2.
    """
    file = path_from(path)
    with reading(file, DataError):
        lines = read_bounded(file, _LARGEST_FILE).decode("latin-1").split("\n")
    end = next((i for i, line in enumerate(lines) if line.startswith("$$$$")), None)
    if end is None or not lines[0].upper().startswith("$CT"):
        raise DataError(f"{file}: no OpenCRG file: it begins with $CT, and its data follow a line $$$$")
    header = _header(file, lines[:end])
    table = _numbers(file, header, lines[end + 1 :], end + 2)
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # a road has finite numbers
            return _road(header, table)
    except DataError as error:
        raise DataError(f"{file}: {error}") from None


def _header(file: Path, lines: list[str]) -> _Header:
    """Read the blocks of the header."""
    header, block = _Header(), ""
    for number, raw in enumerate(lines, 1):
        line = raw.rstrip("\r")
        if line.startswith("$"):
            block = line[1:].split("!")[0].strip().upper()
        elif line.startswith("*") or not line.split("!")[0].strip():
            continue
        elif block == "KD_DEFINITION":
            _define(header, line.split("!")[0].strip(), f"{file}, line {number}")
        elif block in ("ROAD_CRG", *_CHANGES):
            key, equals, text = line.split("!")[0].partition("=")
            key = key.strip().upper()
            default = _CHANGES.get(block, {}).get(key)
            if block == "ROAD_CRG" and not key.startswith(_PARAMETERS):
                continue
            value = _number(text) if equals else None
            if block != "ROAD_CRG" and (default is None or value != default):
                raise DataError(f"{file}, line {number}: {quoted(key)} in ${block} is not supported")
            if value is None:
                raise DataError(f"{file}, line {number}: {quoted(key)} has no number")
            header.parameters[key] = value
    if not header.width or not header.sections:
        raise DataError(f"{file}: $KD_DEFINITION has no format (#:LRFI) or no long section")
    return header


def _define(header: _Header, line: str, place: str) -> None:
    """Read a line of the definition of the data."""
    if line.startswith("#:"):
        name = line[2:].strip().upper()
        if name in _BINARY:
            raise DataError(f"{place}: binary data ({name}) are not supported: convert the file to LRFI")
        if name not in _WIDTHS:
            raise DataError(f"{place}: format {quoted(name)} is unknown{nearest(name, _WIDTHS)}")
        header.width = _WIDTHS[name]
    elif line.upper().startswith("D:"):
        name = line[2:].split(",")[0].strip()
        section = _SECTION.match(name)
        at = _number(section[1]) if section and section[1] else None
        if section is None and name.lower() not in _REFERENCE:
            raise DataError(f"{place}: channel {quoted(name)} is unknown{nearest(name, _REFERENCE)}")
        if section and section[1] and at is None:
            raise DataError(f"{place}: {quoted(section[1])} is no number")
        if not section and _REFERENCE[name.lower()] in header.channels:
            raise DataError(f"{place}: channel {quoted(name)} occurs twice")
        header.channels.append("z" if section else _REFERENCE[name.lower()])
        header.sections += [at] if section else []


def _number(text: str) -> float | None:
    """Return a finite number, or None."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _numbers(file: Path, header: _Header, lines: list[str], first: int) -> FloatArray:
    """Return the data, a row for each point of the reference line; NaN where a number is missing."""
    per_record, columns = _RECORD // header.width, len(header.channels)
    records = -(-columns // per_record)
    filled = [(number, line.rstrip("\r")) for number, line in enumerate(lines, first) if line.strip()]
    if len(filled) % records:
        raise DataError(f"{file}: {len(filled)} records are not full rows of {records}")
    rows = np.empty((len(filled) // records, columns))
    for i in range(len(rows)):
        for j in range(columns):
            number, line = filled[i * records + j // per_record]
            start = j % per_record * header.width
            text = line[start : start + header.width].strip()
            value = math.nan if "*" in text else _number(text)
            if value is None:
                raise DataError(f"{file}, line {number}: {quoted(text)} is no number")
            rows[i, j] = value
    return rows


def _road(header: _Header, table: FloatArray) -> Road:
    """Return the road of a header and its data."""
    parameters, n = header.parameters, len(table)
    increment = parameters.get("REFERENCE_LINE_INCREMENT")
    if increment is None:
        raise DataError("REFERENCE_LINE_INCREMENT is missing")
    if n < 2:
        raise DataError("the data have less than 2 rows")
    columns = np.array(header.channels)
    given = {name: table[:, header.channels.index(name)] for name in _REFERENCE.values() if name in header.channels}
    v = _positions(header)
    x, y = (parameters.get(f"REFERENCE_LINE_START_{name}", 0.0) for name in "XY")
    ahead = [parameters.get(f"REFERENCE_LINE_END_{name}", start) - start for name, start in (("X", x), ("Y", y))]
    heading = parameters.get("REFERENCE_LINE_START_PHI", math.atan2(ahead[1], ahead[0]))
    slopes = given.get("slope", np.full(n, parameters.get("REFERENCE_LINE_START_S", 0.0)))
    line = parameters.get("REFERENCE_LINE_START_Z", 0.0) + np.concatenate([[0.0], np.cumsum(increment * slopes[1:])])
    banking = given.get("banking", np.full(n, parameters.get("REFERENCE_LINE_START_B", 0.0)))
    heights = _filled(table[:, columns == "z"], v) + line[:, None] + banking[:, None] * v
    headings = given.get("phi", np.full(n, heading))
    return Road(increment, v, heights, np.concatenate([headings[1:2], headings[1:]]), (x, y))


def _positions(header: _Header) -> FloatArray:
    """Return v of the long sections."""
    parameters, n = header.parameters, len(header.sections)
    listed = [at for at in header.sections if at is not None]
    if listed and len(listed) < n:
        raise DataError("some long sections have a number, others a position v")
    if listed:
        return np.array(listed)
    right, left, step = (parameters.get(f"LONG_SECTION_V_{name}") for name in ("RIGHT", "LEFT", "INCREMENT"))
    if step is not None and right is None:
        right = left - step * (n - 1) if left is not None else -0.5 * step * (n - 1)
    if right is None or (step is None and left is None):
        raise DataError("LONG_SECTION_V_INCREMENT is missing, or LONG_SECTION_V_RIGHT and _LEFT")
    along = step * np.arange(n) if step is not None else np.linspace(0.0, (left or 0.0) - right, n)
    return np.asarray(right + along, dtype=float)


def _filled(heights: FloatArray, v: FloatArray) -> FloatArray:
    """Return heights without gaps: outwards from the reference line, a missing value is the last one."""
    filled = heights.copy()
    middle = int(np.argmin(np.abs(v)))
    for step, last in ((1, len(v) - 1), (-1, 0)):
        for j in range(middle, last, step):
            absent = np.isnan(filled[:, j + step])
            filled[absent, j + step] = filled[absent, j]
    rows = np.flatnonzero(np.isnan(filled).any(axis=1))
    if len(rows):
        raise DataError(f"row {rows[0] + 1} has no height next to the reference line")
    return filled
