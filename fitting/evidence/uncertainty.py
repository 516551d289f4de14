"""How sure the fitted values are: intervals under time-correlated noise, and what the data leave open.

Rows of a slow sweep are not independent: what the fit misses at one row it misses at the next. A least-squares fit
with weights w of residuals with variance s^2 and correlation length tau has, to first order, the covariance
H^-1 (sum of tau s^2 w H_c) H^-1, where H = J^T W J is the sum of its parts H_c by recording and channel: the sandwich
of White (1980) with the long-run variance of Newey and West (1987) in its middle. Where a loss bounds what a residual
counts, s^2 is the variance of what it counts, and H is diminished by the mean slope of the loss (Huber). It takes J to
change more slowly than the noise, which holds on a bench. Conditions that a value lies on are not taken into account.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import pandas as pd
from threadpoolctl import threadpool_limits

from tirefmu.estimation.correlation import correlation_length

from ..problem.loss import LOSSES
from ..problem.weighted_residuals import Problem

FloatArray = npt.NDArray[np.float64]

#: Standard normal quantile of a two-sided 95 % interval.
QUANTILE = 1.959964
#: A direction whose standard deviation is more than one size of its coefficients (a quarter of their plausible range)
#: is one that the data leave open, and so is one with less than this share of the largest curvature.
LARGEST_SD, LEAST_CURVATURE = 1.0, 1e-13
#: A coefficient takes part in a direction, and is not determined by itself, from this share of a unit vector on.
LEAST_PART = 0.1


@dataclass(frozen=True)
class Direction:
    """Coefficients of which the data see only some combination.

    Attributes
    ----------
    coefficients : tuple of str
        Those that take part, the strongest first.
    sd : float
        Standard deviation along it, in the sizes of the coefficients; infinite where nothing holds it.
    """

    coefficients: tuple[str, ...]
    sd: float


@dataclass(frozen=True)
class Uncertainty:
    """What a fit knows of its values.

    Attributes
    ----------
    intervals : dict of str to float
        Half the width of the 95 % interval of each free coefficient; infinite where it is not determined by itself.
    directions : tuple of Direction
        What the data leave open.
    effective_rows : ndarray, shape (n_groups, n_forces)
        How many independent rows the rows of each recording's channel are worth; 0 where there are none.
    covariance : pandas.DataFrame
        Of the free coefficients by name, in their units; NaN in the rows and columns of those without a finite
        interval. Half an interval is `QUANTILE` times the root of the diagonal.
    """

    intervals: dict[str, float]
    directions: tuple[Direction, ...]
    effective_rows: FloatArray
    covariance: pd.DataFrame


def across_stages(covariance: pd.DataFrame) -> pd.DataFrame:
    """Return a covariance in which coefficients of different stages are independent.

    A stage takes the coefficients of earlier stages as known, so nothing is estimated between them.

    Parameters
    ----------
    covariance : pandas.DataFrame
        Blocks along the diagonal, NaN elsewhere.

    Returns
    -------
    pandas.DataFrame
        0 between coefficients that have a variance.

    Examples
    --------
    >>> blocks = pd.DataFrame([[4.0, np.nan, np.nan], [np.nan, 1.0, np.nan], [np.nan] * 3])
    >>> across_stages(blocks).to_numpy().tolist()
    [[4.0, 0.0, nan], [0.0, 1.0, nan], [nan, nan, nan]]
    """
    known = np.isfinite(np.diag(covariance))
    return covariance.mask(covariance.isna() & np.outer(known, known), 0.0)


def uncertainty(problem: Problem, x: FloatArray, fixed: Sequence[str] = ()) -> Uncertainty:
    """Return intervals and open directions at the end of a fit.

    Parameters
    ----------
    problem : Problem
        With the weights of the fit.
    x : ndarray, shape (n_free,)
        Scaled free values at the end.
    fixed : sequence of str
        Coefficients on a bound, which the others take as known; they have no interval.

    Returns
    -------
    Uncertainty
    """
    # A hundred coefficients are no work to share: BLAS threads would spend their time waiting.
    with threadpool_limits(limits=1, user_api="blas"):
        return _uncertainty(problem, x, fixed)


def _uncertainty(problem: Problem, x: FloatArray, fixed: Sequence[str]) -> Uncertainty:
    curvature, middle, effective = _sandwich(problem, x)
    names = [name for name in problem.free if name not in fixed]
    unfixed = np.array([i for i, name in enumerate(problem.free) if name not in fixed], dtype=int)
    if not unfixed.size:
        return Uncertainty({}, (), effective, pd.DataFrame(dtype=np.float64))
    values, vectors = np.linalg.eigh(curvature[np.ix_(unfixed, unfixed)])
    identified = values > LEAST_CURVATURE * max(float(values[-1]), 0.0)
    inverse = np.where(identified, 1.0 / np.where(identified, values, 1.0), 0.0)
    # In the directions of the eigenvectors: what the noise makes of each, together with the others.
    spread = vectors.T @ middle[np.ix_(unfixed, unfixed)] @ vectors * np.outer(inverse, inverse)
    along = np.where(identified, np.sqrt(np.maximum(np.diag(spread), 0.0)), np.inf)
    unidentified = ~(along <= LARGEST_SD)
    directions = tuple(
        Direction(_members(vectors[:, k], names), float(along[k])) for k in np.flatnonzero(unidentified)
    )  # from the least determined on, as the eigenvalues come
    # An open direction reaches as far as is plausible, one size, and takes along what has a small part in it.
    spread[unidentified, :] = spread[:, unidentified] = 0.0
    spread[unidentified, unidentified] = LARGEST_SD**2
    variance = np.einsum("ik,kl,il->i", vectors, spread, vectors)
    undetermined = np.sum(vectors[:, unidentified] ** 2, axis=1) > LEAST_PART
    scale = problem.scale[unfixed]
    half = np.where(undetermined, np.inf, QUANTILE * np.sqrt(np.maximum(variance, 0.0)) * scale)
    covariance = vectors @ spread @ vectors.T * np.outer(scale, scale)
    np.fill_diagonal(covariance, np.maximum(variance, 0.0) * scale**2)
    covariance[undetermined, :] = covariance[:, undetermined] = np.nan
    named = pd.DataFrame(covariance, index=names, columns=names)
    return Uncertainty(dict(zip(names, half.tolist(), strict=True)), directions, effective, named)


def _sandwich(problem: Problem, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return H, the middle of the sandwich and the effective rows by recording and channel."""
    n = len(problem.free)
    curvature, middle, effective = np.zeros((n, n)), np.zeros((n, n)), np.zeros_like(problem.weights)
    for group in np.flatnonzero((problem.weights > 0).any(axis=1)):
        rows = problem.rows.take(np.flatnonzero(problem.rows.group == group))
        # The Jacobian of all rows: how much of them the loss leaves is the same everywhere but for chance.
        part = replace(problem, rows=rows, loss=LOSSES["squares"], limits=None)
        residual, present = part.residual(x), np.isfinite(rows.measured.T)
        squared_weights = _squared_weights(part, x)
        for channel, free, _, squares in part.by_output(x):
            own, slope = residual[channel, present[channel]], 1.0
            if problem.limits is not None:
                over = np.abs(own) / problem.limits[group, channel]
                own, slope = own * problem.loss.weight(over), float(np.mean(problem.loss.slope(over)))
            length, variance = correlation_length(own, rows.segment[present[channel]]), float(np.mean(own**2))
            effective[group, channel] = len(own) / length
            curvature[np.ix_(free, free)] += slope * squares
            noise = length * variance * problem.weights[group, channel]
            middle[np.ix_(free, free)] += noise * squared_weights.get(channel, squares)
    return curvature, middle, effective


def _squared_weights(part: Problem, x: FloatArray) -> dict[int, FloatArray]:
    """Return J^T W J of each output with the square of each row's own weight; nothing where every row counts alike."""
    if (part.rows.weight == 1.0).all():
        return {}
    squared = replace(part, rows=replace(part.rows, weight=part.rows.weight**2))
    return {output: squares for output, _, _, squares in squared.by_output(x)}


def _members(vector: FloatArray, names: Sequence[str]) -> tuple[str, ...]:
    order = np.argsort(-np.abs(vector), kind="stable")
    return tuple(names[i] for i in order if vector[i] ** 2 > LEAST_PART)
