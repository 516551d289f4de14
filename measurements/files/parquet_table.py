"""Parquet tables, with columns as in CSV tables: as a whole, or in parts of a few rows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from ...boundary.errors import DataError
from . import native_reader
from .content import Content, frame_columns, row_number

EXTRA = "Parquet needs pyarrow, which the extra 'parquet' installs: pip install 'tirefmu[parquet]'"


def read_parquet(path: Path) -> Content:
    """Return the content of a Parquet file; a named index is a column of it.

    Units are those of the metadata of fields (``unit`` or ``units``). Raises `DataError` if pyarrow is not installed,
    or the file is not a Parquet file. Messages count rows from 1.
    """
    table, units = _loaded("parquet", path)
    return Content(tuple(frame_columns(table, units)))


def parquet_header(path: Path) -> tuple[Content, int]:
    """Return the content of a Parquet file without its rows, and their number; raises as `read_parquet`."""
    (table, units), rows = _loaded("parquet header", path)
    return Content(tuple(frame_columns(table, units))), rows


def parquet_parts(path: Path, most: int) -> Iterator[tuple[int, Content]]:
    """Yield the number of the first row of each part, and the content of at most `most` rows."""
    start = 0
    while (part := _loaded("parquet part", path, start, most)) is not None:
        table, units = part
        yield start, Content(tuple(frame_columns(table, units)), _numbered_from(start))
        start += len(table)


def _numbered_from(start: int) -> Callable[[int], str]:
    return lambda row: row_number(start + row)


def _loaded(wanted: str, path: Path, *arguments: int) -> Any:
    try:
        return native_reader.load(wanted, path, *arguments)
    except native_reader.MissingPackage:
        raise DataError(f"{path}: {EXTRA}") from None
