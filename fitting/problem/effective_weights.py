"""How many independent rows a recording's channel is worth, as a factor of its weight."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tirefmu.measurements import correlation_length

from .weighted_residuals import Problem

FloatArray = npt.NDArray[np.float64]


def weights_by_worth(problem: Problem, x: FloatArray) -> FloatArray:
    """Return the weights of a problem, each divided by the correlation length of its residuals at x.

    What a tire misses at one row it misses at the next: a channel of a recording counts by the independent rows that
    it is worth, not by those that were logged. The cost at x stays what it was.

    Parameters
    ----------
    problem : Problem
        With weights by noise.
    x : ndarray, shape (n_free,)
        Scaled free values.

    Returns
    -------
    ndarray, shape (n_groups, n_forces)
    """
    residual, there = problem.residual(x), np.isfinite(problem.rows.measured.T)
    squares, lengths = np.zeros_like(problem.weights), np.ones_like(problem.weights)
    for group, channel in np.argwhere(problem.weights > 0):
        rows = np.flatnonzero(there[channel] & (problem.rows.group == group))
        if rows.size:
            missed = residual[channel, rows]
            edges = np.flatnonzero(np.diff(problem.rows.segment[rows])) + 1
            segments = [slice(*ends) for ends in zip([0, *edges], [*edges, len(rows)], strict=True)]
            squares[group, channel] = float(missed**2 @ problem.rows.weight[rows])
            lengths[group, channel] = correlation_length(missed, segments)
    weights = problem.weights / lengths
    before, after = (float(np.sum(each * squares)) for each in (problem.weights, weights))
    return weights * (before / after) if after > 0 else weights
