"""CSV tables: column names of the contract, SI units unless the header declares a unit."""

from __future__ import annotations

import csv
import warnings
from collections.abc import Hashable, Mapping
from pathlib import Path

import pandas as pd

from tirefmu.symbolic.errors import DataError

from ..channels import CHANNELS
from ..recording import Recording
from .columns import channels_in_si, parse_header

_SEPARATORS = ",;\t"


def read_csv_table(path: Path, signs: str) -> Recording:
    """Read a CSV table.

    Lines before the header that begin with ``#`` are skipped. Columns are separated by commas, semicolons or tabs.
    Numbers are read exactly.

    Parameters
    ----------
    path : pathlib.Path
    signs : str
        The convention of the table.

    Returns
    -------
    Recording

    Raises
    ------
    DataError
        With file, line and column of the first error.
    """
    source = str(path)
    skipped, header, separator = _header(path)
    columns = parse_header(header, source)
    # Channels are read as text and converted later, exactly and with the location of a wrong cell.
    as_text: dict[Hashable, str] = {number: "str" for number, column in enumerate(columns) if column.name in CHANNELS}
    table = _body(path, skipped, len(header), separator, as_text)
    # A separator at the end of each line makes a column without name and content.
    empty = [
        number for number, name in enumerate(header)
        if not name.strip() and table.iloc[:, number].isna().all()
    ]  # fmt: skip
    table = table.drop(columns=empty)
    columns = [column for number, column in enumerate(columns) if number not in empty]
    table, about = channels_in_si(table, columns, source, lambda row: f"line {_line(path, skipped, row)}")
    return Recording(table, signs, path.name, about)


def _header(path: Path) -> tuple[int, list[str], str]:
    """Return the number of lines up to the header's end, the header's cells, and the separator."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        for number, line in enumerate(file, start=1):
            text = line.strip("\r\n")
            if text.strip() and not text.startswith("#"):
                separator = max(_SEPARATORS, key=text.count)
                return number, next(csv.reader([text], delimiter=separator)), separator
    raise DataError(f"{path}: the file is empty")


def _body(path: Path, skipped: int, width: int, separator: str, as_text: Mapping[Hashable, str]) -> pd.DataFrame:
    with warnings.catch_warnings():
        # pandas only warns when it drops the surplus cells of a row.
        warnings.simplefilter("error", pd.errors.ParserWarning)
        # Columns with cells of different types are reported below, with line and column.
        warnings.simplefilter("ignore", pd.errors.DtypeWarning)
        try:
            return pd.read_csv(
                path, header=None, names=list(range(width)), index_col=False, skiprows=skipped, sep=separator,
                encoding="utf-8-sig", dtype=as_text, skipinitialspace=True,
            )  # fmt: skip
        except pd.errors.EmptyDataError:
            return pd.DataFrame(columns=list(range(width)))
        except (pd.errors.ParserError, pd.errors.ParserWarning):
            line, cells = _first_long_line(path, skipped, width, separator)
            # Every number with a comma is two cells.
            hint = ": decimal commas? write decimal points" if separator == "," and width < cells <= 2 * width else ""
            raise DataError(f"{path}: line {line}: more cells than the header's {width}{hint}") from None


def _first_long_line(path: Path, skipped: int, width: int, separator: str) -> tuple[int, int]:
    """Return the number of the first line with too many cells, and how many it has."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        reader = csv.reader(file, delimiter=separator)
        for cells in reader:
            if reader.line_num > skipped and len(cells) > width:
                return reader.line_num, len(cells)
    return skipped + 1, width


def _line(path: Path, skipped: int, row: int) -> int:
    """Return the line number of a row of the body. pandas skips blank lines."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = -1
        for number, line in enumerate(file, start=1):
            rows += number > skipped and bool(line.strip())
            if rows == row:
                return number
    return skipped + 1 + row
