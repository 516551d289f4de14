"""Groups of rows by operating condition, and weights that compensate for conditions with more rows than others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...numerics.arrays import BoolArray, FloatArray, IndexArray
from ...symbolic.channels import CONTROLLED_INPUTS
from ..recording import Recording, once
from ..thresholds import OVERSAMPLED
from .levels import level_tolerance, levels
from .phases import Phase, phases

_Key = tuple[tuple[str, ...], tuple[tuple[str, float], ...]]


@dataclass(frozen=True, eq=False)
class Grouping:
    """The rows of a recording by operating condition.

    Parameters
    ----------
    labels : ndarray of int, shape (n,)
        Index of the condition of each row.
    conditions : tuple of tuple of (str, float)
        For each condition, the held inputs and their levels, in SI units.
    moving : tuple of tuple of str, optional
        For each condition, the swept inputs. Default none.
    extent : ndarray, shape (n_conditions,), optional
        For each condition, the swept range, in any unit. Default 1.
    """

    labels: IndexArray
    conditions: tuple[tuple[tuple[str, float], ...], ...]
    moving: tuple[tuple[str, ...], ...] = ()
    extent: FloatArray = field(default_factory=lambda: np.empty(0))

    @property
    def counts(self) -> IndexArray:
        """The number of rows of each condition."""
        return np.bincount(self.labels, minlength=len(self.conditions)).astype(np.intp)

    def weights(self, rows: BoolArray | None = None) -> FloatArray:
        """Return row weights that limit the total weight of each condition.

        The measure is the number of rows per swept range: it is large for repeated and for slow sweeps, but not for
        wide ones. A condition that exceeds the (lower) median of the conditions with the same swept inputs is weighted
        down to the median. Conditions with fewer rows are not weighted up, because their rows contain no additional
        information.

        Parameters
        ----------
        rows : ndarray of bool, shape (n,), optional
            The rows to weight. All others have weight 0. Default all.

        Returns
        -------
        ndarray, shape (n,)
            With mean 1 over the selected rows.

        Examples
        --------
        >>> Grouping(np.array([0, 0, 0, 1]), ((), ())).weights().round(3).tolist()
        [0.667, 0.667, 0.667, 2.0]
        """
        selected = np.ones(len(self.labels), dtype=np.bool_) if rows is None else rows
        if not selected.any():
            return np.zeros(len(self.labels))
        counts = np.bincount(self.labels[selected], minlength=len(self.conditions))
        extent = self.extent if len(self.extent) else np.ones(len(self.conditions))
        factor = _factors(counts, extent, self.moving or ((),) * len(self.conditions))
        weights = np.where(selected, factor[self.labels], 0.0)
        return np.asarray(weights / weights[selected].mean())


def _factors(counts: IndexArray, extent: FloatArray, kinds: Sequence[tuple[str, ...]]) -> FloatArray:
    """Return the weight of a row of each condition: 1, or less where there are more rows than in those of its kind."""
    density, factor = counts / extent, np.ones(len(counts))
    for kind in set(kinds):
        same_kind = np.array([other == kind for other in kinds]) & (counts > 0)
        if same_kind.any():
            median = float(np.quantile(density[same_kind], 0.5, method="lower"))
            oversampled = same_kind & (density > OVERSAMPLED * median)
            factor[oversampled] = median / density[oversampled]
    return factor


@once
def group_by_condition(recording: Recording, *, most_levels: int | None = None) -> Grouping:
    """Return the rows of a recording by the swept inputs and the levels of the held inputs.

    A phase of a time series (`phases`) belongs to one condition. Steady points are grouped by the nearest level of each
    input that has levels. If another input has none, repeated points cannot be recognized.

    Parameters
    ----------
    recording : Recording
        In any signs.
    most_levels : int, optional
        An input with more levels does not define conditions: it was swept in steps.

    Returns
    -------
    Grouping
        Condition of each row, and the swept inputs of each condition.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"Fz": [900.0] * 500 + [1800.0] * 300, "alpha": np.linspace(-0.2, 0.2, 800)})
    >>> groups = group_by_condition(Recording(rows, "iso", "a.csv"))
    >>> groups.conditions, groups.moving, groups.counts.tolist()
    (((('Fz', 900.0),), (('Fz', 1800.0),)), (('alpha',), ('alpha',)), [500, 300])
    """
    most = np.inf if most_levels is None else most_levels
    series = [phase for phase in phases(recording) if phase.kind != "points"]
    held = {name: _levels_of(series, recording, name) for name in CONTROLLED_INPUTS if name in recording.table}
    held = {name: values for name, values in held.items() if 0 < len(values) <= most}
    labels = np.full(len(recording), -1, dtype=np.intp)
    numbers: dict[_Key, int] = {}
    for phase in series:
        at = {name: values[np.abs(values - phase.held[name]).argmin()] for name, values in held.items()
              if name in phase.held}  # fmt: skip
        moving = tuple(name for name in phase.moving if name in held or most_levels is None)
        key = moving, tuple((name, float(level)) for name, level in at.items())
        labels[phase.rows] = numbers.setdefault(key, len(numbers))
    keys = list(numbers)
    extent = _extents(recording, labels, keys)
    points = labels < 0
    if points.any():
        point_labels, conditions, complete = _points(recording, points, most)
        labels[points] = point_labels + len(keys)
        keys += [(("points",), condition) for condition in conditions]
        extent = np.append(extent, np.ones(len(conditions)) if complete else np.bincount(point_labels))
    return Grouping(labels, tuple(condition for _, condition in keys), tuple(moving for moving, _ in keys), extent)


def _levels_of(series: Sequence[Phase], recording: Recording, name: str) -> FloatArray:
    """Return the levels of an input: the medians over the phases that held it, merged where they are close."""
    medians = np.sort([phase.held[name] for phase in series if name in phase.held])
    tolerance = level_tolerance(recording.table[name], name) or 1.0
    groups = np.split(medians, np.flatnonzero(np.diff(medians) > tolerance) + 1)
    return np.array([float(np.median(group)) for group in groups if len(group)])


def _extents(recording: Recording, labels: IndexArray, keys: Sequence[_Key]) -> FloatArray:
    """Return the swept range of each condition in level tolerances, at least 1."""
    columns = {name: recording.table[name].to_numpy(dtype=np.float64) for name in {n for m, _ in keys for n in m}}
    tolerances = {name: level_tolerance(values, name) or 1.0 for name, values in columns.items()}
    order = np.argsort(labels, kind="stable")
    starts = np.searchsorted(labels[order], np.arange(len(keys) + 1))
    extents = []
    for (moving, _), start, stop in zip(keys, starts[:-1], starts[1:], strict=True):
        ranges = [np.ptp(columns[name][order[start:stop]]) / tolerances[name] for name in moving]
        extents.append(max([1.0, *ranges]))
    return np.array(extents)


def _points(
    recording: Recording, rows: BoolArray, most: float
) -> tuple[IndexArray, list[tuple[tuple[str, float], ...]], bool]:
    """Return labels and conditions of steady points, and whether every input has levels."""
    numbers = np.zeros(int(rows.sum()), dtype=np.intp)
    held: list[tuple[str, FloatArray]] = []
    complete = True
    for name in (name for name in CONTROLLED_INPUTS if name in recording.table):
        values = recording.table[name].to_numpy(dtype=np.float64)[rows]
        steps = np.array(levels(values, tolerance=level_tolerance(recording.table[name], name) or 1.0))
        if len(steps) and len(steps) <= most:
            numbers = numbers * len(steps) + np.searchsorted(0.5 * (steps[1:] + steps[:-1]), values)
            held.append((name, steps))
        complete = complete and len(steps) > 0
    present, labels = np.unique(numbers, return_inverse=True)
    shape = tuple(len(steps) for _, steps in held)
    conditions = []
    for number in present.tolist():
        at = np.unravel_index(number, shape) if shape else ()
        conditions.append(tuple((name, float(steps[k])) for (name, steps), k in zip(held, at, strict=True)))
    return labels.astype(np.intp), conditions, complete
