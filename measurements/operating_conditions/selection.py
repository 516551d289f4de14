"""Selection of rows at an operating condition: channels within a tolerance of a value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tirefmu.symbolic.errors import DataError, nearest


@dataclass(frozen=True)
class Near:
    """A value and its tolerance.

    Parameters
    ----------
    value, tolerance : float
        In SI units. The limits are included.
    """

    value: float
    tolerance: float


@dataclass(frozen=True)
class Condition:
    """A channel within a tolerance of a value.

    Parameters
    ----------
    channel : str
    value, tolerance : float
        In SI units. The limits are included.

    Examples
    --------
    >>> table = pd.DataFrame({"Fz": [220.0, 700.0]})
    >>> Condition("Fz", 220.0, 100.0).matches(table).tolist()
    [True, False]
    """

    channel: str
    value: float
    tolerance: float

    def matches(self, table: pd.DataFrame) -> NDArray[np.bool_]:
        """Return for each row whether it satisfies the condition.

        Parameters
        ----------
        table : pandas.DataFrame

        Returns
        -------
        ndarray of bool, shape (n,)
            False where the channel is NaN.

        Raises
        ------
        DataError
            If the table has no such column.
        """
        if self.channel not in table:
            hint = nearest(self.channel, [str(name) for name in table.columns])
            raise DataError(f"no column {self.channel!r} to select by{hint}")
        values = table[self.channel].to_numpy(dtype=np.float64)
        return np.asarray(np.abs(values - self.value) <= self.tolerance)


def near(value: float, tolerance: float) -> Near:
    """Return the range around a value, for `select`.

    Parameters
    ----------
    value, tolerance : float
        In SI units.

    Returns
    -------
    Near

    Raises
    ------
    DataError
        If the tolerance is negative or NaN.

    Examples
    --------
    >>> near(220.0, 100.0)
    Near(value=220.0, tolerance=100.0)
    """
    if not tolerance >= 0.0:
        raise DataError(f"a tolerance of {tolerance} selects nothing: it has to be 0 or more")
    return Near(value, tolerance)


def select(table: pd.DataFrame, *conditions: Condition, **ranges: Near) -> pd.DataFrame:
    """Return the rows that satisfy all conditions (Trento report, section 1.2.2).

    Parameters
    ----------
    table : pandas.DataFrame
    *conditions : Condition
    **ranges : Near
        One per channel, ``Fz=near(220, 100)``.

    Returns
    -------
    pandas.DataFrame
        With the row labels of the given table. Without conditions: all rows.

    Raises
    ------
    DataError
        If the table has no such column.

    Examples
    --------
    >>> table = pd.DataFrame({"Fz": [220.0, 220.0, 700.0], "gamma": [0.0, 0.07, 0.0]})
    >>> select(table, Fz=near(200, 100), gamma=near(0, 0.01)).index.tolist()
    [0]
    """
    chosen = np.ones(len(table), dtype=np.bool_)
    named = [Condition(channel, given.value, given.tolerance) for channel, given in ranges.items()]
    for condition in (*conditions, *named):
        chosen &= condition.matches(table)
    return table[chosen]
