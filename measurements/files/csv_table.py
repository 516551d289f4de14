"""CSV tables, of any program: titles above the names, units below them or in the headers."""

from __future__ import annotations

import csv
import re
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TextIO

import numpy as np
import pandas as pd

from ...boundary.errors import DataError
from .columns.cells import first_with_point, has_decimal_commas, with_comma_and_point, with_point
from .columns.content import DECIMAL_COMMAS, MAX_COLUMNS, Column, Content
from .columns.layout import SAMPLED, groups_of, is_numeric_row, layout
from .encoding import encoding_of

_SEPARATORS = ",;\t"
#: Upper limits: characters of a line up to the header's end; lines in which a table begins; cells that its rows lack.
LONGEST_LINE, MOST_ABOVE, MAX_ABSENT = 1_000_000, 100_000, 10_000_000
_DIGITS = re.compile(r" *-?\d*(e-?\d+)? *")
#: A header of RaceCapture: name, unit, lowest and highest value, and rate.
_RACECAPTURE = re.compile(r'"?(?P<name>[^"|]+)"?\|"?(?P<unit>[^"|]*)"?\|[^|]*\|[^|]*\|[^|]*')


def read_csv(path: Path) -> Content:
    """Return the content of a CSV file.

    Lines that begin with ``#`` above the names are skipped, and so are titles and blocks of information. If the numbers
    have no names above them, these lines have them, as in the files of `numpy.savetxt` and of CarMaker. Columns are
    separated by commas, semicolons or tabs; numbers may have decimal commas. Numbers are read exactly. Raises
    `DataError` with file and line of the first row that is wider than the header.
    """
    with _opened(path) as file:
        comments, sample = _sample(file, path)
    separator = max(_SEPARATORS, key=lambda mark: _plausible([text for _, text in sample], mark))
    rows = _cells(sample, path, separator)
    if not rows:
        raise DataError(f"{path}: the file is empty")
    commas = has_decimal_commas(row for _, row in rows)
    if is_numeric_row(list(map(with_point, rows[0][1]))):
        rows = [(line, row) for line, row in _cells(comments, path, separator) if len(row) == len(rows[0][1])] + rows
    rows_by_use = layout([list(map(with_point, row)) if commas else row for _, row in rows])
    skipped = rows[rows_by_use.first - 1][0]
    names, units = rows[rows_by_use.names][1], [] if rows_by_use.units is None else rows[rows_by_use.units][1]
    if captured := [match for name in names if (match := _RACECAPTURE.fullmatch(name.strip()))]:
        names, units = ([match[part] for match in captured] for part in ("name", "unit"))
    table = _body(path, skipped, len(names), separator)
    units = [*(unit.strip(" []()") for unit in units), *[""] * len(names)]
    location = partial(_location, path, skipped)
    if commas:
        table = table.apply(_with_points, path=path, names=names, location=location)
    groups = groups_of(names, [row for _, row in rows], rows_by_use)
    columns = tuple(
        Column(name.strip(), _exact(table.iloc[:, i]), units[i], group=groups[i])
        for i, name in enumerate(names)
        # A separator at the end of each line makes a column without name and content.
        if name.strip() or table.iloc[:, i].notna().any()
    )
    titles = [" ".join(" ".join(row).split()) for _, row in rows[: rows_by_use.names]]
    ignored = (f"{len(titles)} lines above the names",) if titles else ()
    about = DECIMAL_COMMAS if commas else {}
    return Content(columns, location, about=about, ignored=ignored)


def _with_points(cells: pd.Series, path: Path, names: list[str], location: Callable[[int], str]) -> pd.Series:
    """Return texts with points in place of decimal commas; raises `DataError` if a number has a point already."""
    if (row := first_with_point(cells)) is not None:
        mixed = with_comma_and_point(names[int(str(cells.name))], cells.iloc[row])
        raise DataError(f"{path}: {location(row)}: {mixed}")
    return cells.map(with_point, na_action="ignore")


def _exact(cells: pd.Series) -> pd.Series:
    """Return the cells as floats, exactly as Python reads them; as texts if one is no number."""
    try:
        return pd.Series(cells.to_numpy(dtype=object, na_value=np.nan).astype(np.float64))
    except ValueError:
        return cells


