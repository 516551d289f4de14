"""Cells of a column as numbers: dates, durations and elapsed times as seconds, texts of a status as missing values."""

from __future__ import annotations

import re
from array import array
from collections.abc import Callable, Iterable, Sequence
from datetime import date, datetime, time, timedelta
from typing import Any

import numpy as np
import pandas as pd

from ....boundary.errors import DataError
from ....numerics.arrays import FloatArray

DAY = 86400.0
#: Texts of loggers and benches in place of a value, in lower case without blanks and punctuation.
MISSING = frozenset(
    ("", "na", "nan", "null", "none", "notavail", "notavailable", "invalid", "nodata", "missing", "error", "fault",
     "overflow", "underflow", "ol", "sna", "bad", "offline", "timeout", "inactive", "nosignal", "signalnotavailable")
)  # fmt: skip
_COMMA = re.compile(r"[-+\u2212]?\d*,\d+(?:[eEdD][-+]?\d+)?")
#: The minus sign of typography, and Fortran's exponents.
_SPELLED = str.maketrans("\u2212dD", "-ee")
_COMMAS, _POINT = re.compile(rf"\s*{_COMMA.pattern}\s*"), re.compile(rf"\s*{_COMMA.pattern.replace(',', '[.]')}\s*")
#: A number with marks between thousands: with a mark before decimals, too, in either order, or blanks or apostrophes.
_BOTH = re.compile(r"[-+]?\d{1,3}(?:(?:(?:\.\d{3})+,|(?:,\d{3})+\.)\d+|(?:[\s'\u2019]\d{3})+(?:[.,]\d*)?)")
#: A number whose comma may separate thousands.
_THOUSANDS = re.compile(r"\s*[-+]?[1-9]\d{0,2}(,\d{3})+\s*")
_ELAPSED = re.compile(
    r"(?P<sign>-)?(?:(?P<days>\d{1,6}) ?(?:days?|d) ?\+?)?(?:(?P<hours>\d{1,6}):)?(?P<minutes>\d{1,6}):"
    r"(?P<seconds>\d{1,2}(?:[.,]\d{1,12})?)"
)
_DATE = re.compile(r"\d{4}-\d\d-\d\d|\d\d?(?:[./]\d\d?[./]|-[A-Za-z]{3}-)\d{4}\b")
#: Integers beyond this one are not exact as floats.
_EXACT = 2**53


def numbers(
    cells: Any,
    source: str,
    label: str,
    location: Callable[[int], str],
    *,
    clock: bool = False,
    origin: np.datetime64 | None = None,
) -> tuple[FloatArray, bool]:
    """Return the cells as floats, and whether they are seconds by their type: dates, durations, elapsed times.

    `source`, `label`: file and column for messages. `location`: as of `Content`. `clock`: whether the column is a
    time. Dates count from `origin`, by default the first one, and a time of day that passes midnight continues. Raises
    `DataError` with the first cell that is not a number.
    """
    cells = pd.Series(cells).reset_index(drop=True)
    if cells.dtype.kind in "Mm" and clock:
        return _seconds(cells, origin), True
    if pd.api.types.is_bool_dtype(cells):
        cells = cells.astype(str)  # a truth value is not a number
    if pd.api.types.is_numeric_dtype(cells):
        if clock and cells.dtype.kind in "iu" and len(cells) and abs(int(cells.iloc[-1])) > _EXACT:
            cells = cells - cells.iloc[0]
        return cells.to_numpy(dtype=np.float64, na_value=np.nan), False
    objects = cells.to_numpy(dtype=object, na_value=np.nan)
    try:
        return objects.astype(np.float64), False  # float() reads decimals exactly
    except (TypeError, ValueError):
        pass
    if clock and (seconds := _clock(objects)) is not None:
        return seconds, True
    return np.array([_number(cell, row, source, label, location) for row, cell in enumerate(objects)]), False


def has_decimal_commas(rows: Iterable[Sequence[str]]) -> bool:
    """Return whether the numbers of a text file have decimal commas.

    They do if a comma cannot separate thousands, and no row with such a number has one with a point.

    >>> [has_decimal_commas([row]) for row in (["0,5", "1,250"], ["12", "1,250"], ["0,5", "1.2"])]
    [True, False, False]
    """
    decisive = False
    for row in rows:
        if any(_COMMAS.fullmatch(cell) for cell in row):
            decisive |= any(_COMMAS.fullmatch(cell) and not _THOUSANDS.fullmatch(cell) for cell in row)
            if any(_POINT.fullmatch(cell) for cell in row):
                return False
    return decisive


def with_point(cell: str) -> str:
    """Return a number with a decimal comma with a point in its place; any other text as it is.

    >>> with_point("-0,5"), with_point("31,12,2025")
    ('-0.5', '31,12,2025')
    """
    return cell.replace(",", ".") if _COMMAS.fullmatch(cell) else cell


def has_point(cell: str) -> bool:
    """Return whether a text is a number with a point.

    >>> has_point("1.5"), has_point("1,5"), has_point("15")
    (True, False, False)
    """
    return bool(_POINT.fullmatch(cell))


def with_comma_and_point(name: str, cell: str) -> str:
    """Return the message about a number with a point, which may separate thousands, among decimal commas."""
    return f"column {name.strip()}: {cell!r} has a point, other numbers have decimal commas"


def first_with_point(cells: pd.Series) -> int | None:
    """Return the row of the first number with a point, which may separate thousands among decimal commas."""
    pointed = np.flatnonzero(cells.str.fullmatch(_POINT, na=False))
    return int(pointed[0]) if len(pointed) else None


