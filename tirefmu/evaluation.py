"""`tirefmu.evaluate`: a tire evaluated over a table."""

from __future__ import annotations

from typing import Any

import pandas as pd

from tirefmu.measurements.column_names import check_names
from tirefmu.tires import TireLike, tire_from


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
