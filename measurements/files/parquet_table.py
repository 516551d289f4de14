"""Parquet tables, with columns as in CSV tables: as a whole, or in parts of a few rows."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from ...boundary.errors import DataError
from ..interpretation import Interpretation
from ..recording import Recording
from . import native_reader
from .columns import Column, converted_channels, parse_header
from .table_recording import table_recording

EXTRA = "Parquet needs pyarrow, which the extra 'parquet' installs: pip install 'tirefmu[parquet]'"


def read_parquet_table(path: Path, signs: str, interpretation: Interpretation) -> Recording:
    """Read a Parquet table.

    `signs`: the convention of the table. Raises `DataError` if pyarrow is not installed, the file is not a Parquet
    file, or a channel cannot be used. The message counts rows from 1.
    """
    return table_recording(path, parquet_cells(path), signs, interpretation, lambda row: f"row {row + 1}")


def parquet_cells(path: Path) -> pd.DataFrame:
    """Return the table of a Parquet file; raises `DataError` if it is none or pyarrow is not installed."""
    return _loaded("parquet", path)  # type: ignore[no-any-return]


def parquet_header(path: Path) -> tuple[list[Column], int]:
    """Return the columns of a Parquet file and its number of rows.

    Raises `DataError` if pyarrow is not installed, the file is not a Parquet file, or its columns cannot be used.
    """
    names, rows = _loaded("parquet header", path)
    return parse_header(names, str(path)), rows


def parquet_parts(path: Path, columns: Sequence[Column], most: int) -> Iterator[tuple[int, pd.DataFrame]]:
    """Yield the number of the first row of each part and at most `most` of its rows, channels in SI.

    Raises `DataError` if a channel cannot be used. The message counts rows from 1.
    """
    start = 0
    while (table := _loaded("parquet part", path, start, most)) is not None:
        yield start, converted_channels(table, columns, str(path), _numbered_from(start))
        start += len(table)


def _numbered_from(start: int) -> Callable[[int], str]:
    return lambda row: f"row {start + row + 1}"


def _loaded(wanted: str, path: Path, *arguments: int) -> Any:
    try:
        return native_reader.load(wanted, path, *arguments)
    except native_reader.MissingPackage:
        raise DataError(f"{path}: {EXTRA}") from None
