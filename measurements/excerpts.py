"""The tables of a fit: recordings in memory, and excerpts of those that are too large for it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from tirefmu.symbolic.errors import WrongType

from .large_table import LargeTable
from .recording import Recording
from .table_argument import ACCEPTED, TableLike, recording_from

#: Number of rows from which on a Parquet table stays in its file. In memory a fit needs 300 to 400 bytes a row.
STREAM_FROM = 2_000_000
#: How all rows of a large table are loaded, for messages.
IN_MEMORY = "--stream-from, in Python stream_from, is the number of rows from which on a table stays in its file"


def excerpts_from(
    tables: TableLike | LargeTable | Iterable[TableLike | LargeTable],
    *,
    signs: str | None = None,
    stream_from: int = STREAM_FROM,
) -> tuple[list[Recording], dict[int, LargeTable]]:
    """Return the recordings of tables, excerpts of large Parquet tables among them.

    Parameters
    ----------
    tables : table, or iterable of them
        Each as for `recordings_from`, or a `LargeTable`.
    signs : str, optional
        The convention of all tables.
    stream_from : int
        Number of rows from which on a Parquet table is large.

    Returns
    -------
    recordings : list of Recording
    large : dict of int to LargeTable
        By the number of the recording that is an excerpt of it.

    Raises
    ------
    DataError, UnknownName, WrongType
        As for `recordings_from`.

    Examples
    --------
    >>> rows = pd.DataFrame({"alpha": [0.1], "Fz": [900.0], "Fy": [-800.0]})
    >>> recordings, large = excerpts_from([rows, rows])
    >>> len(recordings), large
    (2, {})
    """
    if isinstance(tables, (Recording, pd.DataFrame, LargeTable, str, os.PathLike)):
        listed: list[TableLike | LargeTable] = [tables]
    elif not hasattr(tables, "__iter__") or isinstance(tables, (bytes, Mapping, np.ndarray)):
        raise WrongType("tables", tables, f"{ACCEPTED}, or a sequence of them")
    else:
        listed = list(tables)
    recordings, large = [], dict[int, LargeTable]()
    for number, table in enumerate(listed):
        found = _large(table, signs, stream_from)
        if isinstance(found, LargeTable):
            large[number] = found
            recordings.append(found.excerpt)
        else:
            parameter = "tables" if table is tables else f"tables[{number}]"
            recordings.append(recording_from(found, signs=signs, parameter=parameter))
    return recordings, large


def _large(table: TableLike | LargeTable, signs: str | None, stream_from: int) -> TableLike | LargeTable:
    """Return the large table of the path of one; any other table as it is."""
    if not isinstance(table, (str, os.PathLike)):
        return table
    return LargeTable.of(Path(table), signs, least=stream_from) or table
