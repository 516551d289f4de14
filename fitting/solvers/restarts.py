"""Other starts for the few coefficients whose end may be a wrong one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ..problem.weighted_residuals import Problem
from .ipopt import Solution

FloatArray = npt.NDArray[np.float64]
#: A scaled value this near to a bound lies on it; another start's end is kept where it costs less by this share.
NEAR_BOUND, LEAST_BETTER = 1e-3, 1e-5


def best_end(
    problem: Problem,
    first: Solution,
    solve_from: Callable[[FloatArray], Solution],
    lower: FloatArray,
    upper: FloatArray,
    again: Sequence[Mapping[str, float]],
    *,
    always: bool,
) -> Solution:
    """Solve again from other values of a few coefficients, everything else at the end so far; return the best end.

    Parameters
    ----------
    problem : Problem
    first : Solution
        Where the stage ended.
    settle : callable
        Solves from scaled values.
    lower, upper : ndarray, shape (n_free,)
        Scaled bounds.
    again : sequence of mapping of str to float
        The values, try by try.
    always : bool
        Try all; else only where one of a try's coefficients ended on a bound, as wrong ends do.

    Returns
    -------
    Solution
        Its iterations are those of the first end and of the one that replaced it.
    """
    best = first
    for values in again:
        indices = np.array([i for i, name in enumerate(problem.free) if name in values], dtype=int)
        on_bound = np.minimum(best.x - lower, upper - best.x)[indices] < NEAR_BOUND
        if not indices.size or not (always or on_bound.any()):
            continue
        start = best.x.copy()
        start[indices] = [values[problem.free[i]] / problem.scale[i] for i in indices]
        other = solve_from(np.clip(start, lower, upper))
        if other.converged and (not best.converged or other.cost < (1 - LEAST_BETTER) * best.cost):
            best = replace(other, iterations=best.iterations + other.iterations)
    return best
