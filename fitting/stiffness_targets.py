"""The slip stiffness read from the data as additional residuals of the stages of a fit (docs/stiffness.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pandas as pd

from ..numerics.arrays import FloatArray
from ..tires.tire import Tire
from .checks.residuals import Residuals
from .checks.slip_stiffness import slope_targets
from .problem.slope_targets import SlopeTarget
from .problem.weighted_residuals import Problem
from .solvers.convergence import noise_of
from .solvers.ipopt import SolverResult


def read_targets(table: pd.DataFrame, tire: Tire) -> tuple[SlopeTarget, ...]:
    """Return the slip stiffnesses of all fitted rows, in adapted SAE."""
    groups = tuple(map(str, range(int(table["recording"].max()) + 1)))
    return slope_targets(Residuals.of(table, groups, tire))


def add_targets(problem: Problem, start: FloatArray, targets: tuple[SlopeTarget, ...], weight: float) -> None:
    """Add the targets of the channels that have a weight to a problem.

    `start`, shape (n_free,): its scaled initial values. `weight`: a target that is off by its deviation costs as much
    as this number of independent rows off by theirs.
    """
    weights = problem.weights
    problem.targets = tuple(t for t in targets if t.group < len(weights) and weights[t.group, t.output] > 0.0)
    _, rows = noise_of(problem, start)
    problem.target_weight = weight / max(rows, 1.0)


def solve_with_targets(
    problem: Problem, start: FloatArray, solve: Callable[..., SolverResult], stop: Callable[[], bool]
) -> SolverResult:
    """Solve a problem without its targets, and then with them.

    The targets change the solution a little, in a narrow valley: a few Gauss-Newton steps, many of IPOPT.

    `start`, shape (n_free,). `solve`: a solver for this problem: takes the start, and `refine` as in
    `tirefmu.fitting.solvers.ipopt.solve`. `stop`: true ends the solution after the first part.
    """
    targets, problem.targets = problem.targets, ()
    first = solve(start)
    problem.targets = targets
    if not targets or stop():
        return first
    after = solve(first.x, refine=True)
    return replace(after, iterations=first.iterations + after.iterations)