def _sample(file: TextIO, path: Path) -> tuple[list[tuple[int, str]], list[tuple[int, str]]]:
    """Return number and text of the first comments, without their marks, and of the lines below that are not blank."""
    comments: list[tuple[int, str]] = []
    sample: list[tuple[int, str]] = []
    lines = iter(partial(file.readline, LONGEST_LINE + 1), "")
    for number, line in enumerate(islice(lines, MOST_ABOVE), start=1):
        if len(line) > LONGEST_LINE:
            raise DataError(f"{path}: line {number}: more than {LONGEST_LINE} characters")
        text = line.strip("\r\n")
        if text.startswith("#") and not sample:
            comments = [*comments, (number, text.lstrip("# \t"))][-SAMPLED:]
        elif text.strip():
            sample.append((number, text))
        if len(sample) >= SAMPLED:
            break
    return comments, sample


def _cells(sample: Iterable[tuple[int, str]], path: Path, separator: str) -> list[tuple[int, list[str]]]:
    """Return the line number and the cells of each line that is not blank."""
    return [(line, row) for line, text in sample for _, row in _rows([text], path, line - 1, separator)]


def _plausible(lines: list[str], separator: str) -> tuple[int, int, int]:
    """Return how many lines a separator divides into numbers, how many have it most commonly often, and how often."""
    rows = ([with_point(cell.strip(' "')) for cell in line.split(separator)] for line in lines)
    counts = [line.count(separator) for line in lines]
    most = max((count for count in set(counts) if count), key=lambda count: (counts.count(count), count), default=0)
    return sum(map(is_numeric_row, rows)), counts.count(most) if most else 0, most


def _rows(lines: Iterable[str], path: Path, before: int, separator: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the line number and the cells of each row that is not blank; `before` is the number of lines above."""
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    try:
        for cells in reader:
            if cells not in ([], [""]):
                yield before + reader.line_num, cells
    except csv.Error as error:
        raise DataError(f"{path}: line {before + reader.line_num}: {error}") from None


def _body(path: Path, skipped: int, width: int, separator: str) -> pd.DataFrame:
    if width > MAX_COLUMNS:
        raise DataError(f"{path}: {width} columns: at most {MAX_COLUMNS} are read")
    _check_size(path, width)
    # pandas reserves memory for the cells of the first row in every column.
    _check_cells(path, skipped, width, separator, most=1)
    with warnings.catch_warnings(), _opened(path, skipped) as file:
        # pandas only warns when it drops the surplus cells of a row.
        warnings.simplefilter("error", pd.errors.ParserWarning)
        try:
            return pd.read_csv(
                file, header=None, names=list(range(width)), index_col=False, sep=separator, skipinitialspace=True,
                dtype=str,
            )  # fmt: skip
        except pd.errors.EmptyDataError:
            return pd.DataFrame(columns=list(range(width)))
        except (pd.errors.ParserError, pd.errors.ParserWarning) as error:
            _check_cells(path, skipped, width, separator)
            raise DataError(f"{path}: not a table: {error}") from None


@contextmanager
def _opened(path: Path, skipped: int = 0) -> Iterator[TextIO]:
    with path.open(encoding=encoding_of(path), newline="") as file:
        for _ in range(skipped):
            file.readline()
        yield file


def _check_size(path: Path, width: int) -> None:
    """Raise if the lines cannot have the header's cells: pandas would fill so many that they need all memory."""
    with path.open("rb") as file:
        lines = sum(max(part.count(b"\n"), part.count(b"\r")) for part in iter(partial(file.read, 1 << 20), b""))
        size = file.tell()
    if lines * width > size + MAX_ABSENT:
        raise DataError(f"{path}: its {lines} lines have far fewer cells than the header's {width}")


def _check_cells(path: Path, skipped: int, width: int, separator: str, most: int | None = None) -> None:
    """Raise if one of the rows, or of the first ones, has more cells than the header."""
    with _opened(path, skipped) as file:
        for line, cells in islice(_rows(file, path, skipped, separator), most):
            if len(cells) > width:
                # A number with a comma gives two cells.
                comma = separator == "," and len(cells) <= 2 * width and all(map(_DIGITS.fullmatch, cells))
                hint = ": decimal commas? write decimal points" if comma else ""
                raise DataError(f"{path}: line {line}: more cells than the header's {width}{hint}")


def _location(path: Path, skipped: int, row: int) -> str:
    """Return the line of a row of the body. pandas skips blank lines."""
    with _opened(path) as file:
        rows = -1
        for number, line in enumerate(file, start=1):
            rows += number > skipped and bool(line.strip())
            if rows == row:
                return f"line {number}"
    return f"line {skipped + 1 + row}"
