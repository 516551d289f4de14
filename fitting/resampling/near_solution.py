"""A stage solved again from its own solution, with other weights of rows or other bounds.

A few Gauss-Newton steps suffice, except along curved constraints, where no step is accepted: there IPOPT continues.
"""

from __future__ import annotations

from dataclasses import replace

from ...numerics.arrays import FloatArray
from ...numerics.gauss_newton import minimize, restore
from ..constraints.constraint_functions import ConstraintFunctions
from ..problem.regularization import Ridge
from ..problem.weighted_residuals import Problem
from ..results.stages import StageResult
from ..solvers.convergence import DAMPING, RESTORING_DAMPING, noise_of
from ..solvers.ipopt import LAST_STEPS, solve


def cost_of_a_row(stage: StageResult) -> float:
    """Return the cost of one independent row with the noise of the solution; see `solvers.convergence`."""
    least, rows = noise_of(stage.problem, stage.x)
    return max(stage.problem.cost(stage.x), least) / max(rows, 1.0)


def sampled(stage: StageResult, n: int) -> StageResult:
    """Return a stage with up to n random rows."""
    return replace(stage, problem=stage.problem.sampled(n))


def solve_near(
    stage: StageResult, problem: Problem, imposed: ConstraintFunctions, start: FloatArray, tolerance: float,
    *, lower: FloatArray | None = None, upper: FloatArray | None = None,
) -> FloatArray | None:  # fmt: skip
    """Solve a problem that differs little from that of a stage.

    `start`, shape (n_free,): scaled free values, within the bounds. `tolerance`: predicted reduction of the cost at
    which a point is the optimum. `lower`, `upper`, shape (n_free,): other bounds than those of the stage. Returns shape
    (n_free,): none if no optimum is found, in particular if the constraints cannot be satisfied.
    """
    least, most = stage.lower if lower is None else lower, stage.upper if upper is None else upper
    cost = Ridge(problem, stage.x, stage.ridge)
    feasible = restore(cost, start, least, most, RESTORING_DAMPING, imposed)
    near = start if feasible is None else feasible
    end = minimize(cost, near, least, most, lambda x, value: tolerance, DAMPING, steps=LAST_STEPS, constraints=imposed)
    if end.converged:
        return end.x
    solution = solve(problem, near, least, most, list(stage.constraints), ridge=stage.ridge)
    return solution.x if solution.converged else None
