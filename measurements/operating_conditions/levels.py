"""Slicing a recording by conditions with tolerances, and finding the levels that a bench held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from tirefmu.symbolic.errors import DataError, nearest

from ..channels import CHANNELS

#: A held load wanders by this fraction of the largest one (load cell, ripple, axle control).
LOAD_WANDER = 0.04
_SMALLEST_SHARE = 0.01  # of the rows that lie near a level: less is the way between two levels
_CONTRAST = 0.5  # a level stands out of the valley beside it by at least this part of its height
_COVERED = 0.7  # of the rows that lie near some level; a swept channel has no levels


@dataclass(frozen=True)
class Near:
    """A value and how far from it counts.

    Parameters
    ----------
    value, tolerance : float
        In SI; the ends count.
    """

    value: float
    tolerance: float


@dataclass(frozen=True)
class Condition:
    """A channel held near a value.

    Parameters
    ----------
    channel : str
    value, tolerance : float
        In SI; the ends count.

    Examples
    --------
    >>> table = pd.DataFrame({"Fz": [220.0, 700.0]})
    >>> Condition("Fz", 220.0, 100.0).holds(table).tolist()
    [True, False]
    """

    channel: str
    value: float
    tolerance: float

    def holds(self, table: pd.DataFrame) -> NDArray[np.bool_]:
        """Return for each row whether the condition holds.

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
    """Return the band around a value, for `select`.

    Parameters
    ----------
    value, tolerance : float
        In SI.

    Returns
    -------
    Near

    Raises
    ------
    DataError
        If the tolerance is negative or no number.

    Examples
    --------
    >>> near(220.0, 100.0)
    Near(value=220.0, tolerance=100.0)
    """
    if not tolerance >= 0.0:
        raise DataError(f"a tolerance of {tolerance} selects nothing: it has to be 0 or more")
    return Near(value, tolerance)


def select(table: pd.DataFrame, *conditions: Condition, **bands: Near) -> pd.DataFrame:
    """Return the rows where all conditions hold: the intersection of the Trento report's section 1.2.2.

    Parameters
    ----------
    table : pandas.DataFrame
    *conditions : Condition
    **bands : Near
        One per channel, ``Fz=near(220, 100)``.

    Returns
    -------
    pandas.DataFrame
        With the row labels of the given table; all of it without conditions.

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
    named = [Condition(channel, band.value, band.tolerance) for channel, band in bands.items()]
    for condition in (*conditions, *named):
        chosen &= condition.holds(table)
    return table[chosen]


def level_tolerance(values: ArrayLike, channel: str | None = None) -> float:
    """Return how far a held channel wanders from its level.

    Parameters
    ----------
    values : array_like, shape (n,)
    channel : str, optional
        A contract name; its card's tolerance is used. Loads, and what has no card, wander in proportion to
        the largest value.

    Returns
    -------
    float
        In SI.

    Examples
    --------
    >>> level_tolerance([0.0, 80e3], "p"), level_tolerance([200.0, 1000.0], "Fz")
    (3000.0, 40.0)
    """
    card = CHANNELS.get(channel or "")
    if card is not None and card.tolerance is not None:
        return card.tolerance
    magnitudes = np.abs(np.asarray(values, dtype=np.float64))
    return LOAD_WANDER * float(np.nanmax(magnitudes, initial=0.0))


def levels(values: ArrayLike, *, tolerance: float | None = None) -> list[float]:
    """Return the levels at which a channel was held.

    The rows' density, smoothed to the width of the tolerance, has one peak per level; peaks that hardly
    stand out, or hold less than 1 % of the rows, are not levels. Levels need not be equally frequent.
    Two of them have to be about two tolerances apart to be told from one another.

    Parameters
    ----------
    values : array_like, shape (n,)
        A column of a table (its name gives the tolerance) or plain numbers. NaN is left out.
    tolerance : float, optional
        How far a held channel wanders, in SI; default `level_tolerance`.

    Returns
    -------
    list of float
        Ascending, each the median of the rows near it. Empty where the channel was swept, not held.

    Raises
    ------
    DataError
        If the tolerance is not positive.

    Examples
    --------
    >>> levels([218.0, 220.0, 221.0, 220.0, 699.0, 702.0, 701.0], tolerance=50.0)
    [220.0, 701.0]
    >>> levels(np.linspace(-0.2, 0.2, 1000), tolerance=0.01)
    []
    """
    numbers = np.asarray(values, dtype=np.float64)
    numbers = numbers[np.isfinite(numbers)]
    if not len(numbers):
        return []
    if tolerance is None:
        name = values.name if isinstance(values, pd.Series) else None
        tolerance = level_tolerance(numbers, None if name is None else str(name)) or 1.0
    if not tolerance > 0.0:
        raise DataError(f"levels need a positive tolerance, not {tolerance}")
    peaks = _density_peaks(numbers, tolerance)
    near_a_peak = np.abs(numbers[:, None] - peaks) <= tolerance
    if near_a_peak.any(axis=1).mean() < _COVERED:
        return []
    found = near_a_peak.mean(axis=0) >= _SMALLEST_SHARE
    return [float(np.median(numbers[rows])) for rows in near_a_peak.T[found]]


def _density_peaks(numbers: NDArray[np.float64], tolerance: float) -> NDArray[np.float64]:
    """Where the smoothed density of the numbers has peaks that stand out."""
    bin_width = tolerance / 8.0
    # Room on both sides, so that a level at the edge is a peak like the others.
    lowest = numbers.min() - 2.0 * tolerance
    bins = int(np.ceil((numbers.max() - numbers.min() + 4.0 * tolerance) / bin_width)) + 1
    # Each number is shared by the two nearest bins: whole numbers in bins would beat with an even sweep's spacing.
    place = (numbers - lowest) / bin_width
    left = np.floor(place).astype(np.intp)
    right_share = place - left
    counts = np.bincount(left, 1.0 - right_share, bins + 1) + np.bincount(left + 1, right_share, bins + 1)
    density = gaussian_filter1d(counts, sigma=4.0, mode="constant")
    peaks, about = find_peaks(density, prominence=0.0)
    standing_out = about["prominences"] >= _CONTRAST * density[peaks]
    return np.asarray(lowest + bin_width * peaks[standing_out])
