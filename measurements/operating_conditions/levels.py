"""Levels at which a test bench held an input, from the density of its values."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.ndimage import gaussian_filter1d

from ...boundary.errors import DataError
from ...numerics.arrays import FloatArray, IndexArray
from ...symbolic.channels import CHANNELS
from ..thresholds import LOAD_TOLERANCE, MIN_LEVEL_PROMINENCE, MIN_LEVEL_SHARE, MIN_ROWS_AT_LEVELS

#: Largest number of levels of a held input; with more levels it was swept in steps.
MAX_LEVELS = 12


def level_tolerance(values: ArrayLike, channel: str | None = None) -> float:
    """Return the deviation of a held channel from its level.

    Parameters
    ----------
    values : array_like, shape (n,)
        Values of one channel, SI.
    channel : str, optional
        A contract name. Its declaration has the tolerance. The tolerance of loads and of unknown channels is
        proportional to the largest magnitude.

    Returns
    -------
    float
        In SI units.

    Examples
    --------
    >>> level_tolerance([0.0, 80e3], "p"), level_tolerance([200.0, 1000.0], "Fz")
    (3000.0, 40.0)
    """
    declared = CHANNELS.get(channel or "")
    if declared is not None and declared.tolerance is not None:
        return declared.tolerance
    magnitudes = np.abs(np.asarray(values, dtype=np.float64))
    return LOAD_TOLERANCE * float(np.nanmax(magnitudes, initial=0.0))


def levels(values: ArrayLike, *, tolerance: float | None = None) -> list[float]:
    """Return the levels at which a channel was held.

    The density of the values, smoothed to the width of the tolerance, has one peak per level. Peaks of low prominence
    and peaks with less than 1 % of the rows are not levels. Levels may differ in their number of rows. Two levels are
    separated if they are about two tolerances apart.

    Parameters
    ----------
    values : array_like, shape (n,)
        A column of a table, whose name gives the tolerance, or numbers. NaN is ignored.
    tolerance : float, optional
        Deviation of a held channel from its level, in SI units. Default `level_tolerance`.

    Returns
    -------
    list of float
        Ascending. Each is the median of the rows near it. Empty if the channel was swept.

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
    if near_a_peak.any(axis=1).mean() < MIN_ROWS_AT_LEVELS:
        return []
    frequent = near_a_peak.mean(axis=0) >= MIN_LEVEL_SHARE
    return [float(np.median(numbers[rows])) for rows in near_a_peak.T[frequent]]


def held_levels(column: pd.Series) -> list[float]:
    """Return the `levels` of a held channel; empty for a swept one, also if it was swept in many steps.

    Parameters
    ----------
    column : pandas.Series, shape (n,)
        Its name gives the tolerance.

    Returns
    -------
    list of float
        In SI units.
    """
    held = levels(column)
    return held if len(held) <= MAX_LEVELS else []


def _density_peaks(numbers: FloatArray, tolerance: float) -> FloatArray:
    """Return the prominent peaks of the smoothed density of the numbers."""
    bin_width = tolerance / 8.0
    # Empty bins at both ends: a level at the edge of the range is a peak as well.
    lowest = numbers.min() - 2.0 * tolerance
    bins = int(np.ceil((numbers.max() - numbers.min() + 4.0 * tolerance) / bin_width)) + 1
    # Each number is distributed to the two nearest bins: counts in whole bins would alias with an even sweep's spacing.
    position = (numbers - lowest) / bin_width
    left = np.floor(position).astype(np.intp)
    right_share = position - left
    counts = np.bincount(left, 1.0 - right_share, bins + 1) + np.bincount(left + 1, right_share, bins + 1)
    density = gaussian_filter1d(counts, sigma=4.0, mode="constant")
    peaks = local_maxima(density)
    prominent = prominences_of(density, peaks) >= MIN_LEVEL_PROMINENCE * density[peaks]
    return np.asarray(lowest + bin_width * peaks[prominent])


def local_maxima(density: FloatArray) -> IndexArray:
    """Return the indices of the local maxima; of equal values the one in the middle, nothing at the ends.

    `scipy.signal.find_peaks` returns the same. Loading scipy.signal takes longer than reading a table.
    """
    starts = np.flatnonzero(np.diff(density, prepend=np.nan) != 0.0)  # of runs of equal values
    ends = np.append(starts[1:], len(density)) - 1
    heights = density[starts]
    higher = (heights[1:-1] > heights[:-2]) & (heights[1:-1] > heights[2:])
    return np.asarray((starts[1:-1] + ends[1:-1])[higher] // 2)


def prominences_of(density: FloatArray, peaks: IndexArray) -> FloatArray:
    """Return the height of each peak above the higher one of the lowest points that separate it from higher peaks."""
    prominences = np.empty(len(peaks))
    for i, peak in enumerate(peaks):
        higher = np.flatnonzero(density > density[peak])
        position = int(np.searchsorted(higher, peak))
        left = higher[position - 1] if position else 0
        right = higher[position] if position < len(higher) else len(density)
        prominences[i] = density[peak] - max(density[left : peak + 1].min(), density[peak:right].min())
    return prominences
