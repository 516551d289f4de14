"""Where the names, the units and the numbers of a sheet of cells are: titles above, a row of units below the names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

from ...units import find_unit
from .cells import is_missing, is_number, is_time
from .content import is_unit

#: Rows at the top of a file in which the numbers begin.
SAMPLED = 400


@dataclass(frozen=True)
class Layout:
    """Rows of a sheet, counted from 0: of the names, units and sources (None without), and the first of the numbers."""

    names: int
    units: int | None
    first: int
    sources: int | None = None


def layout(rows: Sequence[Sequence[Any]]) -> Layout:
    """Return the layout of a sheet from its first rows without the blank ones.

    The numbers begin at the first row of the common width in which most cells are numbers or times. The units are the
    row above in which no cell is a number and one is a known unit; the names are the row above that. A row of sources
    ("gps", "can") may be below the units: it repeats its cells, or has fewer than the names. If most of the units are
    known, it may have any texts; without names above the units it has the names. A row of types ("float") below the
    names has few different cells. Without such a row of numbers the first row of the common width has the names.

    >>> layout([["Run title"], ["ET", "SA"], ["sec", "deg"], ["0.0", "1.5"], ["0.1", "1.6"]])
    Layout(names=1, units=2, first=3, sources=None)
    >>> layout([["t", "v", "v"], ["s", "m/s", "m/s"], ["", "gps", "can"], ["0.0", "1.5", "1.6"]])
    Layout(names=0, units=1, first=3, sources=2)
    >>> layout([["t", "v"], ["s", "m/s"], ["clock", "speed"], ["0.0", "1.5"]]).names, layout([["s", "m/s"], ["t", "v"],
    ...     ["0.0", "1.5"]]), layout([["t", "v"], ["f4", "f4"], ["s", "m/s"], ["0.0", "1.5"]]).names
    (0, Layout(names=1, units=0, first=2, sources=None), 0)
    >>> layout([["kind", "Fz"], ["first", "900"]])
    Layout(names=0, units=None, first=1, sources=None)
    """
    rows = rows[:SAMPLED]
    width = _common_width(rows)
    wide = [number for number, row in enumerate(rows) if _width(row) >= width and _filled(row)]
    numeric = [is_numeric_row(row) for row in rows]
    start = next(
        (n for n in wide if n and numeric[n] and (n + 1 >= len(rows) or numeric[n + 1] or n + 1 not in wide)), None
    )
    if start is None:
        names = next((n for n in wide if _filled(rows[n]) > 1 or width < 2), 0)
        units = names + 1 if names + 1 < len(rows) and _is_units(rows[names + 1]) else None
        return Layout(names, units, (names if units is None else units) + 1)
    above = [n for n in wide if n < start]
    if not above:
        return Layout(0, None, 1)
    *earlier, last = above
    if earlier and _is_units(rows[last]):
        return Layout(_names(rows, earlier), last, start)
    if earlier and _is_units(rows[earlier[-1]]):
        *named, units = earlier
        mostly_units = 2 * sum(find_unit(str(cell)) is not None for cell in rows[units]) >= len(rows[units])
        filled = named and _filled(rows[named[-1]]) >= _filled(rows[units])
        if named and (_are_sources(rows[last], rows[named[-1]]) or (mostly_units and filled)):
            return Layout(_names(rows, named), units, start, last)
        if mostly_units:
            return Layout(last, units, start)
    return Layout(_names(rows, above), None, last + 1)


def groups_of(names: Sequence[Any], rows: Sequence[Sequence[Any]], use: Layout) -> list[str]:
    """Return what distinguishes columns of one name: their sources, or headings above, or their numbers.

    A heading is above the first of its columns. `rows`: of the sheet, of which `use` says what they are.

    >>> groups_of(["t", "v", "v", "a", "a"], [["", "gps", "can", "calc", "calc"]], Layout(0, None, 1, sources=0))
    ['', 'gps', 'can', 'column 4', 'column 5']
    >>> groups_of(["t", "v", "a", "v", "a"], [["", "left", None, "right", ""]], Layout(1, None, 2))
    ['', 'left', 'left', 'right', 'right']
    """
    if use.sources is not None:
        written = ["" if _is_empty(source) else str(source).strip() for source in rows[use.sources]]
    else:
        above = rows[use.names - 1] if use.names else []
        written = list(accumulate(above, lambda last, cell: last if _is_empty(cell) else cell))
        written = ["" if _is_empty(cell) else str(cell).strip() for cell in written]
    columns = list(zip(names, [*written, *[""] * len(names)], strict=False))
    return [
        "" if names.count(name) == 1 else source if source and columns.count((name, source)) == 1 else f"column {i + 1}"
        for i, (name, source) in enumerate(columns)
    ]


def _names(rows: Sequence[Sequence[Any]], above: Sequence[int]) -> int:
    """Return the last of some rows; the one above it if that has as many cells, all different, and the last few."""
    *_, earlier, last = (0, *above)
    names, types = ([str(cell).strip() for cell in rows[row] if not _is_empty(cell)] for row in (earlier, last))
    few = 2 * len(set(types)) <= len(types) <= len(names)
    return earlier if len(above) > 1 and few and len(set(names)) == len(names) else last


def _common_width(rows: Sequence[Sequence[Any]]) -> int:
    """Return the width of most rows, the larger one of two that are equally common."""
    widths = Counter(map(_width, rows))
    return max(widths, key=lambda width: (widths[width], width), default=0)


def _width(row: Sequence[Any]) -> int:
    return len(row)


def _filled(row: Sequence[Any]) -> int:
    return sum(not _is_empty(cell) for cell in row)


def _is_empty(cell: Any) -> bool:
    return cell is None or cell != cell or (isinstance(cell, str) and not cell.strip())


def is_numeric_row(row: Sequence[Any]) -> bool:
    """Return whether most cells of a row are numbers, times or missing values, and one is not missing."""
    cells = [cell for cell in row if not _is_empty(cell)]
    values = sum(is_number(cell) or is_time(cell) for cell in cells)
    return values > 0 and 2 * sum(is_number(cell) or is_time(cell) or is_missing(cell) for cell in cells) > len(cells)


def _are_sources(row: Sequence[Any], names: Sequence[Any]) -> bool:
    """Return whether a row below the units has sources and no names: cells repeat, or names have none."""
    cells = [str(cell).strip() for cell in row if not _is_empty(cell)]
    return len(set(cells)) < len(cells) or len(cells) < _filled(names)


def _is_units(row: Sequence[Any]) -> bool:
    """Return whether a row has units: a known one at least, and no number but 1."""
    cells = [str(cell).strip() for cell in row if not _is_empty(cell)]
    return any(map(is_unit, cells)) and all(cell in ("1", "-") or not is_number(cell) for cell in cells)
