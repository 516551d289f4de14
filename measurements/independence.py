"""How much rows count: conditions that were logged more often than others, and rows that repeat their neighbors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tirefmu.symbolic.errors import DataError

from .conditions import levels
from .phases import MOVED
from .recording import Recording

_RAREST = 0.2  # of the usual number of rows: a condition met in passing is not blown up further


@dataclass(frozen=True, eq=False)
class Grouping:
    """The rows of a recording by the condition under which they were logged.

    Parameters
    ----------
    labels : ndarray of int, shape (n,)
        The condition of each row.
    conditions : tuple of tuple of (str, float)
        Of each condition, the inputs that were held with their levels, in SI.
    """

    labels: NDArray[np.intp]
    conditions: tuple[tuple[tuple[str, float], ...], ...]

    @property
    def counts(self) -> NDArray[np.intp]:
        """The number of rows of each condition."""
        return np.bincount(self.labels, minlength=len(self.conditions)).astype(np.intp)

    def weights(self, rows: NDArray[np.bool_] | None = None) -> NDArray[np.float64]:
        """Return weights under which every condition counts the same, however often it was logged.

        Parameters
        ----------
        rows : ndarray of bool, shape (n,), optional
            The rows that count; the others weigh 0. Default all.

        Returns
        -------
        ndarray, shape (n,)
            Mean 1 over the rows that count. A condition with less than a fifth of the usual (median) number
            of rows counts less than the others: it was met in passing.

        Examples
        --------
        >>> Grouping(np.array([0, 0, 0, 1]), ((), ())).weights().round(3).tolist()
        [0.667, 0.667, 0.667, 2.0]
        """
        counted = np.ones(len(self.labels), dtype=np.bool_) if rows is None else rows
        found = np.bincount(self.labels[counted], minlength=len(self.conditions))
        if not found.any():
            return np.zeros(len(self.labels))
        share = 1.0 / np.maximum(found, _RAREST * np.median(found[found > 0]))
        weights = np.where(counted, share[self.labels], 0.0)
        return np.asarray(weights / weights[counted].mean())


def group_by_condition(recording: Recording) -> Grouping:
    """Return the rows of a recording by the levels at which its inputs were held.

    Each row belongs to the nearest level of each input that has levels; an input that was swept (`levels`
    finds none) does not count.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    Grouping

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"Fz": [900.0] * 500 + [1800.0] * 300, "alpha": np.linspace(-0.2, 0.2, 800)})
    >>> groups = group_by_condition(Recording(rows, "iso", "a.csv"))
    >>> groups.conditions, groups.counts.tolist()
    (((('Fz', 900.0),), (('Fz', 1800.0),)), [500, 300])
    """
    numbers = np.zeros(len(recording), dtype=np.intp)
    held: list[tuple[str, NDArray[np.float64]]] = []
    for name in MOVED:
        found = np.array(levels(recording.table[name])) if name in recording.table else np.empty(0)
        if len(found):
            middles = 0.5 * (found[1:] + found[:-1])
            values = recording.table[name].to_numpy(dtype=np.float64)
            numbers = numbers * len(found) + np.searchsorted(middles, values)
            held.append((name, found))
    present, labels = np.unique(numbers, return_inverse=True)
    shape = tuple(len(found) for _, found in held)
    conditions = []
    for number in present.tolist():
        at = np.unravel_index(number, shape) if shape else ()
        conditions.append(tuple((name, float(found[k])) for (name, found), k in zip(held, at, strict=True)))
    return Grouping(labels.astype(np.intp), tuple(conditions))


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
