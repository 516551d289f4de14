"""Inconsistent data at equal operating conditions and slips.

Two files or two segments of a file may contain the same operating condition, and so do the up-sweep and the down-sweep.
The residuals of the two sides are compared in cells of equal operating condition and slips. Errors of the tire model
are the same on both sides and cancel, and so do differences of slip within a cell.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...measurements.operating_conditions.levels import held_levels
from ...numerics.arrays import FloatArray, IntArray
from ...numerics.correlation import correlation_length
from ...numerics.ties import graded
from ..problem.weights import OWN_SLIP
from .residuals import Residuals

#: Fewest rows of each side of a comparison, and of each side in a cell.
MIN_ROWS, MIN_IN_CELL = 50, 3
#: Least range of a swept slip.
MIN_SWEEP = 0.05
#: Least rate of a changing slip, relative to the 90 % quantile of its rate.
MOVES = 0.25
#: Number of rows over which a slip is averaged before its rate is computed.
SMOOTHED = 21


@dataclass(frozen=True)
class Disagreement:
    """Difference between two measurements of the same operating conditions.

    - `first`, `second`: names of files, "file, segment k" and "others", or "up" and "down".
    - `mean`, `typical`: mean difference first minus second, and the root mean square over the cells without the
      contribution of noise.
    - `sigmas`: the mean difference in standard deviations under time-correlated noise.
    - `rows`: of the side with fewer rows.
    - `at`: the operating condition with the largest difference.
    - `most`: the difference in this operating condition, averaged over its slips.
    """

    channel: str
    unit: str
    first: str
    second: str
    mean: float
    typical: float
    sigmas: float
    rows: int
    at: dict[str, float]
    most: float


def disagreeing_files(residuals: Residuals) -> tuple[Disagreement, ...]:
    """Compare all pairs of recordings by channel, at common operating conditions and slips."""
    numbers, differences = residuals.recording, []
    for a, b in combinations(range(len(residuals.sources)), 2):
        for channel in residuals.channels:
            sides = np.flatnonzero(numbers == a), np.flatnonzero(numbers == b)
            differences.append(_compared(residuals, channel, sides, (residuals.sources[a], residuals.sources[b])))
    return tuple(difference for difference in differences if difference is not None)


def disagreeing_segments(residuals: Residuals) -> tuple[Disagreement, ...]:
    """Compare each segment with the other segments of its recording in the same operating condition.

    Returns: the most significant one of each recording and channel with repeated operating conditions.
    """
    differences = []
    for number, source in enumerate(residuals.sources):
        segments = list(_pieces(residuals.segment, np.flatnonzero(residuals.recording == number)))
        by_condition_number: dict[int, list[int]] = {}  # segments by their most frequent operating condition
        for k, rows in enumerate(segments):
            by_condition_number.setdefault(int(np.bincount(residuals.condition[rows]).argmax()), []).append(k)
        pairs = [
            (k, (segments[k], np.concatenate([segments[other] for other in same if other != k])))
            for same in by_condition_number.values()
            if len(same) > 1
            for k in same
        ]
        for channel in residuals.channels:
            differences_of_channel = [
                _compared(residuals, channel, sides, (f"{source}, segment {k + 1}", "others")) for k, sides in pairs
            ]
            defined = [difference for difference in differences_of_channel if difference is not None]
            if defined:
                differences.append(max(defined, key=lambda difference: graded(abs(difference.sigmas))))
    return tuple(differences)


def sweep_differences(residuals: Residuals) -> tuple[Disagreement, ...]:
    """Compare rows with increasing slip and rows with decreasing slip, at equal slip.

    Returns: one for each recording and channel with a slip that is swept in both directions; `first` is "file, slip
    up".
    """
    differences = []
    for number, source in enumerate(residuals.sources):
        rows_of_recording = np.flatnonzero(residuals.recording == number)
        rates = {
            slip: _direction(residuals, rows_of_recording, slip)
            for slip in ("kappa", "alpha")
            if _swept(residuals, rows_of_recording, slip)
        }
        for channel in residuals.channels if rates else ():
            usual_slip = OWN_SLIP.get(channel, "alpha")
            slip = usual_slip if usual_slip in rates else next(iter(rates))
            sides = rows_of_recording[rates[slip] > 0], rows_of_recording[rates[slip] < 0]
            differences.append(_compared(residuals, channel, sides, (f"{source}, {slip} up", "down")))
    return tuple(difference for difference in differences if difference is not None)


def _swept(residuals: Residuals, rows_of_recording: IntArray, slip: str) -> bool:
    if slip not in residuals.table:
        return False
    values = residuals.table[slip].iloc[rows_of_recording]
    return bool(np.ptp(values.to_numpy()) >= MIN_SWEEP) and not held_levels(values)


def _direction(residuals: Residuals, rows_of_recording: IntArray, slip: str) -> FloatArray:
    """Return 1 for increasing slip, -1 for decreasing slip, 0 for almost constant slip; shape (n_rows,)."""
    values = residuals.table[slip].to_numpy(dtype=float)
    rate = np.zeros(len(values))
    for rows in _pieces(residuals.segment, rows_of_recording):
        if len(rows) > SMOOTHED:
            rate[rows] = np.gradient(uniform_filter1d(values[rows], SMOOTHED, mode="nearest"))
    fast = float(np.quantile(np.abs(rate[rows_of_recording]), 0.9))
    return np.where(np.abs(rate[rows_of_recording]) > MOVES * fast, np.sign(rate[rows_of_recording]), 0.0)


def _pieces(segment: IntArray, rows: IntArray) -> Iterator[IntArray]:
    """Yield the rows of each segment."""
    yield from np.split(rows, np.flatnonzero(np.diff(segment[rows])) + 1)


def _compared(
    residuals: Residuals, channel: str, sides: tuple[IntArray, IntArray], names: tuple[str, str]
) -> Disagreement | None:
    """Return the difference of two sides in a channel; None if they have too few common rows."""
    values = residuals.measured_minus_computed[channel]
    chosen = [side[np.isfinite(values[side])] for side in sides]
    shared = _shared_cells(residuals.cell, chosen)
    rows = [side[np.isin(residuals.cell[side], shared)] for side in chosen]
    if min(len(side) for side in rows) < MIN_ROWS:
        return None
    sums = [_by_cell(shared, residuals.cell[side], values[side]) for side in rows]
    (n1, mean1, var1), (n2, mean2, var2) = sums
    difference, weight = mean1 - mean2, n1 * n2 / (n1 + n2)
    noises = [
        values[side] - at[np.searchsorted(shared, residuals.cell[side])]
        for side, (_, at, _) in zip(rows, sums, strict=True)
    ]
    lengths = [correlation_length(e, residuals.segment[side]) for e, side in zip(noises, rows, strict=True)]
    noise = var1 * lengths[0] / n1 + var2 * lengths[1] / n2  # variance of the difference in each cell
    total = float(weight.sum())
    mean = float(weight @ difference) / total
    sd = sum(float(np.var(e)) * length / len(e) for e, length in zip(noises, lengths, strict=True)) ** 0.5
    _, first = np.unique(residuals.cell[rows[0]], return_index=True)
    condition = residuals.condition[rows[0][first]]
    by_condition = {c: np.average(difference[condition == c], weights=weight[condition == c]) for c in set(condition)}
    worst = max(by_condition, key=lambda c: graded(abs(by_condition[c])))
    typical = float(weight @ difference**2 - weight @ noise) / total
    sign = residuals.sign(channel)
    unit = residuals.units[channel]
    return Disagreement(
        channel, unit, *names, sign * mean, max(typical, 0.0) ** 0.5, sign * mean / sd if sd > 0 else 0.0,
        min(len(side) for side in rows), residuals.at(int(worst)), sign * float(by_condition[worst]),
    )  # fmt: skip


def _shared_cells(cell: IntArray, sides: Sequence[IntArray]) -> IntArray:
    (first, n1), (second, n2) = (np.unique(cell[side], return_counts=True) for side in sides)
    return np.intersect1d(first[n1 >= MIN_IN_CELL], second[n2 >= MIN_IN_CELL])


def _by_cell(shared: IntArray, cell: IntArray, values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return rows, mean and variance of each cell."""
    index = np.searchsorted(shared, cell)
    n = np.bincount(index, minlength=len(shared)).astype(float)
    mean = np.bincount(index, values, len(shared)) / n
    variance = np.bincount(index, (values - mean[index]) ** 2, len(shared)) / np.maximum(n - 1, 1)
    return n, mean, variance
