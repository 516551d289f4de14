"""Weights of channels by their effective sample size instead of their number of rows."""

from __future__ import annotations

import numpy as np

from ...numerics.arrays import FloatArray
from ...numerics.correlation import correlation_length
from .weighted_residuals import Problem


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
