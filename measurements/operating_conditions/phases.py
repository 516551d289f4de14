"""What a bench was doing: sweeps, plateaus, and the ways from one level to the next, found in the inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, median_filter, minimum_filter1d

from ..channels import INPUTS
from ..recording import Recording
from .levels import level_tolerance, levels

#: The inputs that a bench moves; time and temperature move by themselves.
MOVED = tuple(name for name in INPUTS if name not in ("t", "T"))
#: Those that a tire answers to with a curve: benches sweep them, from a level and back to it.
SLIPS = ("kappa", "alpha", "phit")
_SMOOTHED = 0.2  # s: ripple of the wheel and noise go, the corner of a step stays
_WINDOW = 1.0  # s: a channel that moves by more than two tolerances within is swept
_PASSED = 0.5  # s: who is at a level for less only passes it
_FEWEST_STAYED = 3  # rows
_LONGEST_WAY = 3.0  # s: a slip that takes longer from one level to the next is swept
_MINIMUM_ROWS = 25  # fewer say nothing of a course in time
_USUAL_STEP = 0.01  # s, where no clock was recorded


@dataclass(frozen=True)
class Phase:
    """A stretch of rows in which a bench did one thing.

    Parameters
    ----------
    rows : slice
    kind : str
        "sweep" (an input moves steadily), "plateau" (all are held), "transition" (a held input goes from one
        level to another), or "points" (rows that are no course in time: one condition each).
    moving : tuple of str
        The inputs that move.
    held : mapping of str to float
        The others, each with its median, in SI.
    """

    rows: slice
    kind: str
    moving: tuple[str, ...]
    held: Mapping[str, float]


def phases(recording: Recording) -> list[Phase]:
    """Return what the bench did, stretch by stretch.

    An input that was held at levels (`levels`) moves where it is between two of them; an input that was
    not, where it covers more than two tolerances within a second. A slip that leaves its level and comes
    back to it, or takes more than 3 s to another, is swept. Stretches end at gaps of the clock, but for rows that
    are no course in time.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    list of Phase
        In order, together all rows.

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
    inputs = _inputs(recording)
    columns = {each.name: recording.table[each.name].to_numpy(dtype=np.float64) for each in inputs}
    found: list[Phase] = []
    for segment, course in _stretches(recording):
        if not course:
            found.append(Phase(segment, "points", (), _medians(columns, inputs, segment)))
            continue
        courses = [_course(each, segment, clock_step(recording, segment)) for each in inputs]
        state = np.stack([np.zeros(segment.stop - segment.start), *(course.moving for course in courses)])
        cuts = np.flatnonzero((state[:, 1:] != state[:, :-1]).any(axis=0)) + 1
        edges = {0, *cuts.tolist(), *(jump for course in courses for jump in course.jumps), state.shape[1]}
        for start, stop in pairwise(sorted(edges)):
            rows = slice(segment.start + start, segment.start + stop)
            moving = tuple(each.name for each, course in zip(inputs, courses, strict=True) if course.moving[start])
            between = any(course.off[start] for course in courses)
            kind = "transition" if between else "sweep" if moving else "plateau"
            held = _medians(columns, [each for each in inputs if each.name not in moving], rows)
            found.append(Phase(rows, kind, moving, held))
    return found


def transitions(recording: Recording, *, settling: float = 0.0) -> NDArray[np.object_]:
    """Return for each row which held input was on the way to another level.

    Parameters
    ----------
    recording : Recording
    settling : float
        s: so long after its arrival the tire is still on the way.

    Returns
    -------
    ndarray of str, shape (n,)
        The input's name, "" where none was.
    """
    found = np.full(len(recording), "", dtype=object)
    inputs = [each for each in _inputs(recording) if len(each.held)]
    for segment in recording.segments():
        if not is_course(recording, segment):
            continue
        step = clock_step(recording, segment)
        for each in inputs:
            course = _course(each, segment, step)
            off = course.off.copy()
            off[[jump for jump in course.jumps if settling]] = True
            rows = found[segment]
            rows[_prolonged(off, int(np.ceil(round(settling / step, 6)))) & (rows == "")] = each.name
    return found


