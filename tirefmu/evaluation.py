"""`tirefmu.evaluate`: a tire evaluated over a table."""

from __future__ import annotations

from typing import Any

import pandas as pd

from tirefmu.measurements.channels import OUTPUTS
from tirefmu.measurements.column_names import check_names
from tirefmu.measurements.recording import Recording
from tirefmu.tires import Tire, TireLike, tire_from

#: Rows that are evaluated at a time: every named quantity of more would fill the memory.
ROWS_AT_A_TIME = 250_000


def evaluate(tire: TireLike, table: Any, **options: Any) -> pd.DataFrame:
    """Evaluate forces, moments and every named quantity of a tire for each row of a table.

    Parameters
    ----------
    tire : Tire, path of a .tir file, or name of a published tire
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

    Parameters
    ----------
    tire : Tire
    recording : Recording

    Returns
    -------
    pandas.DataFrame
        The outputs that the tire has, in the signs of the recording. Transient slips start anew every `ROWS_AT_A_TIME`
        rows.
    """
    pieces = []
    for start in range(0, len(recording), ROWS_AT_A_TIME):
        rows = recording.table.iloc[start : start + ROWS_AT_A_TIME].reset_index(drop=True)
        outputs = tire.evaluate(rows, signs=recording.signs)
        pieces.append(outputs[[name for name in OUTPUTS if name in tire.outputs]])
    return pd.concat(pieces, ignore_index=True)
