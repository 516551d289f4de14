"""Weights of rows by operating condition: conditions that were logged more often than others do not count more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .conditions import levels, usual_tolerance
from .phases import MOVED, Phase, phases
from .recording import Recording

_ALIKE = 1.25  # times the usual: neighbors of a sweep scatter by less, what repeats has twice as much
_Key = tuple[tuple[str, ...], tuple[tuple[str, float], ...]]


@dataclass(frozen=True, eq=False)
class Grouping:
    """The rows of a recording by the condition under which they were logged.

    Parameters
    ----------
    labels : ndarray of int, shape (n,)
        The condition of each row.
    conditions : tuple of tuple of (str, float)
        Of each condition, the inputs that were held with their levels, in SI.
    moving : tuple of tuple of str, optional
        Of each condition, the inputs that were swept; none where nobody says.
    extent : ndarray, shape (n_conditions,), optional
        Over how much of its range each was swept, in any unit; 1 where nobody says.
    """

    labels: NDArray[np.intp]
    conditions: tuple[tuple[tuple[str, float], ...], ...]
    moving: tuple[tuple[str, ...], ...] = ()
    extent: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))

    @property
    def counts(self) -> NDArray[np.intp]:
        """The number of rows of each condition."""
        return np.bincount(self.labels, minlength=len(self.conditions)).astype(np.intp)

    def weights(self, rows: NDArray[np.bool_] | None = None) -> NDArray[np.float64]:
        """Return weights under which no condition counts for more than the usual one, however often it was logged.

        What counts is rows per swept range, so that a repeated sweep and a slow one have many and a wide one has
        not. The usual one is the (lower) median of the conditions that sweep the same inputs. Fewer rows than usual
        are not blown up: they know no more for it.

        Parameters
        ----------
        rows : ndarray of bool, shape (n,), optional
            The rows that count; the others weigh 0. Default all.

        Returns
        -------
        ndarray, shape (n,)
            Mean 1 over the rows that count.

        Examples
        --------
        >>> Grouping(np.array([0, 0, 0, 1]), ((), ())).weights().round(3).tolist()
        [0.667, 0.667, 0.667, 2.0]
        """
        counted = np.ones(len(self.labels), dtype=np.bool_) if rows is None else rows
        if not counted.any():
            return np.zeros(len(self.labels))
        found = np.bincount(self.labels[counted], minlength=len(self.conditions))
        dose = found / (self.extent if len(self.extent) else 1.0)
        kinds = self.moving or ((),) * len(self.conditions)
        share = np.ones(len(self.conditions))
        for kind in set(kinds):
            alike = np.array([each == kind for each in kinds]) & (found > 0)
            if alike.any():
                usual = float(np.quantile(dose[alike], 0.5, method="lower"))
                more = alike & (dose > _ALIKE * usual)
                share[more] = usual / dose[more]
        weights = np.where(counted, share[self.labels], 0.0)
        return np.asarray(weights / weights[counted].mean())


def group_by_condition(recording: Recording, *, most_levels: int | None = None) -> Grouping:
    """Return the rows of a recording by what was swept and the levels at which the other inputs were held.

    A stretch that is a course in time (`phases`) is one condition or part of one. Rows that are none are grouped by
    the nearest level of each input that has levels; where another input has none, nothing tells which of them repeat.

    Parameters
    ----------
    recording : Recording
    most_levels : int, optional
        An input that was held at more levels than these parts no conditions: it was swept in steps.

    Returns
    -------
    Grouping

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"Fz": [900.0] * 500 + [1800.0] * 300, "alpha": np.linspace(-0.2, 0.2, 800)})
    >>> groups = group_by_condition(Recording(rows, "iso", "a.csv"))
    >>> groups.conditions, groups.moving, groups.counts.tolist()
    (((('Fz', 900.0),), (('Fz', 1800.0),)), (('alpha',), ('alpha',)), [500, 300])
    """
    most = np.inf if most_levels is None else most_levels
    courses = [phase for phase in phases(recording) if phase.kind != "points"]
    held = {name: _levels_of(courses, recording, name) for name in MOVED if name in recording.table}
    held = {name: found for name, found in held.items() if 0 < len(found) <= most}
    labels = np.full(len(recording), -1, dtype=np.intp)
    numbers: dict[_Key, int] = {}
    for phase in courses:
        parts = {name: found[np.abs(found - phase.held[name]).argmin()] for name, found in held.items()
                 if name in phase.held}  # fmt: skip
        moving = tuple(name for name in phase.moving if name in held or most_levels is None)
        key = moving, tuple((name, float(level)) for name, level in parts.items())
        labels[phase.rows] = numbers.setdefault(key, len(numbers))
    keys = list(numbers)
    extent = _extents(recording, labels, keys)
    points = labels < 0
    if points.any():
        own, conditions, told = _points(recording, points, most)
        labels[points] = own + len(keys)
        keys += [(("points",), condition) for condition in conditions]
        extent = np.append(extent, np.ones(len(conditions)) if told else np.bincount(own))
    return Grouping(labels, tuple(condition for _, condition in keys), tuple(moving for moving, _ in keys), extent)


def _levels_of(courses: Sequence[Phase], recording: Recording, name: str) -> NDArray[np.float64]:
    """Return the levels at which an input was held in some stretches: their medians, those that lie close as one."""
    medians = np.sort([phase.held[name] for phase in courses if name in phase.held])
    tolerance = usual_tolerance(recording.table[name], name) or 1.0
    parts = np.split(medians, np.flatnonzero(np.diff(medians) > tolerance) + 1)
    return np.array([float(np.median(part)) for part in parts if len(part)])


def _extents(recording: Recording, labels: NDArray[np.intp], keys: Sequence[_Key]) -> NDArray[np.float64]:
    """Return over how many tolerances the swept inputs of each condition went; 1 for what was held."""
    extents = []
    for number, (moving, _) in enumerate(keys):
        rows = np.flatnonzero(labels == number)
        ranges = [
            np.ptp(recording.table[name].to_numpy(dtype=np.float64)[rows])
            / (usual_tolerance(recording.table[name], name) or 1.0)
            for name in moving
        ]
        extents.append(max([1.0, *ranges]))
    return np.array(extents)


def _points(
    recording: Recording, rows: NDArray[np.bool_], most: float
) -> tuple[NDArray[np.intp], list[tuple[tuple[str, float], ...]], bool]:
    """Return labels and conditions of rows that are no course, and whether every input that varies has levels."""
    numbers = np.zeros(int(rows.sum()), dtype=np.intp)
    held: list[tuple[str, NDArray[np.float64]]] = []
    told = True
    for name in (name for name in MOVED if name in recording.table):
        values = recording.table[name].to_numpy(dtype=np.float64)[rows]
        found = np.array(levels(values, tolerance=usual_tolerance(recording.table[name], name) or 1.0))
        if len(found) and len(found) <= most:
            numbers = numbers * len(found) + np.searchsorted(0.5 * (found[1:] + found[:-1]), values)
            held.append((name, found))
        told = told and len(found) > 0
    present, labels = np.unique(numbers, return_inverse=True)
    shape = tuple(len(found) for _, found in held)
    conditions = []
    for number in present.tolist():
        at = np.unravel_index(number, shape) if shape else ()
        conditions.append(tuple((name, float(found[k])) for (name, found), k in zip(held, at, strict=True)))
    return labels.astype(np.intp), conditions, told