def is_course(recording: Recording, segment: slice) -> bool:
    """Return whether a segment's rows are a course in time rather than points, one condition each.

    Parameters
    ----------
    recording : Recording
    segment : slice

    Returns
    -------
    bool

    Examples
    --------
    >>> import pandas as pd
    >>> steps = Recording(pd.DataFrame({"kappa": np.tile([0.0, 0.2, -0.2], 20)}), "iso", "points.csv")
    >>> is_course(steps, slice(0, 60))
    False
    """
    if segment.stop - segment.start < _MINIMUM_ROWS or clock_step(recording, segment) > _WINDOW / 4.0:
        return False
    for name in MOVED:
        if name in recording.table:
            values = recording.table[name].to_numpy(dtype=np.float64)
            # From row to row a course goes on but for noise; points jump in every other row or more often.
            far = np.abs(np.diff(values[segment])) > 3.0 * level_tolerance(values, name)
            if far.mean() > 0.1:
                return False
    return True


@dataclass(frozen=True)
class _Input:
    """One input of a recording, with the levels at which it was held (none where it was swept)."""

    name: str
    values: NDArray[np.float64]
    held: NDArray[np.float64]
    tolerance: float


@dataclass(frozen=True)
class _Course:
    """What an input did within a segment: rows in which it moves, those between two levels, jumps between rows."""

    moving: NDArray[np.bool_]
    off: NDArray[np.bool_]
    jumps: list[int]


def _inputs(recording: Recording) -> list[_Input]:
    # In one convention, so that rounding does not depend on the recording's.
    table = recording.with_signs("iso").table
    found = []
    for name in MOVED:
        if name in table:
            values = table[name].to_numpy(dtype=np.float64)
            tolerance = level_tolerance(values, name) or 1.0
            found.append(_Input(name, values, _kept_levels(values, tolerance), tolerance))
    return found


def _kept_levels(values: NDArray[np.float64], tolerance: float) -> NDArray[np.float64]:
    """Return the levels at which an input stayed for some rows each time.

    A sweep of few samples that goes back over its own steps has levels as well, one row at a time.
    """
    found = np.array(levels(values, tolerance=tolerance))
    if not len(found):
        return found
    distance = np.abs(values[:, None] - found)
    place = np.where(distance.min(axis=1) <= tolerance, distance.argmin(axis=1), -1)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(place)) + 1, [len(place)]])
    lengths, at = np.diff(edges), place[edges[:-1]]
    # By rows: how long a row's visit lasts, so that flicker at the tolerance's edge counts for little.
    stays = [lengths[at == k] @ lengths[at == k] / lengths[at == k].sum() for k in range(len(found))]
    return np.array([level for level, stay in zip(found, stays, strict=True) if stay >= _FEWEST_STAYED])


def _stretches(recording: Recording) -> list[tuple[slice, bool]]:
    """Return the segments, each with whether it is a course; neighbors that are none as one stretch."""
    found: list[tuple[slice, bool]] = []
    for segment in recording.segments():
        course = is_course(recording, segment)
        if found and not course and not found[-1][1]:
            found[-1] = (slice(found[-1][0].start, segment.stop), False)
        else:
            found.append((segment, course))
    return found


def _medians(columns: Mapping[str, NDArray[np.float64]], inputs: Sequence[_Input], rows: slice) -> dict[str, float]:
    return {each.name: float(np.median(columns[each.name][rows])) for each in inputs}


def _course(each: _Input, segment: slice, step: float) -> _Course:
    smooth = median_filter(each.values[segment], size=round(_SMOOTHED / step) | 1, mode="nearest")
    if not len(each.held):
        return _swept_course(smooth, each.tolerance, step)
    off, nearest = _off_level(smooth, each.held, each.tolerance)
    # A way that leads past a level does not stop there; nor does a sweep where it turns, though many rows lie there.
    turning = round(2.0 * _WINDOW / step)
    off = _closed(off, turning if each.name in SLIPS else round(_PASSED / step), ends=False)
    # A held channel that jumps from one row to the next leaves no row between its levels.
    changes = np.flatnonzero(np.diff(nearest)) + 1
    jumps = changes[~off[changes]].tolist()
    if each.name not in SLIPS:
        return _Course(off, off, jumps)
    return _Course(_closed(off, turning, ends=True), _links(off, nearest, round(_LONGEST_WAY / step)), jumps)


