"""Writing of tables, without partial files after an error."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path

import pandas as pd

from ...boundary.errors import DataError, writing
from ...boundary.whole_file import replacing
from .parquet_table import EXTRA


def write_table(table: pd.DataFrame, path: str | PathLike[str]) -> None:
    """Write a table as CSV or Parquet, completely or not at all.

    CSV numbers have enough digits to be read back exactly. The table is written to a temporary file in the same folder,
    which is then renamed.

    Parameters
    ----------
    table : pandas.DataFrame
        Columns with the names of channels, SI.
    path : str or path-like
        With extension ``.csv`` or ``.parquet``. An existing file is replaced.

    Raises
    ------
    DataError
        If the extension is another one, the folder does not exist, or pyarrow is missing for Parquet.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     write_table(pd.DataFrame({"Fy": [0.1 + 0.2]}), Path(folder) / "out.csv")
    ...     print((Path(folder) / "out.csv").read_text().split())
    ['Fy', '0.30000000000000004']
    """
    with _replaced(Path(path)) as part:
        if Path(path).suffix.lower() == ".csv":
            table.to_csv(part, index=False, lineterminator="\n")
        else:
            table.to_parquet(part, index=False)


def write_tables(tables: Iterable[pd.DataFrame], path: str | PathLike[str]) -> None:
    """Write tables with the same columns one after another into one file, as `write_table` writes one.

    Only one of them has to be in memory at a time.
    """
    with _replaced(Path(path)) as part:
        if Path(path).suffix.lower() == ".csv":
            with part.open("w", encoding="utf-8", newline="") as file:
                for number, table in enumerate(tables):
                    table.to_csv(file, index=False, lineterminator="\n", header=number == 0)
        else:
            _write_parquet(tables, part)


def _write_parquet(tables: Iterable[pd.DataFrame], path: Path) -> None:
    import pyarrow as pa
    from pyarrow.parquet import ParquetWriter

    writer = None
    try:
        for table in tables:
            rows = pa.Table.from_pandas(table, preserve_index=False)
            writer = writer or ParquetWriter(path, rows.schema)
            writer.write_table(rows)
    finally:
        if writer is not None:
            writer.close()


@contextmanager
def _replaced(target: Path) -> Iterator[Path]:
    """Give a temporary file that replaces the target if nothing fails."""
    kind = target.suffix.lower()
    if kind not in (".csv", ".parquet"):
        raise DataError(f"{target}: unknown kind of table {target.suffix!r}: known are .csv, .parquet")
    try:
        with writing(target, DataError), replacing(target) as part:
            yield part
    except ImportError:
        raise DataError(f"{target}: {EXTRA}") from None
