"""`tirefmu.evaluate`: a tire evaluated over a table, in memory or from file to file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd

from ..tires import Tire, TireLike, tire_from
from .channels import OUTPUTS
from .column_names import check_names
from .files.writing import write_tables
from .large_table import PART, LargeTable
from .recording import Recording

#: Rows that are evaluated at a time if they depend on earlier ones: every named quantity of them needs 200 MB.
ROWS_AT_A_TIME = 250_000


def evaluate(tire: TireLike, table: Any, **options: Any) -> pd.DataFrame:
    """Evaluate forces, moments and every named quantity of a tire for each row of a table.

    Parameters
    ----------
    tire : Tire, path of a .tir file, or name of a published tire
        In any signs.
    table : pandas.DataFrame, path or Recording
        Input columns in SI units.
    **options
        Those of `Tire.evaluate`: signs, convention, slip_angle, limits, mirror, steady, hold, code.

    Returns
    -------
    pandas.DataFrame
        The inputs, forces and moments and named quantities, in the signs of the table.

    Raises
    ------
    UnknownName, DataError, WrongType
        See `tire_from` and `Tire.evaluate`.

    Examples
    --------
    >>> table = pd.DataFrame({"alpha": [0.0, -0.1], "Fz": 1000.0})
    >>> evaluate("trento_hoosier", table)["Fy"].round().tolist()
    [-89.0, 1948.0]
    """
    if isinstance(table, pd.DataFrame):
        check_names(map(str, table.columns), "table")
    return tire_from(tire).evaluate(table, **options)


def predicted_outputs(tire: Tire, recording: Recording) -> pd.DataFrame:
    """Return the outputs of a tire for each row of a recording.

    Returns: the outputs that the tire has, in the signs of the recording. Transient slips start anew every
    `ROWS_AT_A_TIME` rows.
    """
    pieces = []
    most = ROWS_AT_A_TIME if tire.lags or tire.states or "distance" in tire.inputs else PART
    for start in range(0, len(recording), most):
        rows = recording.table.iloc[start : start + most].reset_index(drop=True)
        outputs = tire.evaluate(rows, signs=recording.signs)
        pieces.append(outputs[[name for name in OUTPUTS if name in tire.outputs]])
    return pd.concat(pieces, ignore_index=True)


def evaluate_to_file(tire: Tire, table: LargeTable, output: Path, code: str = "auto", **options: Any) -> list[str]:
    """Evaluate a tire over a large table part by part, and write the result.

    `table`: whose rows are independent (`LargeTable.rows_are_independent`). `output`: CSV or Parquet file to write.
    `code`: as for `Tire.evaluate`; "auto" is the fastest for all rows, for each part. `**options`: those of
    `Tire.evaluate`. Returns: the columns of the result. Raises `DataError` if the table cannot be used or the file
    cannot be written.
    """
    columns: list[str] = []

    def results() -> Iterator[pd.DataFrame]:
        for part in table.parts():
            result = tire.evaluate(part, signs=table.signs, code=code, **options)
            columns[:] = result.columns
            yield result

    write_tables(results(), output)
    return columns
