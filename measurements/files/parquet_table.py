"""Parquet tables, with columns as in CSV tables."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ...boundary.errors import DataError
from ..interpretation import Interpretation
from ..recording import Recording
from . import native_reader
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
    try:
        return native_reader.load("parquet", path)  # type: ignore[no-any-return]
    except native_reader.MissingPackage:
        raise DataError(f"{path}: {EXTRA}") from None