def _swept_course(smooth: NDArray[np.float64], tolerance: float, step: float) -> _Course:
    window = max(3, round(_WINDOW / step))
    covered = maximum_filter1d(smooth, window) - minimum_filter1d(smooth, window)
    # Short rests are the turning points of a sweep, its start and its end.
    moving = _closed(covered > 2.0 * tolerance, 2 * window, ends=True)
    return _Course(moving, np.zeros(len(smooth), dtype=np.bool_), [])


def _closed(rows: NDArray[np.bool_], longest: int, *, ends: bool) -> NDArray[np.bool_]:
    """Return the rows with rests shorter than that filled; those at the ends only if wanted."""
    edges = [0, *(np.flatnonzero(np.diff(rows)) + 1).tolist(), len(rows)]
    closed = rows.copy()
    for start, stop in pairwise(edges if rows.any() else ()):
        if stop - start < longest and (ends or 0 < start < stop < len(rows)):
            closed[start:stop] = True
    return closed


def _off_level(
    smooth: NDArray[np.float64], held: NDArray[np.float64], tolerance: float
) -> tuple[NDArray[np.bool_], NDArray[np.intp]]:
    """Return the rows on the way between two levels, and the nearest level of each row.

    A held load wanders by more than its tolerance while the slip is swept: being off alone is no transition.
    It is one where the nearest level changes, from leaving the old one to reaching the new one; and at a
    segment's ends, where no level is near at all.
    """
    distance = np.abs(smooth[:, None] - held)
    nearest = distance.argmin(axis=1)
    away = distance.min(axis=1) > tolerance
    off = np.zeros(len(smooth), dtype=np.bool_)
    for change in np.flatnonzero(np.diff(nearest)):
        start, stop = change, change + 1
        while start >= 0 and away[start]:
            start -= 1
        while stop < len(smooth) and away[stop]:
            stop += 1
        off[start + 1 : stop] = True
    spacing = np.diff(held).min() if len(held) > 1 else np.inf
    nowhere = distance.min(axis=1) > min(4.0 * tolerance, max(spacing, 2.0 * tolerance))
    return off | nowhere, nearest


def _links(off: NDArray[np.bool_], nearest: NDArray[np.intp], longest: int) -> NDArray[np.bool_]:
    """Return the rows of short ways from one level to another; a way back to the same one is a sweep."""
    edges = [0, *(np.flatnonzero(np.diff(off)) + 1).tolist(), len(off)]
    links = np.zeros(len(off), dtype=np.bool_)
    for start, stop in pairwise(edges):
        inside = off[start] and 0 < start < stop < len(off) and stop - start <= longest
        if inside and nearest[start - 1] != nearest[stop]:
            links[start:stop] = True
    return links


def _prolonged(rows: NDArray[np.bool_], by: int) -> NDArray[np.bool_]:
    """Return the rows, each stretch prolonged by so many."""
    prolonged = rows.copy()
    for stop in (np.flatnonzero(rows[:-1] & ~rows[1:]) + 1).tolist():
        prolonged[stop : stop + by] = True
    return prolonged


def clock_step(recording: Recording, segment: slice) -> float:
    """Return the usual step of the clock.

    Parameters
    ----------
    recording : Recording
    segment : slice

    Returns
    -------
    float, s
        That of 100 Hz where no clock was recorded.
    """
    if "t" not in recording.table or segment.stop - segment.start < 2:
        return _USUAL_STEP
    steps = np.diff(recording.table["t"].to_numpy(dtype=np.float64)[segment])
    forward = steps[steps > 0.0]
    return float(np.median(forward)) if len(forward) else _USUAL_STEP
