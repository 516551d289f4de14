"""The slip stiffness read from the data as additional residuals of the stages of a fit (docs/stiffness.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pandas as pd

from ..numerics.arrays import FloatArray
from .evidence.residuals import Residuals
from .evidence.slip_stiffness import slope_targets
from .problem.slope_targets import SlopeTarget
from .problem.weighted_residuals import Problem
from .solvers.convergence import noise_of
from .solvers.ipopt import SolverResult


class StiffnessTargets:
    """The targets of the stages of one fit; they are read from the data when a stage first uses them.

    `weight`: a target that is off by its deviation costs as much as this number of independent rows off by theirs; 0:
    there are no targets.
    """

    def __init__(self, weight: float) -> None:
        self._weight = weight
        self._read: tuple[SlopeTarget, ...] | None = None

    def add(self, problem: Problem, start: FloatArray, data: pd.DataFrame) -> None:
        """Add the targets of the channels that have a weight to a problem.

        `start`, shape (n_free,): its scaled initial values. `data`: all fitted rows, in adapted SAE.
        """
        if not self._weight:
            return
        tire, weights = problem.tire, problem.weights
        if self._read is None or tire.states:  # simulated states are inputs
            groups = tuple(map(str, range(int(data["recording"].max()) + 1)))
            self._read = slope_targets(Residuals.of(data, groups, tire))
        problem.targets = tuple(
            target
            for target in self._read
            if target.group < len(weights) and weights[target.group, target.output] > 0.0
        )
        _, rows = noise_of(problem, start)
        problem.target_weight = self._weight / max(rows, 1.0)


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
