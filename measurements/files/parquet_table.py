"""Parquet tables, with columns as in CSV tables."""

from __future__ import annotations

from pathlib import Path

from ...boundary.errors import DataError
from . import native_reader
from .columns.content import Content
from .columns.frames import frame_content

EXTRA = "Parquet needs pyarrow, which the extra 'parquet' installs: pip install 'tirefmu[parquet]'"


def read_parquet(path: Path) -> Content:
    """Return the content of a Parquet file; a named index is a column of it.

    Units are those of the metadata of fields (``unit`` or ``units``). Raises `DataError` if pyarrow is not installed,
    or the file is not a Parquet file. Messages count rows from 1.
    """
    try:
        table, units = native_reader.load("parquet", path)
    except native_reader.MissingPackage:
        raise DataError(f"{path}: {EXTRA}") from None
    return frame_content(table, str(path), units)
