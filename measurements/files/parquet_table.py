"""Parquet tables, with columns as in CSV tables."""

from __future__ import annotations

from pathlib import Path

from tirefmu.symbolic.errors import DataError

from ..recording import Recording
from . import native_reader
from .columns import channels_in_si, parse_header

EXTRA = "Parquet needs pyarrow, which the extra 'parquet' installs: pip install 'tirefmu[parquet]'"


def read_parquet_table(path: Path, signs: str) -> Recording:
    """Read a Parquet table.

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
        If pyarrow is not installed, the file is not a Parquet file, or a channel cannot be used. The message counts
        rows from 1.
    """
    source = str(path)
    try:
        table = native_reader.load("parquet", path)
    except native_reader.MissingPackage:
        raise DataError(f"{source}: {EXTRA}") from None
    columns = parse_header([str(name) for name in table.columns], source)
    table, about = channels_in_si(table, columns, source, lambda row: f"row {row + 1}")
    return Recording(table, signs, path.name, about)
