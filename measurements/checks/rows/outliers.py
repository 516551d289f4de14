"""Outliers: values far from the running median of their channel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from ....numerics.arrays import BoolArray, FloatArray
from ....symbolic.channels import CHANNELS
from ...operating_conditions.time_series import Segment, segments_of
from ...recording import Recording
from ...thresholds import (
    LONGEST_MEDIAN_SPAN,
    MIN_DEVIATION,
    MIN_JUMP,
    MIN_WINDOW_ROWS,
    OUTLIER_SIGMAS,
    OUTLIER_WINDOW,
    SCATTER_WINDOW,
    SIGMA_PER_DEVIATION,
)

#: Slopes that are held in memory at a time.
MAX_SLOPES = 1_000_000


@dataclass(frozen=True)
class Outlier:
    """One value far from the running median of its channel.

    Parameters
    ----------
    row : int
        Counted from 0.
    channel : str
        The channel of the value.
    value, median : float
        The value and the running median at its row, in SI units.
    """

    row: int
    channel: str
    value: float
    median: float

    def __str__(self) -> str:
        """Return row, channel, value and running median in one line."""
        unit = CHANNELS[self.channel].after
        return f"row {self.row + 1}: {self.channel} is {self.value:.4g}{unit}, the running median is {self.median:.4g}"


def outliers(recording: Recording) -> list[Outlier]:
    """Return values that deviate from the running median of their channel by many standard deviations.

    The Hampel identifier (Davies and Gather, 1993), applied to segments that are time series. The standard deviation is
    that of the segment or that of the second around the row, whichever is greater. A value is not an outlier if it
    deviates by less than a tenth of the range of the channel or less than the tolerance of a held input. Bad values
    that are consecutive for longer than half of the median's window (0.15 s) are not found. Where seven rows span more
    than the window, or there is no clock, an outlier has to jump from its neighbors as well, because curvature of the
    signal also deviates from the median. Where seven rows span more than 0.5 s, no outlier is sought.

    Parameters
    ----------
    recording : Recording
        In any signs.

    Returns
    -------
    list of Outlier
        In the order of channels, then of rows.

    Examples
    --------
    >>> import pandas as pd
    >>> force = 100.0 * np.sin(np.arange(200) / 30.0)
    >>> force[70] = 900.0
    >>> bench = Recording(pd.DataFrame({"t": np.arange(200) / 100.0, "Fy": force}), "iso", "run.csv")
    >>> [str(outlier) for outlier in outliers(bench)]
    ['row 71: Fy is 900 N, the running median is 74.57']
    """
    series = [segment for segment in segments_of(recording) if segment.is_series]
    series = [segment for segment in series if MIN_WINDOW_ROWS * segment.interval <= LONGEST_MEDIAN_SPAN]
    far_values: list[Outlier] = []
    has_clock = "t" in recording.table
    for name in CHANNELS:
        if name == "t" or name not in recording.table:
            continue
        values = recording.table[name].to_numpy(dtype=np.float64)
        tolerance = CHANNELS[name].tolerance or 0.0
        median = _running_median(values, series)
        for segment in series:
            rows = segment.rows
            far = _far(values[rows], median[rows], segment.interval, tolerance)
            if far.any() and not (has_clock and MIN_WINDOW_ROWS * segment.interval <= OUTLIER_WINDOW):
                far = _jumping(far, values[rows], np.abs(values[rows] - median[rows]))
            for row in (rows.start + np.flatnonzero(far)).tolist():
                far_values.append(Outlier(row, name, float(values[row]), float(median[row])))
    return far_values


def _running_median(values: FloatArray, series: Sequence[Segment]) -> FloatArray:
    """Return the running median in segments, and a straight line where its window extends beyond an end.

    One pass over all rows for all segments with equal windows: windows that extend into another segment are replaced.
    """
    median = np.full(len(values), np.nan)
    whole = values.copy()
    by_size: dict[int, list[slice]] = {}
    for segment in series:
        if not np.isfinite(values[segment.rows]).any():  # NaN would spread to the windows of other segments
            continue
        whole[segment.rows] = _interpolated(values[segment.rows])
        size = _window(segment.interval, OUTLIER_WINDOW, segment.rows.stop - segment.rows.start)
        by_size.setdefault(size, []).append(segment.rows)
    for size, slices in by_size.items():
        rows = np.concatenate([np.arange(part.start, part.stop) for part in slices])
        median[rows] = median_filter(whole[rows], size=size, mode="nearest")
        half = size // 2
        heads = np.array([np.arange(part.start, part.start + size) for part in slices])
        tails = np.array([np.arange(part.stop - size, part.stop) for part in slices])
        median[heads[:, :half]] = _robust_lines(whole[heads])[:, :half]
        median[tails[:, -half:]] = _robust_lines(whole[tails])[:, -half:]
    return median


def _interpolated(values: FloatArray) -> FloatArray:
    """Return the values with NaN replaced by linear interpolation, so that it does not affect the median."""
    measured = np.isfinite(values)
    if measured.all():
        return values
    rows = np.arange(len(values))
    return np.interp(rows, rows[measured], values[measured])


def _window(step: float, time: float, rows: int) -> int:
    return min(max(MIN_WINDOW_ROWS, round(time / step)), rows - 1) | 1


def _robust_lines(windows: FloatArray) -> FloatArray:
    """Return the lines of median slope through equally spaced values (Theil-Sen estimator), one line a row."""
    rows = np.arange(windows.shape[1])
    first, second = np.triu_indices(windows.shape[1], 1)
    lines = np.empty_like(windows)
    step = max(MAX_SLOPES // max(len(first), 1), 1)
    for some in (slice(start, start + step) for start in range(0, len(windows), step)):
        values = windows[some]
        slope = np.median((values[:, second] - values[:, first]) / (second - first), axis=1)[:, None]
        lines[some] = slope * rows + np.median(values - slope * rows, axis=1)[:, None]
    return lines


def _far(values: FloatArray, median: FloatArray, step: float, tolerance: float) -> BoolArray:
    measured, none = np.isfinite(values), np.zeros(len(values), dtype=np.bool_)
    if np.count_nonzero(measured) < MIN_WINDOW_ROWS:
        return none
    deviation = np.abs(values - median)
    sizes = deviation[measured]
    limit = OUTLIER_SIGMAS * SIGMA_PER_DEVIATION * float(np.median(sizes))
    if sizes.max() <= max(tolerance, limit):
        return none
    rounding = np.finfo(np.float64).eps * float(np.abs(median[measured]).max())
    least = max(tolerance, MIN_DEVIATION * _width(median[measured]), rounding)
    far = measured & (deviation > max(limit, least))
    if far.any():  # the local scatter takes long to compute and is rarely needed
        size = _window(step, SCATTER_WINDOW, len(deviation))
        far &= deviation > OUTLIER_SIGMAS * SIGMA_PER_DEVIATION * median_filter(
            _interpolated(deviation), size=size, mode="mirror"
        )
    return np.asarray(far)


def _width(values: FloatArray) -> float:
    """Return the distance of the quantiles 0.05 and 0.95, as `numpy.quantile` has them."""
    ordered = np.sort(values)
    low, high = np.interp([0.05, 0.95], np.linspace(0.0, 1.0, len(ordered)), ordered)
    return float(high - low)


def _jumping(far: BoolArray, values: FloatArray, deviation: FloatArray) -> BoolArray:
    """Return the runs of rows that jump from their measured neighbors by most of their deviation."""
    measured = np.flatnonzero(np.isfinite(values))
    signal, size = values[measured], deviation[measured]
    jumping = np.zeros_like(far)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], far[measured], [False]])))
    for start, stop in edges.reshape(-1, 2):
        before = abs(signal[start] - signal[start - 1]) if start > 0 else np.inf
        after = abs(signal[stop - 1] - signal[stop]) if stop < len(signal) else np.inf
        jumping[measured[start:stop]] = before >= MIN_JUMP * size[start] and after >= MIN_JUMP * size[stop - 1]
    return jumping
