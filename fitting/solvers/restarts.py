"""Restarts of a stage from other initial values of a few coefficients and from other roots, against local minima.

Another root has values with which the equations give the same forces, such as a pair with other signs.
Where a coefficient changes and all others follow it, along v = H^-1 e, the residuals change by s J v + s^2/2 q. The
others follow q, too, except for its part along J v. With that part, k J v, the change is zero again at s = -2/k. Such a
point is a start of a further solution if its cost is near that of the solution.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...numerics.arrays import FloatArray
from ..problem.weighted_residuals import Problem
from .convergence import cost_of_a_row
from .ipopt import SolverResult

#: Largest distance of a scaled value at a bound; least relative reduction of the cost for which a restart is accepted.
NEAR_BOUND, MIN_BETTER = 1e-3, 1e-5
#: Largest number of rows with which roots are searched for.
MAX_ROWS = 2000
#: Step for the second derivative, in the size of the coefficient that changes most.
STEP = 0.05
#: Largest deviance of a start, in costs of an independent row: a solution moves it by what is beyond second order.
MAX_DEVIANCE = 300.0
#: Least distance, in standard errors of independent rows: a nearer root is in the interval.
MIN_DISTANCE = 3.0


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


def other_roots(problem: Problem, x: FloatArray, lower: FloatArray, upper: FloatArray) -> Iterator[FloatArray]:
    """Yield starts near other roots within the bounds, one of each coefficient that has one, shape (n_free,).

    `x`, `lower`, `upper`, shape (n_free,): scaled free values of the solution, and their bounds.
    """
    unit = cost_of_a_row(problem, x)
    problem = problem.sampled(MAX_ROWS)
    jacobian, residual, cost = problem.weighted_jacobian(x), problem.weighted_residual(x), problem.cost(x)
    inverse = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-12, hermitian=True)
    inside = (x > lower) & (x < upper)
    for j in np.flatnonzero(inside & (np.diag(inverse) > 0.0)):
        along = inverse[:, j] / inverse[j, j]
        step = STEP / float(np.abs(along).max())
        moved = problem.weighted_residual(x + step * along) + problem.weighted_residual(x - step * along)
        bent = (moved - 2.0 * residual) / step**2
        followed = inverse @ (jacobian.T @ bent)
        if followed[j] == 0.0:
            continue
        away = -2.0 / float(followed[j])
        start = x + away * along - 0.5 * away**2 * (followed - followed[j] * along)
        far = abs(away) > MIN_DISTANCE * float(np.sqrt(2.0 * unit * inverse[j, j]))
        if far and ((start > lower) & (start < upper))[inside].all():
            start = np.clip(start, lower, upper)
            if problem.cost(start) - cost < MAX_DEVIANCE * unit:
                yield start
