"""CSV tables: column names of the contract, SI units unless the header declares a unit."""

from __future__ import annotations

import csv
import warnings
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TextIO

import pandas as pd

from ...boundary.errors import DataError
from ..channels import CHANNELS
from ..interpretation import Interpretation
from ..recording import Recording
from .columns import parse_header
from .table_recording import is_bench_table, table_recording

_SEPARATORS = ",;\t"
#: Upper limits: characters of a line up to the header's end; cells that the rows of a table lack.
LONGEST_LINE, MAX_ABSENT = 1_000_000, 10_000_000


def read_csv_table(path: Path, signs: str, interpretation: Interpretation) -> Recording:
    """Read a CSV table.

    Lines before the header that begin with ``#`` are skipped. Columns are separated by commas, semicolons or tabs.
    Numbers are read exactly. Raises `DataError` with file, line and column of the first error.
    """
    source = str(path)
    with _opened(path) as file:
        skipped, header, separator = _header(file, path)
    # Channels are read as text and converted later, exactly and with the location of a wrong cell.
    channels = (
        [] if is_bench_table(header) else [column.name for column in parse_header(header, source, interpretation)]
    )
    as_text: dict[Hashable, str] = {number: "str" for number, name in enumerate(channels) if name in CHANNELS}
    table = _body(path, skipped, len(header), separator, as_text)
    # A separator at the end of each line makes a column without name and content.
    kept = [number for number, name in enumerate(header) if name.strip() or table.iloc[:, number].notna().any()]
    table = table.iloc[:, kept].set_axis([header[number] for number in kept], axis=1)
    return table_recording(path, table, signs, interpretation, lambda row: f"line {_line(path, skipped, row)}")


def csv_cells(path: Path) -> tuple[list[str], pd.DataFrame, Callable[[int], str]]:
    """Return the headers of a CSV file, its columns, and a function from a row's number to "line 12" for messages.

    Raises `DataError` if it is not a table.
    """
    with _opened(path) as file:
        skipped, header, separator = _header(file, path)
    return header, _body(path, skipped, len(header), separator, {}), lambda row: f"line {_line(path, skipped, row)}"


def _header(file: TextIO, path: Path) -> tuple[int, list[str], str]:
    """Read up to the header's end; return the number of lines, the header's cells, and the separator."""
    for number, line in enumerate(iter(partial(file.readline, LONGEST_LINE + 1), ""), start=1):
        if len(line) > LONGEST_LINE:
            raise DataError(f"{path}: line {number}: more than {LONGEST_LINE} characters")
        text = line.strip("\r\n")
        if text.strip() and not text.startswith("#"):
            separator = max(_SEPARATORS, key=text.count)
            return number, next(_rows([text], path, number - 1, separator))[1], separator
    raise DataError(f"{path}: the file is empty")


def _rows(lines: Iterable[str], path: Path, before: int, separator: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the line number and the cells of each row that is not blank; `before` is the number of lines above."""
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    try:
        for cells in reader:
            if cells not in ([], [""]):
                yield before + reader.line_num, cells
    except csv.Error as error:
        raise DataError(f"{path}: line {before + reader.line_num}: {error}") from None


def _body(path: Path, skipped: int, width: int, separator: str, as_text: Mapping[Hashable, str]) -> pd.DataFrame:
    _check_size(path, width)
    # pandas reserves memory for the cells of the first row in every column.
    _check_cells(path, skipped, width, separator, most=1)
    with warnings.catch_warnings(), _opened(path, skipped) as file:
        # pandas only warns when it drops the surplus cells of a row.
        warnings.simplefilter("error", pd.errors.ParserWarning)
        # Columns with cells of different types are reported below, with line and column.
        warnings.simplefilter("ignore", pd.errors.DtypeWarning)
        try:
            return pd.read_csv(
                file, header=None, names=list(range(width)), index_col=False, sep=separator, dtype=as_text,
                skipinitialspace=True,
            )  # fmt: skip
        except pd.errors.EmptyDataError:
            return pd.DataFrame(columns=list(range(width)))
        except (pd.errors.ParserError, pd.errors.ParserWarning) as error:
            _check_cells(path, skipped, width, separator)
            raise DataError(f"{path}: not a table: {error}") from None


@contextmanager
def _opened(path: Path, skipped: int = 0) -> Iterator[TextIO]:
    with path.open(encoding="utf-8-sig", newline="") as file:
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
                comma = separator == "," and len(cells) <= 2 * width
                hint = ": decimal commas? write decimal points" if comma else ""
                raise DataError(f"{path}: line {line}: more cells than the header's {width}{hint}")


def _line(path: Path, skipped: int, row: int) -> int:
    """Return the line number of a row of the body. pandas skips blank lines."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = -1
        for number, line in enumerate(file, start=1):
            rows += number > skipped and bool(line.strip())
            if rows == row:
                return number
    return skipped + 1 + row
