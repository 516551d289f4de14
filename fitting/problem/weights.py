"""Weights of the channels of recordings: equal, by noise, by effective sample size; limits of robust losses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from ...measurements.operating_conditions.levels import held_levels
from ...numerics.arrays import FloatArray
from ...numerics.correlation import correlation_length
from .loss import robust_scale
from .rows import Rows
from .weighted_residuals import Problem

#: Least noise of a channel, relative to its root mean square.
MIN_NOISE = 1e-4
#: The slip of each channel, and the weight factor of recordings that sweep it.
OWN_SLIP = {"Fx": "kappa", "Fy": "alpha", "Mz": "alpha"}
SWEPT = 1.75


def equal_weights(rows: Rows) -> FloatArray:
    """Return weights for the cost of the Trento report: half the sum of 1 - R2 (uncentred) over the channels."""
    squares = np.sum([np.nansum(block.measured**2 * block.weight[:, None], axis=0) for block in rows.blocks()], axis=0)
    groups = int(rows.group.max(initial=0)) + 1
    return np.broadcast_to(1.0 / np.where(squares > 0, squares, 1.0), (groups, rows.measured.shape[1])).copy()


def emphasis(data: pd.DataFrame, outputs: Sequence[str]) -> FloatArray:
    """Return weight factors by recording and channel: more than 1 if the slip of the channel is swept.

    If recordings are inconsistent, a sweep contains more information on a force than rows at a few held slips. So the
    cornering test determines the pure side force, and the drive and brake test its reduction by longitudinal slip.

    `data`: with the column ``recording``. Returns shape (n_recordings, n_outputs).
    """
    factors = np.ones((int(data["recording"].max()) + 1, len(outputs)))
    for number in range(len(factors)):
        table = data[data["recording"] == number]
        for column, output in enumerate(outputs):
            slip = OWN_SLIP.get(output)
            if slip in table and np.ptp(table[slip]) > 0 and not held_levels(table[slip]):
                factors[number, column] = SWEPT
    return factors


def limits_of(problem: Problem, x: FloatArray) -> FloatArray | None:
    """Return the limits of the loss from the noise of each channel of a recording at x; None for squares."""
    if not np.isfinite(problem.loss.constant):
        return None
    limits = np.ones_like(problem.weights)
    for group, channel, residual, least in _by_channel(problem, x):
        limits[group, channel] = problem.loss.constant * max(robust_scale(residual), least)
    return limits


def noise_weights(problem: Problem, x: FloatArray, factors: FloatArray | None = None) -> FloatArray:
    """Return weights by the residual variance of each channel of a recording at x.

    The noise is assumed to be at least `MIN_NOISE` of the signal: residuals of exact data are rounding errors. For
    robust losses the variance is estimated without outliers. The factors, shape (n_groups, n_forces), multiply the
    weights.
    """
    weights, robust = np.zeros_like(problem.weights), np.isfinite(problem.loss.constant)
    weighted_rows = np.isfinite(problem.rows.measured) & (problem.weights > 0)[problem.rows.group]
    count = weighted_rows.sum()
    for group, channel, residual, least in _by_channel(problem, x):
        deviation = robust_scale(residual) if robust else float(np.sqrt(np.mean(residual**2)))
        weights[group, channel] = 1.0 / (max(deviation, least) ** 2 * count)
    return weights if factors is None else weights * factors[: len(weights)]


def effective_weights(problem: Problem, x: FloatArray) -> FloatArray:
    """Return the weights of a problem, each divided by the correlation length of its residuals at x.

    Residuals of neighboring rows are correlated. Therefore a channel of a recording is weighted by its effective sample
    size instead of its number of rows. The cost at x does not change.

    `problem`: with weights by noise. `x`, shape (n_free,): scaled free values. Returns shape (n_groups, n_forces).
    """
    residual, present = problem.residual(x), np.isfinite(problem.rows.measured.T)
    squares, lengths = np.zeros_like(problem.weights), np.ones_like(problem.weights)
    for group, channel in np.argwhere(problem.weights > 0):
        rows = np.flatnonzero(present[channel] & (problem.rows.group == group))
        if rows.size:
            series = residual[channel, rows]
            squares[group, channel] = float(series**2 @ problem.rows.weight[rows])
            lengths[group, channel] = correlation_length(series, problem.rows.segment[rows])
    weights = problem.weights / lengths
    before, after = (float(np.sum(factors * squares)) for factors in (problem.weights, weights))
    return weights * (before / after) if after > 0 else weights


def _by_channel(problem: Problem, x: FloatArray) -> Iterator[tuple[int, int, FloatArray, float]]:
    """Yield recording, channel, residuals, and least noise of everything that has a weight and is not 0 everywhere.

    The rows of a stage may contain only zeros of a channel: there is no scale for its noise.
    """
    residual, measured = problem.residual(x), problem.rows.measured.T
    for group, channel in np.argwhere(problem.weights > 0):
        present = (problem.rows.group == group) & np.isfinite(measured[channel])
        least = MIN_NOISE * float(np.sqrt(np.mean(measured[channel, present] ** 2))) if present.any() else 0.0
        if least > 0.0:
            yield int(group), int(channel), residual[channel, present], least
