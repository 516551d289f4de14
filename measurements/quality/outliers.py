"""Readings that stand far off the course of their channel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from ..channels import CHANNELS
from ..operating_conditions.phases import clock_step, is_course
from ..recording import Recording

_SMOOTHED = 0.15  # s: the course is the running median over this time, and never fewer rows than the next
_FEWEST_ROWS = 7
_SIGMA = 1.4826  # standard deviation of normal numbers over their median absolute deviation
_AROUND = 1.0  # s: a tire at its limit scatters more than at rest, so the scatter is that of the time around
_COARSEST = 0.5  # s: fewest rows that span more than this follow no course of a sweep
_JUMP = 0.7  # of how far a reading stands off: so far it jumps from its neighbors, or it is a bend of the course
_LEAST = 0.1  # of the channel's spread: what stands off by less spoils no fit, and a coarse sensor does it daily


@dataclass(frozen=True)
class Outlier:
    """One reading that stands off its channel's course.

    Parameters
    ----------
    row : int
        Counted from 0.
    channel : str
    value, usual : float
        What was read, and the running median there, in SI.
    """

    row: int
    channel: str
    value: float
    usual: float

    def __str__(self) -> str:
        """Say where, what, and what the neighbors read."""
        unit = CHANNELS[self.channel].unit
        return f"row {self.row + 1}: {self.channel} is {self.value:.4g} {unit} among {self.usual:.4g}"


def outliers(recording: Recording, *, sigmas: float = 15.0) -> list[Outlier]:
    """Return readings that stand off the running median of their channel by many standard deviations.

    The Hampel identifier (Davies and Gather, 1993) on segments that are courses in time; the scatter is that
    of the whole segment or of the second around, whichever is greater. What stands off by less than a tenth
    of the channel's spread, or than a held input wanders anyway, is none; nor is a stretch of bad readings
    longer than half the median's window (0.15 s): it is another course. Where seven rows span more than that,
    a bend of the course looks alike but for the jump from row to row; where they span 0.5 s there is no course.

    Parameters
    ----------
    recording : Recording
    sigmas : float
        Far more than a normal distribution needs: what is dropped has to be wrong beyond doubt.

    Returns
    -------
    list of Outlier
        By channel, then by row.

    Examples
    --------
    >>> import pandas as pd
    >>> force = 100.0 * np.sin(np.arange(200) / 30.0)
    >>> force[70] = 900.0
    >>> bench = Recording(pd.DataFrame({"t": np.arange(200) / 100.0, "Fy": force}), "iso", "run.csv")
    >>> [str(reading) for reading in outliers(bench)]
    ['row 71: Fy is 900 N among 74.57']
    """
    found = []
    courses = [segment for segment in recording.segments() if is_course(recording, segment)]
    for name in CHANNELS:
        if name == "t" or name not in recording.table:
            continue
        values = recording.table[name].to_numpy(dtype=np.float64)
        tolerance = CHANNELS[name].tolerance or 0.0
        for segment in courses:
            step = clock_step(recording, segment)
            if _FEWEST_ROWS * step > _COARSEST:
                continue
            usual = _usual_course(values[segment], step)
            for row in np.flatnonzero(_far(values[segment], usual, step, sigmas, tolerance)).tolist():
                at = segment.start + row
                found.append(Outlier(at, name, float(values[at]), float(usual[row])))
    return found


def _usual_course(values: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Return the running median, and where its window reaches beyond an end, a straight line."""
    whole = _filled(values)
    size = _window(step, _SMOOTHED, len(values))
    usual = median_filter(whole, size=size, mode="nearest")
    usual[: size // 2] = _robust_line(whole[:size])[: size // 2]
    usual[-(size // 2) :] = _robust_line(whole[-size:])[-(size // 2) :]
    return np.asarray(usual)


def _filled(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the values; what was not measured, and pulls no median, on the line between its neighbors."""
    known = np.isfinite(values)
    rows = np.arange(len(values))
    return np.interp(rows, rows[known], values[known]) if known.any() else values


def _window(step: float, time: float, rows: int) -> int:
    return min(max(_FEWEST_ROWS, round(time / step)), rows - 1) | 1


def _robust_line(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the line of median slope through equally spaced values (Theil and Sen): no single one bends it."""
    rows = np.arange(len(values))
    first, second = np.triu_indices(len(values), 1)
    slope = np.median((values[second] - values[first]) / (second - first))
    return np.asarray(slope * rows + np.median(values - slope * rows))


def _far(
    values: NDArray[np.float64], usual: NDArray[np.float64], step: float, sigmas: float, tolerance: float
) -> NDArray[np.bool_]:
    known = np.isfinite(values)
    if known.sum() < _FEWEST_ROWS:
        return np.zeros(len(values), dtype=np.bool_)
    off = np.abs(values - usual)
    low, high = np.quantile(usual[known], (0.05, 0.95))
    least = max(tolerance, _LEAST * float(high - low), np.finfo(np.float64).eps * float(np.abs(usual[known]).max()))
    far = known & (off > max(sigmas * _SIGMA * float(np.median(off[known])), least))
    if far.any():  # rarely: the scatter around each row takes its time
        around = median_filter(_filled(off), size=_window(step, _AROUND, len(off)), mode="mirror")
        far &= off > sigmas * _SIGMA * around
    return _jumping(far, values, off) if _FEWEST_ROWS * step > _SMOOTHED else np.asarray(far)


def _jumping(far: NDArray[np.bool_], values: NDArray[np.float64], off: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the stretches of rows that jump away from their measured neighbors, as far as they stand off."""
    known = np.flatnonzero(np.isfinite(values))
    course, stands = values[known], off[known]
    kept = np.zeros_like(far)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], far[known], [False]])))
    for start, stop in edges.reshape(-1, 2):
        into = abs(course[start] - course[start - 1]) if start > 0 else np.inf
        out = abs(course[stop - 1] - course[stop]) if stop < len(course) else np.inf
        kept[known[start:stop]] = into >= _JUMP * stands[start] and out >= _JUMP * stands[stop - 1]
    return kept
