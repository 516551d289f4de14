"""Uncertainty of the fitted values: intervals under time-correlated noise, and directions that are not identifiable.

Rows of a sweep are not independent: residuals of neighboring rows are correlated. A least-squares fit with weights W of
residuals with variance s^2 and correlation matrix R has, to first order, the covariance

    H^-1 (sum of s^2 J^T W R W J) H^-1,

where H = J^T W J, and the sum is over recordings and channels. This is the sandwich estimator of White (1980) for
correlated residuals (Newey and West, 1987). R is described in `correlated_noise`. For a robust loss, s^2 is the
variance of the weighted residual, and the mean slope of the loss reduces H (Huber). Active constraints are not taken
into account. Slopes at zero slip that are fitted as targets
are combinations of the same residuals and are no further information.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from ...numerics.arrays import BoolArray, FloatArray, IntArray
from ...numerics.correlation import correlation_length
from ...numerics.one_thread import one_blas_thread
from ...numerics.ties import graded
from ..problem.loss import LOSSES
from ..problem.weighted_residuals import Problem
from .correlated_noise import CorrelatedSums, NoiseCorrelation
from .discrepancy import Discrepancy, discrepancies
from .sample import samples_of
from .sensor_errors import sensor_errors

#: Standard normal quantile of a two-sided 95 % interval.
QUANTILE = 1.959964
#: A direction is not identifiable if its standard deviation exceeds one typical size of its coefficients (a quarter of
#: their plausible range), or if its curvature is less than this share of the largest curvature.
LARGEST_SD, MIN_CURVATURE = 1.0, 1e-13
#: Least squared component of a coefficient that belongs to a direction.
MIN_PART = 0.1
#: Rows of the Jacobian at a time: they stay in the processor's cache. With a multiple of 64 the derivatives of a row
#: would share a few lines of it.
CHUNK = 2040


@dataclass(frozen=True)
class Direction:
    """A combination of coefficients that is not identifiable.

    - `coefficients`: the coefficients of the direction, the largest component first.
    - `sd`: standard deviation along it, in the sizes of the coefficients; infinite without any information.
    """

    coefficients: tuple[str, ...]
    sd: float


@dataclass(frozen=True)
class Covariance:
    """A covariance of coefficients."""

    coefficients: list[str]
    matrix: list[list[float]]


@dataclass(frozen=True)
class Uncertainty:
    """Uncertainty of the values of a fit.

    - `intervals`: half the width of the 95 % interval of each free coefficient; infinite if it is not identifiable.
    - `directions`: directions that are not identifiable.
    - `effective_rows`, shape (n_groups, n_forces): effective sample size of each channel of a recording; 0 without
      rows.
    - `covariance`: of the free coefficients by name, in their units; NaN in the rows and columns of those without a
      finite interval. Half an interval is `QUANTILE` times the root of the diagonal.
    - `complete`: the same for predictions, without NaN: a direction that is not identifiable has the plausible
      deviation of one size.
    - `discrepancies`: errors of the form of the model by channel, always in adapted SAE; covariance and intervals
      contain them.
    """

    intervals: dict[str, float] = field(default_factory=dict)
    directions: tuple[Direction, ...] = ()
    effective_rows: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    covariance: pd.DataFrame = field(default_factory=lambda: pd.DataFrame(dtype=np.float64))
    complete: pd.DataFrame = field(default_factory=lambda: pd.DataFrame(dtype=np.float64))
    discrepancies: tuple[Discrepancy, ...] = ()

    @property
    def determined(self) -> Covariance:
        """Covariance of the coefficients with a finite interval."""
        names = list(self.covariance.index[np.isfinite(np.diag(self.covariance))]) if len(self.covariance) else []
        return Covariance(names, self.covariance.loc[names, names].to_numpy().tolist())

    def mirrored(self, flips: FloatArray) -> Uncertainty:
        """Return the same in another sign convention, with the changes of sign of the covariance, shape (n, n)."""
        return replace(self, covariance=self.covariance * flips, complete=self.complete * flips)


def across_stages(covariance: pd.DataFrame) -> pd.DataFrame:
    """Return a covariance in which coefficients of different stages are independent.

    A stage assumes that the coefficients of earlier stages are known.

    `covariance`: diagonal blocks, NaN elsewhere. Returns: 0 between coefficients that have a variance.

    >>> blocks = pd.DataFrame([[4.0, np.nan, np.nan], [np.nan, 1.0, np.nan], [np.nan] * 3])
    >>> across_stages(blocks).to_numpy().tolist()
    [[4.0, 0.0, nan], [0.0, 1.0, nan], [nan, nan, nan]]
    """
    estimated = np.isfinite(np.diag(covariance))
    return covariance.mask(covariance.isna() & np.outer(estimated, estimated), 0.0)


def uncertainty_of_stages(
    ends: Sequence[tuple[str, Problem, FloatArray]],
    last_stage: Mapping[str, str],
    at_bound: Collection[str],
    shape: tuple[int, int],
    sensors: bool,
) -> Uncertainty:
    """Return the uncertainty of a fit in stages: each value is that of the last stage that freed the coefficient.

    `ends`: name, problem and solution of each stage, in order. `last_stage`: the last stage that freed each fitted
    coefficient. `shape`: number of recordings and of outputs; the effective sample size is NaN if one is not fitted.
    `sensors`: see `uncertainty`. The discrepancies are those of each stage, for the coefficients whose last stage it
    is; `complete` is 0 where nothing is known. See `across_stages`.
    """
    names = list(last_stage)
    intervals: dict[str, float] = {}
    directions: tuple[Direction, ...] = ()
    covariance = pd.DataFrame(np.nan, index=names, columns=names)
    complete = pd.DataFrame(0.0, index=names, columns=names)
    effective = np.full(shape, np.nan)
    discrepant: list[Discrepancy] = []
    for stage, problem, x in ends:
        last = {name for name in problem.free if last_stage[name] == stage}
        if not last:
            continue
        earlier = uncertainty(problem, x, [name for name in problem.free if name in at_bound], sensors=sensors)
        intervals.update({name: half for name, half in earlier.intervals.items() if name in last})
        block = [name for name in earlier.covariance.index if name in last]
        covariance.loc[block, block] = earlier.covariance.loc[block, block]
        complete.loc[block, block] = earlier.complete.loc[block, block]
        new = {discrepancy.channel for discrepancy in earlier.discrepancies}
        discrepant = [
            replace(discrepancy, final=discrepancy.final and discrepancy.channel not in new)
            for discrepancy in discrepant
        ]
        discrepant += [discrepancy.of(last) for discrepancy in earlier.discrepancies]
        directions += tuple(d for d in earlier.directions if last.intersection(d.coefficients))
        rows = effective[: len(earlier.effective_rows)]
        rows[earlier.effective_rows > 0] = earlier.effective_rows[earlier.effective_rows > 0]
    return Uncertainty(intervals, directions, effective, across_stages(covariance), complete, tuple(discrepant))


def uncertainty(problem: Problem, x: FloatArray, fixed: Sequence[str] = (), *, sensors: bool = False) -> Uncertainty:
    """Return intervals, and directions that are not identifiable, at the solution of a fit.

    `problem`: with the weights of the fit. `x`, shape (n_free,): scaled free values of the solution. `fixed`:
    coefficients at a bound. They are treated as known and have no interval, unless the data do not determine them
    without the bound: then they are not known, nor are coefficients that trade off with them. `sensors`: whether slow
    errors of the sensors are possible.
    """
    with one_blas_thread():
        return _uncertainty(problem, x, fixed, sensors)


def _uncertainty(problem: Problem, x: FloatArray, fixed: Sequence[str], sensors: bool) -> Uncertainty:
    curvature, middle, effective = sandwich(problem, x)
    if fixed:  # a coefficient at a bound that the data do not determine is not known there
        _, _, _, vectors, unidentified = _eigenvectors(curvature, middle)
        unknown = np.sum(vectors[:, unidentified] ** 2, axis=1) > MIN_PART
        fixed = [name for name, free in zip(problem.free, unknown, strict=True) if name in fixed and not free]
    names = [name for name in problem.free if name not in fixed]
    unfixed = np.array([i for i, name in enumerate(problem.free) if name not in fixed], dtype=int)
    if not unfixed.size:
        return Uncertainty(effective_rows=effective)
    block = np.ix_(unfixed, unfixed)
    spread, along, inverse, vectors, unidentified = _eigenvectors(curvature[block], middle[block])
    directions = tuple(
        Direction(_members(vectors[:, k], names), float(along[k])) for k in np.flatnonzero(unidentified)
    )  # in the order of the eigenvalues: the least determined first
    # A direction that is not identifiable has the plausible deviation of one size. It adds to the variance of
    # coefficients with a small component in it.
    spread[unidentified, :] = spread[:, unidentified] = 0.0
    spread[unidentified, unidentified] = LARGEST_SD**2
    variance = np.einsum("ik,kl,il->i", vectors, spread, vectors)
    undetermined = np.sum(vectors[:, unidentified] ** 2, axis=1) > MIN_PART
    scale = problem.scale[unfixed]
    whole, samples = np.zeros_like(curvature), list(samples_of(problem, x))
    whole[np.ix_(unfixed, unfixed)] = (vectors * np.where(unidentified, 0.0, inverse)) @ vectors.T
    discrepancies_of_channels = discrepancies(problem, samples, whole)
    added = sum(
        (discrepancy.covariance[np.ix_(unfixed, unfixed)] for discrepancy in discrepancies_of_channels),
        np.zeros((len(names), len(names))),
    )
    if sensors:
        errors = scale[:, None] * sensor_errors(problem, x, samples, whole)[unfixed]
        added = added + errors @ errors.T
    covariance = vectors @ spread @ vectors.T * np.outer(scale, scale) + added
    np.fill_diagonal(covariance, np.maximum(variance, 0.0) * scale**2 + np.diag(added))
    half = np.where(undetermined, np.inf, QUANTILE * np.sqrt(np.diag(covariance)))
    complete = pd.DataFrame(covariance, index=names, columns=names)
    masked = pd.DataFrame(covariance.copy(), index=names, columns=names)
    masked.loc[undetermined, :] = masked.loc[:, undetermined] = np.nan
    return Uncertainty(
        dict(zip(names, half.tolist(), strict=True)), directions, effective, masked, complete, discrepancies_of_channels
    )


def _eigenvectors(
    curvature: FloatArray, middle: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, BoolArray]:
    """Return the covariance in the basis of the eigenvectors, deviations along them, the inverse of the eigenvalues.

    Further the eigenvectors, and which of them are not identifiable.
    """
    values, vectors = np.linalg.eigh(curvature)
    identified = values > MIN_CURVATURE * max(float(values[-1]), 0.0)
    inverse = np.where(identified, 1.0 / np.where(identified, values, 1.0), 0.0)
    spread = vectors.T @ middle @ vectors * np.outer(inverse, inverse)
    along = np.where(identified, np.sqrt(np.maximum(np.diag(spread), 0.0)), np.inf)
    return spread, along, inverse, vectors, ~(along <= LARGEST_SD)


def sandwich(problem: Problem, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return H, the middle of the sandwich and the effective rows by recording and channel."""
    n = len(problem.free)
    curvature, middle, effective = np.zeros((n, n)), np.zeros((n, n)), np.zeros_like(problem.weights)
    noise_of_rows = np.zeros_like(problem.weights)
    for group in np.flatnonzero((problem.weights > 0).any(axis=1)):
        part = _of_recording(problem, int(group))
        rows = part.rows
        residual, present = part.residual(x), np.isfinite(rows.measured.T)
        noise: dict[int, tuple[float, NoiseCorrelation]] = {}
        for channel, free, _, squares in part.by_output(x):
            residuals, slope = residual[channel, present[channel]], 1.0
            if problem.limits is not None:
                over = np.abs(residuals) / problem.limits[group, channel]
                residuals, slope = residuals * problem.loss.weight(over), float(np.mean(problem.loss.slope(over)))
            length, variance = (
                correlation_length(residuals, rows.segment[present[channel]]),
                float(np.mean(residuals**2)),
            )
            effective[group, channel] = len(residuals) / length
            curvature[np.ix_(free, free)] += slope * squares
            noise[channel] = variance, NoiseCorrelation.of(residuals, rows.segment[present[channel]], length)
            noise_of_rows[group, channel] = length * variance * problem.weights[group, channel]
        _add_scores(middle, part, x, noise)
    for target, slope in zip(problem.targets, problem.target_jacobian(x) if problem.targets else (), strict=True):
        # The slope is a combination of the same residuals: its own variance, and twice its covariance with their sum.
        weight = problem.target_weight / target.deviation**2
        square = np.outer(slope, slope)
        curvature += square
        middle += square * (weight * target.error**2 + 2.0 * noise_of_rows[target.group, target.output])
    if problem.prior:
        curvature += problem.prior.curvature
        middle += problem.prior.weight * problem.prior.curvature
    return curvature, middle, effective


