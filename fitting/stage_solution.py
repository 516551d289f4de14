"""The solution of one stage: its targets, the verification of its constraints, and what an earlier stage has found.

A stage that continues the one before has the same coefficients and more rows. It starts near its solution, to which few
Gauss-Newton steps lead; IPOPT follows only if they find no optimum. Most of them are taken with a sample of the rows,
so that all rows are needed for the last ones only.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from ..numerics.arrays import FloatArray
from .constraints.verification import APPROACHED, VERIFIED, ConstraintPoints, VerifiedConstraints
from .problem.weighted_residuals import Problem
from .solvers.ipopt import Progress, SolverResult
from .solvers.selection import Solver
from .stiffness_targets import solve_with_targets

#: Upper limit of the rounds in which points that violate a constraint are added.
ROUNDS = 12
#: Rows of the sample, and least number of rows from which one is taken. At the optimum of a sample the cost of all rows
#: is greater by a share of about n / (2 rows of the sample), which one or two steps remove.
SAMPLE, MIN_ROWS = 30_000, 60_000


@dataclass(frozen=True)
class StageSolver:
    """Solves the problem of a stage from any start.

    - `lower`, `upper`, shape (n_free,): scaled bounds of the free coefficients.
    - `constraints`: of the fit; violated points are added to them.
    - `channels`: the channels of the stage.
    - `stage_type`, one of "intermediate", "penultimate", "final".
    - `ridge`: strength of the regularization.
    - `report`: called with iteration and cost.
    - `stop`: true ends the solution.
    """

    problem: Problem
    lower: FloatArray
    upper: FloatArray
    constraints: VerifiedConstraints
    channels: Sequence[str]
    stage_type: str
    ridge: float
    solver: Solver
    report: Progress
    stop: Callable[[], bool]

    def solve(self, start: FloatArray, *, continues: bool = False) -> SolverResult:
        """Solve, verify the constraints on the dense grid, and solve again with the points that violate them.

        An intermediate stage is solved again once: if its values violated a constraint, their residuals would give the
        next stage weights for a noise that no tire with this constraint reaches.

        `start`, shape (n_free,): scaled free values. `continues`: whether the start is the solution for the same
        coefficients with fewer rows.
        """
        constraints = self._known
        approached = self.stage_type == "intermediate"
        dense = self.constraints.of(self.channels, density=APPROACHED if approached else VERIFIED)
        solver = self._in_bounds
        solution = self._first(start, partial(solver, constraints=constraints), continues=continues)
        for _ in range(1 if approached else ROUNDS):
            if self.stop():
                break
            violated = self.constraints.violations(dense, self.problem.parameters(solution.x))
            if not violated:
                break
            constraints = constraints + violated
            after = solver(self.problem, solution.x, constraints=constraints, refine=True)
            solution = replace(after, iterations=solution.iterations + after.iterations)
        return solution

    def near(self, start: FloatArray) -> SolverResult:
        """Return the end of Gauss-Newton steps with the constraints that are known, which are not verified.

        `start`, shape (n_free,): scaled free values.
        """
        return self._continued(start, partial(self._in_bounds, constraints=self._known))

    @property
    def _known(self) -> list[ConstraintPoints]:
        return self.constraints.of(self.channels) + self.constraints.violated

    @property
    def _in_bounds(self) -> Callable[..., SolverResult]:
        return partial(
            self.solver, lower=self.lower, upper=self.upper, ridge=self.ridge, stage_type=self.stage_type,
            progress=self.report, stop=self.stop,
        )  # fmt: skip

    def _first(self, start: FloatArray, solve: Callable[..., SolverResult], *, continues: bool) -> SolverResult:
        """Return the solution with the constraints that are known."""
        iterations = 0
        if continues:
            near = self._continued(start, solve)
            if near.converged or self.stop():
                return near
            start, iterations = near.x, near.iterations
        solution = solve_with_targets(self.problem, start, partial(solve, self.problem), self.stop)
        return replace(solution, iterations=iterations + solution.iterations)

    def _continued(self, start: FloatArray, solve: Callable[..., SolverResult]) -> SolverResult:
        """Return the end of Gauss-Newton steps, at first with a sample of many rows."""
        if len(self.problem.rows) < MIN_ROWS:
            return solve(self.problem, start, local=True)
        first = solve(self.problem.sampled(SAMPLE), start, local=True)
        if self.stop():
            return replace(first, cost=self.problem.cost(first.x), converged=False)
        after = solve(self.problem, first.x, refine=True)  # near the optimum undamped steps are the shortest way
        return replace(after, iterations=first.iterations + after.iterations)
