"""Phases of a bench test, found in the inputs: sweeps, plateaus, and transitions from one level to another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, median_filter, minimum_filter1d

from ...numerics.arrays import BoolArray, FloatArray, IndexArray
from ...symbolic.channels import CONTROLLED_INPUTS
from ..recording import Recording, once
from ..thresholds import (
    FAR_FROM_LEVELS,
    LONGEST_TRANSITION,
    MIN_STAY_ROWS,
    PHASE_SMOOTHING,
    SHORTEST_STAY,
    SWEEP_TOLERANCES,
    SWEEP_WINDOW,
)
from .levels import level_tolerance, levels
from .time_series import Segment, segments_of

#: Inputs to which a tire responds with a force curve. A bench sweeps them from a level and back to it.
SLIP_INPUTS = ("kappa", "alpha", "phit")


@dataclass(frozen=True)
class Phase:
    """Consecutive rows in which the bench did one thing.

    Parameters
    ----------
    rows : slice
        Its rows in the recording.
    kind : str
        "sweep" (an input moves steadily), "plateau" (all inputs are held), "transition" (a held input changes from one
        level to another), or "points" (the rows are not a time series: each is a steady point).
    moving : tuple of str
        The inputs that move.
    held : mapping of str to float
        Median of each other input, in SI units.
    """

    rows: slice
    kind: str
    moving: tuple[str, ...]
    held: Mapping[str, float]


@once
def phases(recording: Recording) -> list[Phase]:
    """Return the phases of a bench test.

    An input that was held at levels (`levels`) moves while it is between two of them. An input without levels moves
    while it covers more than two tolerances within one second. A slip that leaves its level and returns to it, or takes
    more than 3 s to another level, is swept. Phases end at gaps of the clock, except for rows that are no time series.

    Parameters
    ----------
    recording : Recording
        In any signs.

    Returns
    -------
    list of Phase
        In the order of the rows. Together they contain every row once.

    Examples
    --------
    >>> import pandas as pd
    >>> clock = np.arange(1800) / 100.0
    >>> load = np.where(clock < 9.0, 900.0, 1800.0)
    >>> angle = 0.1 * np.sin(2.0 * np.pi * clock / 9.0)
    >>> bench = Recording(pd.DataFrame({"t": clock, "alpha": angle, "Fz": load}), "iso", "run.csv")
    >>> [(phase.kind, phase.moving) for phase in phases(bench)]
    [('sweep', ('alpha',)), ('sweep', ('alpha',))]
    """
    course = motions_of(recording)
    inputs = course.inputs
    columns = {channel.name: recording.table[channel.name].to_numpy(dtype=np.float64) for channel in inputs}
    series = iter(range(len(course.series)))
    result: list[Phase] = []
    for segment in _merged_segments(course.segments):
        if not segment.is_series:
            result.append(Phase(segment.rows, "points", (), _medians(columns, inputs, segment.rows)))
            continue
        number = next(series)
        motions = {channel.name: course.motions[i][number] for i, channel in enumerate(inputs)}
        still = np.zeros(segment.rows.stop - segment.rows.start, dtype=np.bool_)
        state = np.stack([still, *(motion.moving for motion in motions.values())])
        cuts = np.flatnonzero((state[:, 1:] != state[:, :-1]).any(axis=0)) + 1
        edges = {0, *cuts.tolist(), *(jump for motion in motions.values() for jump in motion.jumps), len(still)}
        for start, stop in pairwise(sorted(edges)):
            rows = slice(segment.rows.start + start, segment.rows.start + stop)
            moving = tuple(name for name, motion in motions.items() if motion.moving[start])
            between = any(motion.between[start] for motion in motions.values())
            kind = "transition" if between else "sweep" if moving else "plateau"
            held = _medians(columns, [channel for channel in inputs if channel.name not in moving], rows)
            result.append(Phase(rows, kind, moving, held))
    return result


def transitions(recording: Recording, *, settling: float = 0.0) -> NDArray[np.object_]:
    """Return for each row which held input is in transition to another level.

    Parameters
    ----------
    recording : Recording
        In any signs.
    settling : float
        s by which each transition is extended, until the tire has settled.

    Returns
    -------
    ndarray of str, shape (n,)
        Name of the input, or "".
    """
    names = np.full(len(recording), "", dtype=object)
    course = motions_of(recording)
    for channel, motions in zip(course.inputs, course.motions, strict=True):
        if not len(channel.held):
            continue
        for segment, motion in zip(course.series, motions, strict=True):
            between = motion.between.copy()
            between[[jump for jump in motion.jumps if settling]] = True
            if between.any():
                rows = names[segment.rows]
                settled = int(np.ceil(round(settling / segment.interval, 6)))
                rows[_extended(between, settled) & (rows == "")] = channel.name
    return names


@dataclass(frozen=True)
class _Input:
    """One input of a recording, as a running median, with the levels at which it was held (none if it was swept)."""

    name: str
    smooth: FloatArray
    held: FloatArray
    tolerance: float


@dataclass(frozen=True)
class _Motion:
    """Rows of a segment in which an input moves, rows between two levels, and jumps from one row to the next."""

    moving: BoolArray
    between: BoolArray
    jumps: list[int]


@dataclass(frozen=True, eq=False)
class Motions:
    """How the inputs of a recording move, from which phases and transitions follow.

    `inputs`: the controlled inputs with the levels at which they were held. `motions`: by input, the motion in each
    segment that is a time series.
    """

    segments: list[Segment]
    inputs: list[_Input]
    motions: list[list[_Motion]]

    @property
    def series(self) -> list[Segment]:
        """The segments that are time series."""
        return [segment for segment in self.segments if segment.is_series]


@once
def motions_of(recording: Recording) -> Motions:
    """Return how the inputs of a recording move."""
    segments = segments_of(recording)
    series = [segment for segment in segments if segment.is_series]
    inputs = _inputs(recording, series)
    return Motions(segments, inputs, [list(_motions(channel, series)) for channel in inputs])


def _inputs(recording: Recording, series: Sequence[Segment]) -> list[_Input]:
    # In one convention, so that rounding does not depend on that of the recording.
    table = recording.with_signs("iso").table
    interval = float(np.median([segment.interval for segment in series])) if series else np.inf
    inputs = []
    for name in CONTROLLED_INPUTS:
        if name in table:
            values = table[name].to_numpy(dtype=np.float64)
            tolerance = level_tolerance(values, name) or 1.0
            smooth = _smoothed(values, series)
            held = _levels_of_long_stays(smooth, _levels_with_stay(values, tolerance), tolerance, interval)
            inputs.append(_Input(name, smooth, held, tolerance))
    return inputs


def _levels_with_stay(values: FloatArray, tolerance: float) -> FloatArray:
    """Return the levels at which an input stayed for some rows each time.

    A sweep of few samples that returns to its own steps has levels as well, but of one row at a time.
    """
    held = np.array(levels(values, tolerance=tolerance))
    if not len(held):
        return held
    distance = np.abs(values[:, None] - held)
    level = np.where(distance.min(axis=1) <= tolerance, distance.argmin(axis=1), -1)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(level)) + 1, [len(level)]])
    lengths, at = np.diff(edges), level[edges[:-1]]
    # Mean over the rows, not over the visits: short visits at the limit of the tolerance have little influence.
    stays = [lengths[at == k] @ lengths[at == k] / lengths[at == k].sum() for k in range(len(held))]
    return np.array([value for value, stay in zip(held, stays, strict=True) if stay >= MIN_STAY_ROWS])


def _levels_of_long_stays(values: FloatArray, held: FloatArray, tolerance: float, interval: float) -> FloatArray:
    """Return the levels, and those at which an input stayed for longer than any transition takes.

    A level beside one with many more rows has no density peak of its own. Its rows are no transition: they stay.
    """
    while len(held):
        far = np.abs(values[:, None] - held).min(axis=1) > tolerance
        far = _closed(far, round(SHORTEST_STAY / interval), ends=False)
        ends = np.flatnonzero(np.diff(far) | (np.abs(np.diff(values)) > tolerance)) + 1
        runs = [values[start:stop] for start, stop in pairwise([0, *ends.tolist(), len(far)]) if far[start]]
        long_runs = [run for run in runs if len(run) * interval > LONGEST_TRANSITION]
        longest_first = sorted(long_runs, key=len, reverse=True)
        medians = (np.median(run) for run in longest_first if np.ptp(np.quantile(run, (0.05, 0.95))) <= tolerance)
        # A new level is apart from all others: the loop ends.
        apart = next((median for median in medians if np.abs(median - held).min() > 0.5 * tolerance), None)
        if apart is None:
            break
        held = np.sort(np.append(held, apart))
    return held


def _merged_segments(segments: Sequence[Segment]) -> list[Segment]:
    """Return the segments; consecutive ones that are not time series are merged."""
    merged: list[Segment] = []
    for segment in segments:
        if merged and not segment.is_series and not merged[-1].is_series:
            merged[-1] = replace(segment, rows=slice(merged[-1].rows.start, segment.rows.stop))
        else:
            merged.append(segment)
    return merged


def _medians(columns: Mapping[str, FloatArray], inputs: Sequence[_Input], rows: slice) -> dict[str, float]:
    medians = np.median([columns[channel.name][rows] for channel in inputs], axis=1) if inputs else ()
    return {channel.name: float(median) for channel, median in zip(inputs, medians, strict=True)}


def _motions(channel: _Input, series: Sequence[Segment]) -> Iterator[_Motion]:
    if not len(channel.held):
        for segment in series:
            yield _swept_motion(channel.smooth[segment.rows], channel.tolerance, segment.interval)
        return
    offset = np.abs(channel.smooth[:, None] - channel.held)
    nearest, distance = offset.argmin(axis=1), offset.min(axis=1)
    for segment in series:
        yield _held_motion(channel, nearest[segment.rows], distance[segment.rows], segment.interval)


def _smoothed(values: FloatArray, series: Sequence[Segment]) -> FloatArray:
    """Return the running median in each segment, by one pass over all segments with equal windows.

    A segment with NaN has a separate pass: the filter spreads NaN beyond its window.
    """
    smooth = values.copy()
    passes: dict[tuple[int, int], list[slice]] = {}
    for segment in series:
        whole = np.isfinite(values[segment.rows]).all()
        key = round(PHASE_SMOOTHING / segment.interval) | 1, -1 if whole else segment.rows.start
        passes.setdefault(key, []).append(segment.rows)
    for (size, _), slices in passes.items():
        pieces = [_padded(values[rows], size // 2) for rows in slices]
        medians = median_filter(np.concatenate(pieces), size=size)
        end = 0
        for rows, piece in zip(slices, pieces, strict=True):
            end += len(piece)
            smooth[rows] = medians[end - len(piece) + size // 2 : end - size // 2]
    return smooth


def _padded(values: FloatArray, n: int) -> FloatArray:
    """Return the values with the first and the last one repeated, as `numpy.pad` does, but in a tenth of its time."""
    return np.concatenate([np.full(n, values[0]), values, np.full(n, values[-1])])


def _held_motion(channel: _Input, nearest: IndexArray, distance: FloatArray, step: float) -> _Motion:
    between = _between_levels(nearest, distance, channel.held, channel.tolerance)
    # A transition that passes a level does not end there. A sweep does not end where it turns, although many rows are
    # near the turning point.
    turning = round(2.0 * SWEEP_WINDOW / step)
    between = _closed(between, turning if channel.name in SLIP_INPUTS else round(SHORTEST_STAY / step), ends=False)
    # A held channel that jumps from one row to the next has no row between its levels.
    changes = np.flatnonzero(np.diff(nearest)) + 1
    jumps = changes[~between[changes]].tolist()
    if channel.name not in SLIP_INPUTS:
        return _Motion(between, between, jumps)
    links = _links(between, nearest, round(LONGEST_TRANSITION / step))
    return _Motion(_closed(between, turning, ends=True), links, jumps)


def _swept_motion(smooth: FloatArray, tolerance: float, step: float) -> _Motion:
    window = max(3, round(SWEEP_WINDOW / step))
    covered = maximum_filter1d(smooth, window) - minimum_filter1d(smooth, window)
    # Short rests are the turning points of a sweep, its start and its end.
    moving = _closed(covered > SWEEP_TOLERANCES * tolerance, 2 * window, ends=True)
    return _Motion(moving, np.zeros(len(smooth), dtype=np.bool_), [])


def _closed(rows: BoolArray, longest: int, *, ends: bool) -> BoolArray:
    """Return the rows with shorter gaps filled; gaps at the two ends only on request."""
    closed = rows.copy()
    if rows.any():
        edges = [0, *(np.flatnonzero(np.diff(rows)) + 1).tolist(), len(rows)]
        for start, stop in pairwise(edges):
            if stop - start < longest and (ends or 0 < start < stop < len(rows)):
                closed[start:stop] = True
    return closed


def _between_levels(nearest: IndexArray, distance: FloatArray, held: FloatArray, tolerance: float) -> BoolArray:
    """Return the rows between two levels, given the nearest level of each row and the distance to it.

    A held load deviates by more than its tolerance while the slip is swept: the deviation alone is not a transition. A
    transition is where the nearest level changes, from the last row at the old level to the first row at the new one.
    Rows that are far from every level belong to a transition as well, for instance at the ends of a segment.
    """
    away = distance > tolerance
    between = np.zeros(len(nearest), dtype=np.bool_)
    for change in np.flatnonzero(np.diff(nearest)):
        start, stop = change, change + 1
        while start >= 0 and away[start]:
            start -= 1
        while stop < len(nearest) and away[stop]:
            stop += 1
        between[start + 1 : stop] = True
    spacing = np.diff(held).min() if len(held) > 1 else np.inf
    return between | (distance > min(FAR_FROM_LEVELS * tolerance, max(spacing, 2.0 * tolerance)))


def _links(between: BoolArray, nearest: IndexArray, longest: int) -> BoolArray:
    """Return the rows of short transitions from one level to another; an excursion from one level is a sweep."""
    edges = [0, *(np.flatnonzero(np.diff(between)) + 1).tolist(), len(between)]
    links = np.zeros(len(between), dtype=np.bool_)
    for start, stop in pairwise(edges):
        inside = between[start] and 0 < start < stop < len(between) and stop - start <= longest
        if inside and nearest[start - 1] != nearest[stop]:
            links[start:stop] = True
    return links


def _extended(rows: BoolArray, by: int) -> BoolArray:
    """Return the rows with ``by`` rows added after each run of them."""
    extended = rows.copy()
    for stop in (np.flatnonzero(rows[:-1] & ~rows[1:]) + 1).tolist():
        extended[stop : stop + by] = True
    return extended
