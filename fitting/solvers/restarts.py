"""Restarts of a stage from other initial values of a few coefficients and from other roots, against local minima."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...numerics.arrays import FloatArray
from ..problem.weighted_residuals import Problem
from .ipopt import SolverResult
from .other_roots import other_roots

#: Largest distance of a scaled value at a bound; least relative reduction of the cost for which a restart is accepted.
NEAR_BOUND, MIN_BETTER = 1e-3, 1e-5


def best_end(
    problem: Problem,
    first: SolverResult,
    solve_from: Callable[[FloatArray], SolverResult],
    lower: FloatArray,
    upper: FloatArray,
    again: Sequence[Mapping[str, float]],
    *,
    always: bool,
) -> SolverResult:
    """Solve again from other values of a few coefficients, with all others at the best solution; return the best.

    `first`: the solution of the stage. `solve_from`: solves the stage from scaled values. `lower`, `upper`, shape
    (n_free,): scaled bounds. `again`: the values of each restart. `always`: run all restarts; otherwise only those of
    which one coefficient is at a bound, as in most local minima. Returns: its iterations are those of the first
    solution and of the accepted restarts.
    """
    best = first
    for values in again:
        indices = np.array([i for i, name in enumerate(problem.free) if name in values], dtype=int)
        on_bound = np.minimum(best.x - lower, upper - best.x)[indices] < NEAR_BOUND
        if not indices.size or not (always or on_bound.any()):
            continue
        start = best.x.copy()
        start[indices] = [values[problem.free[i]] / problem.scale[i] for i in indices]
        best = _better(best, solve_from(np.clip(start, lower, upper)))
    return best


def best_root(
    problem: Problem, first: SolverResult, near: Callable[[FloatArray], SolverResult],
    solve_from: Callable[[FloatArray], SolverResult], lower: FloatArray, upper: FloatArray,
) -> SolverResult:  # fmt: skip
    """Solve again from the other roots of a solution (`other_roots`) if they are better; return the best.

    `near`: takes a few steps from a root. The other arguments are those of `best_end`.
    """
    best = first
    for start in other_roots(problem, first.x, lower, upper):
        other = near(start)
        if _better(best, other) is not best:
            best = _better(best, solve_from(other.x))
    return best


def _better(best: SolverResult, other: SolverResult) -> SolverResult:
    if other.converged and (not best.converged or other.cost < (1 - MIN_BETTER) * best.cost):
        return replace(other, iterations=best.iterations + other.iterations)
    return best