def is_number(cell: Any) -> bool:
    """Return whether a cell is a number, in any program's spelling.

    >>> is_number("1e3"), is_number("N")
    (True, False)
    """
    try:
        number_of(cell)
    except (TypeError, ValueError):
        return False
    return True


def number_of(cell: Any) -> float:
    """Return the number of a cell; raises what `float` raises if it is none.

    >>> number_of("1.5D-1"), number_of("\u22122")
    (0.15, -2.0)
    """
    return float(cell.translate(_SPELLED) if isinstance(cell, str) else cell)


def is_missing(cell: Any) -> bool:
    """Return whether a cell has no value: empty, or a text of a status.

    >>> is_missing("No Data"), is_missing("--"), is_missing("high")
    (True, True, False)
    """
    return isinstance(cell, str) and re.sub(r"[\W_]+", "", cell).casefold() in MISSING


def is_time(cell: Any) -> bool:
    """Return whether a cell is a date, a duration or an elapsed time.

    >>> is_time("01:02.5"), is_time("2024-05-01 10:00:00"), is_time("01-May-2024 10:00:00"), is_time("12.5")
    (True, True, True, False)
    """
    if isinstance(cell, (date, time, timedelta, np.datetime64, np.timedelta64)):
        return True
    return isinstance(cell, str) and bool(_ELAPSED.fullmatch(cell.strip()) or _DATE.match(cell.strip()))


def _number(cell: Any, row: int, source: str, label: str, location: Callable[[int], str]) -> float:
    if is_number(cell):
        return number_of(cell)
    if is_missing(cell):
        return float("nan")
    shown = str(cell)
    hint = f": a decimal comma? write {shown.replace(',', '.')}" if _COMMA.fullmatch(shown.strip()) else ""
    hint = ": export it without marks between thousands" if _BOTH.fullmatch(shown.strip()) else hint
    raise DataError(f"{source}: {location(row)}: {label}: {shown!r} is not a number{hint}")


def _seconds(cells: pd.Series, origin: np.datetime64 | None = None) -> FloatArray:
    if cells.dtype.kind == "M":
        first = cells.dropna().iloc[0] if cells.notna().any() else pd.NaT
        cells = cells - (first if origin is None else pd.Timestamp(origin).tz_localize(cells.dt.tz))
    whole = cells.to_numpy(dtype="timedelta64[ns]").astype(np.int64)
    return np.where(cells.isna(), np.nan, whole / 1e9)


def _clock(objects: Any) -> FloatArray | None:
    """Return elapsed times or dates as seconds; None if they are neither."""
    present = [cell for cell in objects if not (is_missing(cell) or cell is None or cell != cell)]
    if all(isinstance(cell, (time, timedelta)) or _ELAPSED.fullmatch(str(cell).strip()) for cell in present):
        seconds = np.array([_elapsed(cell) for cell in objects])
        # A time of day restarts at midnight.
        steps = np.diff(seconds, prepend=seconds[:1])
        return np.asarray(seconds + DAY * np.cumsum(np.nan_to_num(steps) < -0.5 * DAY))
    if all(is_time(cell) or isinstance(cell, datetime) for cell in present):
        for form in ("ISO8601", None):
            try:
                return _seconds(pd.to_datetime(pd.Series(objects), utc=True, format=form))
            except (ValueError, TypeError, OverflowError):
                continue
    return None


def _elapsed(cell: Any) -> float:
    if isinstance(cell, timedelta):
        return cell.total_seconds()
    if isinstance(cell, time):
        return 3600.0 * cell.hour + 60.0 * cell.minute + cell.second + 1e-6 * cell.microsecond
    match = _ELAPSED.fullmatch(str(cell).strip())
    if match is None:
        return float("nan")
    days, hours, minutes = (float(match[part] or 0.0) for part in ("days", "hours", "minutes"))
    size = DAY * days + 3600.0 * hours + 60.0 * minutes + float(match["seconds"].replace(",", "."))
    return -size if match["sign"] else size


def rows_of_cells(
    rows: Iterable[tuple[int, Sequence[str]]], names: Sequence[str], source: str, *, commas: bool = False
) -> Any:
    """Return the cells of the rows of a text file, shape (n, number of names): numbers, or texts if one is none.

    `rows`: line number and cells of each. `commas`: whether numbers have decimal commas. Raises `DataError` if there is
    no row, one has another number of cells than there are names, or a number has a point beside decimal commas.
    """
    values, texts = array("d"), []  # 8 bytes each; a list of texts needs ten times as much
    for line, cells in rows:
        if len(cells) != len(names):
            raise DataError(f"{source}: line {line}: {len(cells)} cells for {len(names)} channels")
        if commas:
            if (pointed := next((i for i, cell in enumerate(cells) if has_point(cell)), None)) is not None:
                raise DataError(f"{source}: line {line}: {with_comma_and_point(names[pointed], cells[pointed])}")
            cells = list(map(with_point, cells))
        try:
            values.extend(map(float, cells))
        except ValueError:
            del values[len(values) - len(values) % len(names) :]
            texts.append((len(values) // len(names), list(cells)))
            values.extend([np.nan] * len(names))
    if not values:
        raise DataError(f"{source}: no rows")
    table = np.array(values).reshape(-1, len(names))
    if not texts:
        return table
    mixed = table.astype(object)
    for row, cells in texts:
        mixed[row] = cells
    return mixed
