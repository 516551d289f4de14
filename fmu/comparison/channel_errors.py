"""Errors of one output of an FMU against measured values."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan

import numpy as np
import pandas as pd

from ...numerics.ties import graded
from .compared import CheckedChannel, WorstPoint


def checked_channel(
    name: str, unit: str, table: pd.DataFrame, simulated: pd.DataFrame, inputs: Sequence[str]
) -> CheckedChannel:
    """Return the goodness of fit of an output over the rows of a table in which it is measured: at least one."""
    data, model = table[name].to_numpy(dtype=np.float64), simulated[name].to_numpy()
    rows = np.flatnonzero(~np.isnan(data))
    y, error = data[rows], model[rows] - data[rows]
    worst = int(rows[np.argmax(graded(np.abs(error)))])  # argmax treats a NaN of the FMU as the largest
    point = WorstPoint(
        worst,
        float(table["t"].iloc[worst]) if "t" in table else None,
        {column: float(table[column].iloc[worst]) + 0.0 for column in inputs},
        float(data[worst]),
        float(model[worst]),
    )
    squared, largest = float(error @ error), float(np.abs(y).max())
    about_mean, about_zero = float(((y - y.mean()) ** 2).sum()), float((y**2).sum())
    rmse = float(np.sqrt(squared / len(rows)))
    return CheckedChannel(
        name,
        unit,
        len(rows),
        rmse,
        rmse / largest if largest else nan,
        1.0 - squared / about_mean if about_mean else nan,
        1.0 - squared / about_zero if about_zero else nan,
        point,
    )