def _of_recording(problem: Problem, group: int) -> Problem:
    """Return a problem with the rows of one recording, and least squares of the residuals alone.

    It has the Jacobian of all rows with their full weights: outliers occur everywhere with equal probability.
    """
    return replace(
        problem, rows=problem.rows.of_recording(group), loss=LOSSES["squares"], limits=None, targets=(), prior=None
    )


def _add_scores(
    middle: FloatArray, part: Problem, x: FloatArray, noise: Mapping[int, tuple[float, NoiseCorrelation]]
) -> None:
    """Add s^2 J^T W R W J of the channels of one recording to the middle of the sandwich."""
    sums: dict[int, tuple[IntArray, CorrelatedSums]] = {}
    for segments, root, outputs in part.jacobian_chunks(x, CHUNK):
        for channel, (free, jacobian) in outputs.items():
            weight, segment = root[channel] ** 2, segments
            jacobian *= weight
            if not weight.all():
                here = np.flatnonzero(weight)
                jacobian, segment = np.ascontiguousarray(jacobian[:, here]), segment[here]
            if channel not in sums:
                sums[channel] = free, CorrelatedSums(noise[channel][1], len(free))
            sums[channel][1].add(jacobian, segment)
    for channel, (free, scores) in sums.items():
        middle[np.ix_(free, free)] += noise[channel][0] * scores.covariance


def _members(vector: FloatArray, names: Sequence[str]) -> tuple[str, ...]:
    order = np.argsort(-graded(np.abs(vector)), kind="stable")
    return tuple(names[i] for i in order if vector[i] ** 2 > MIN_PART)
