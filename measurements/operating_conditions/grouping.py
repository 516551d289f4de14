"""How much rows count: conditions that were logged more often than others, and rows that repeat their neighbors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tirefmu.symbolic.errors import DataError

from ..recording import Recording
from .levels import level_tolerance, levels
from .phases import MOVED, Phase, phases

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
    tolerance = level_tolerance(recording.table[name], name) or 1.0
    parts = np.split(medians, np.flatnonzero(np.diff(medians) > tolerance) + 1)
    return np.array([float(np.median(part)) for part in parts if len(part)])


def _extents(recording: Recording, labels: NDArray[np.intp], keys: Sequence[_Key]) -> NDArray[np.float64]:
    """Return over how many tolerances the swept inputs of each condition went; 1 for what was held."""
    extents = []
    for number, (moving, _) in enumerate(keys):
        rows = np.flatnonzero(labels == number)
        ranges = [
            np.ptp(recording.table[name].to_numpy(dtype=np.float64)[rows])
            / (level_tolerance(recording.table[name], name) or 1.0)
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
        found = np.array(levels(values, tolerance=level_tolerance(recording.table[name], name) or 1.0))
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


def correlation_length(residuals: ArrayLike, segments: Sequence[slice] | None = None) -> float:
    """Return after how many rows a residual starts anew: the integrated autocorrelation time.

    1 + 2 sum rho_k over lags k, cut where the sum of two neighbors is no longer positive (the initial
    positive sequence of Geyer, 1992). Residuals are taken about 0, where a right model has them, not about
    their mean: an error that stays for a whole sweep correlates over all of it. Pairs never span segments.

    Parameters
    ----------
    residuals : array_like, shape (n,)
        NaN where nothing was measured.
    segments : sequence of slice, optional
        `Recording.segments`; default one.

    Returns
    -------
    float
        In rows, at least 1.

    Raises
    ------
    DataError
        If no residual is finite.

    Examples
    --------
    >>> correlation_length(np.repeat([1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, -1.0], 10)) > 5.0
    True
    >>> correlation_length([0.0, 0.0])
    1.0
    """
    values = np.asarray(residuals, dtype=np.float64)
    if not np.isfinite(values).any():
        raise DataError("no residual is finite: there is no correlation to tell")
    products, pairs = _lagged(values, segments or [slice(0, len(values))])
    if products[0] <= 0.0:
        return 1.0
    rho = np.where(pairs > 0, products / np.maximum(pairs, 1.0), 0.0) / (products[0] / pairs[0])
    couples = rho[: len(rho) // 2 * 2].reshape(-1, 2).sum(axis=1)
    # Few pairs make a noisy sum; the sequence has to fall as well (Geyer's monotone one).
    ends = np.flatnonzero(couples <= 0.0)
    kept = np.minimum.accumulate(couples[: ends[0] if len(ends) else len(couples)])
    return max(1.0, float(2.0 * kept.sum() - 1.0))


def effective_sample_size(residuals: ArrayLike, segments: Sequence[slice] | None = None) -> float:
    """Return how many independent rows a recording is worth.

    Parameters
    ----------
    residuals : array_like, shape (n,)
        Measured minus model; NaN where nothing was measured.
    segments : sequence of slice, optional
        `Recording.segments`; default one.

    Returns
    -------
    float
        The number of finite residuals over their `correlation_length`.

    Raises
    ------
    DataError
        If no residual is finite.

    Examples
    --------
    >>> noise = np.random.default_rng(0).standard_normal(2000)
    >>> bool(effective_sample_size(noise) > 1700.0), bool(effective_sample_size(np.repeat(noise, 8)) < 2300.0)
    (True, True)
    """
    values = np.asarray(residuals, dtype=np.float64)
    return float(np.isfinite(values).sum() / correlation_length(values, segments))


def _lagged(values: NDArray[np.float64], segments: Sequence[slice]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return sums of products r_i r_(i+k), and the number of pairs, for each lag k; by fast transforms."""
    longest = max(segment.stop - segment.start for segment in segments)
    products, pairs = np.zeros(longest), np.zeros(longest)
    for segment in segments:
        known = np.isfinite(values[segment])
        length = len(known)
        if length:
            products[:length] += _autocorrelation(np.where(known, values[segment], 0.0))
            pairs[:length] += np.round(_autocorrelation(known.astype(np.float64)))
    return products, pairs


def _autocorrelation(values: NDArray[np.float64]) -> NDArray[np.float64]:
    size = 2 ** int(np.ceil(np.log2(2 * len(values))))
    spectrum = np.fft.rfft(values, size)
    return np.asarray(np.fft.irfft(spectrum * np.conj(spectrum), size)[: len(values)])
