"""Writing of tables, without partial files after an error."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import pandas as pd

from ...boundary.bounded_file import replacing
from ...boundary.errors import DataError, writing
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
    target = Path(path)
    kind = target.suffix.lower()
    if kind not in (".csv", ".parquet"):
        raise DataError(f"{target}: unknown kind of table {target.suffix!r}: known are .csv, .parquet")
    try:
        with writing(target, DataError), replacing(target) as part:
            if kind == ".csv":
                table.to_csv(part, index=False, lineterminator="\n")
            else:
                table.to_parquet(part, index=False)
    except ImportError:
        raise DataError(f"{target}: {EXTRA}") from None
