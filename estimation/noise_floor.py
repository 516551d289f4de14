"""Noise floor of a channel: scatter of rows at equal operating conditions, a lower limit of the error of any model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.measurements import levels

FloatArray = npt.NDArray[np.float64]

#: Inputs that define an operating condition.
CONDITIONS = ("kappa", "alpha", "gamma", "Fz", "p", "V")
#: Number of parts of the range of a swept input.
PARTS = 20
#: Largest number of levels of a held input; with more levels it was swept in steps.
MOST_LEVELS = 12
#: Fewest rows in a cell per coefficient of its plane.
ROWS_PER_UNKNOWN = 3


def held_levels(column: pd.Series) -> list[float]:
    """Return the levels of a held channel; empty for a swept one.

    Parameters
    ----------
    column : pandas.Series
        Its name gives the tolerance.

    Returns
    -------
    list of float
    """
    found = levels(column)
    return found if len(found) <= MOST_LEVELS else []


def noise_floor(table: pd.DataFrame, channels: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return the scatter of each channel about local planes, and the share of rows that are used.

    A cell contains the rows with equal levels of held inputs and with swept inputs within a twentieth of their range:
    rows of up- and down-sweeps and of repeats. A plane over the inputs describes the differences of inputs within a
    cell. The remainder is noise, hysteresis, temperature and ripple, which no function of the inputs can explain.

    Parameters
    ----------
    table : pandas.DataFrame
        Of one recording.
    channels : sequence of str

    Returns
    -------
    dict of str to (float, float)
        Root mean square in the channel's unit, NaN if no cell has enough rows, and a share between 0 and 1.
    """
    inputs = [name for name in CONDITIONS if name in table and np.ptp(table[name].to_numpy()) > 0]
    cells = _numbered([index for index, _ in _indices(table)], len(table))
    order = np.argsort(cells, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(cells[order])) + 1)
    at = table[inputs].to_numpy(dtype=float)
    at = (at - at.mean(axis=0)) / at.std(axis=0)
    return {name: _scatter(at, table[name].to_numpy(dtype=float), groups) for name in channels}


def _scatter(at: FloatArray, measured: FloatArray, groups: Sequence[npt.NDArray[np.int64]]) -> tuple[float, float]:
    squares, freedom, used = 0.0, 0, 0
    for group in groups:
        rows = group[np.isfinite(measured[group])]
        if len(rows) < ROWS_PER_UNKNOWN * (at.shape[1] + 1):
            continue
        plane = np.column_stack([np.ones(len(rows)), at[rows]])
        solution, _, rank, _ = np.linalg.lstsq(plane, measured[rows], rcond=1e-6)
        squares += float(np.sum((measured[rows] - plane @ solution) ** 2))
        freedom += len(rows) - int(rank)
        used += len(rows)
    measured_rows = int(np.isfinite(measured).sum())
    return ((squares / freedom) ** 0.5 if freedom else float("nan")), used / measured_rows if measured_rows else 0.0


def _indices(table: pd.DataFrame) -> list[tuple[npt.NDArray[np.int64], bool]]:
    """Return for each varying input the index of the level or part of each row, and whether the input was held."""
    indices = []
    for name in CONDITIONS:
        if name not in table or not np.ptp(table[name].to_numpy()) > 0:
            continue
        values = table[name].to_numpy(dtype=float)
        found = np.array(held_levels(table[name]))
        if found.size:
            indices.append((np.abs(values[:, None] - found).argmin(axis=1), True))
        else:
            part = ((values - values.min()) / np.ptp(values) * PARTS).astype(np.int64)
            indices.append((np.minimum(part, PARTS - 1), False))
    return indices


def _numbered(indices: Sequence[npt.NDArray[np.int64]], n: int) -> npt.NDArray[np.int64]:
    """Return a number for each combination of indices."""
    if not indices:
        return np.zeros(n, dtype=np.int64)
    return np.unique(np.stack(indices), axis=1, return_inverse=True)[1].ravel().astype(np.int64)
