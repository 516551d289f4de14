"""A stage solved again from its own solution: with other weights of rows, from other roots, without a bound.

A few Gauss-Newton steps suffice, except along curved constraints, where no step is accepted: there IPOPT continues.

A second solution has other values of some coefficients, which the data do not distinguish from the first. A bound has
a consequence if the error of a channel falls without it, or if a force changes by more than is seen in a curve; the
bounds of other coefficients remain.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...numerics.arrays import FloatArray
from ...numerics.gauss_newton import minimize, restore
from ...numerics.ties import graded
from ...tires.code import fastest_code
from ..constraints.constraint_functions import ConstraintFunctions
from ..fit_result import FitResult
from ..problem.weighted_residuals import Problem, Ridge
from ..results.records import BoundConsequence
from ..results.stages import StageResult
from ..solvers.convergence import DAMPING, RESTORING_DAMPING, cost_of_a_row
from ..solvers.ipopt import LAST_STEPS, solve
from ..solvers.restarts import other_roots
from ..uncertainty.sandwich import QUANTILE

#: Largest numbers of rows with which a stage is solved again: from other roots, and without a bound.
ROWS_FOR_ROOTS, ROWS_FOR_BOUNDS = 30_000, 3000
#: Distance by which a bound is moved, as a multiple of the distance of both bounds.
RELAXED = 2.0
#: Predicted reduction of the cost at which a point is the optimum, in costs of an independent row.
TOLERANCE = 0.05


def _sampled(stage: StageResult, n: int) -> StageResult:
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


def with_second_solutions(result: FitResult) -> FitResult:
    """Return the result with the values of the best second solution of each stage, and intervals that contain both.

    `result`: with coefficients in adapted SAE.
    """
    other: dict[str, float] = {}
    for stage in result.whole_stages:
        names = result.determined_by(stage)
        determined = [c for c in result.coefficients if c.name in names]
        for _, values in sorted(_others(stage), key=lambda solution: graded(solution[0])):
            different = {c.name: values[c.name] for c in determined if abs(values[c.name] - c.value) > c.interval}
            if different:
                other |= different
                break
    coefficients = tuple(
        replace(c, other=other[c.name], interval=c.interval + abs(other[c.name] - c.value)) if c.name in other else c
        for c in result.coefficients
    )
    return replace(result, coefficients=coefficients)


def _others(stage: StageResult) -> Iterator[tuple[float, dict[str, float]]]:
    """Yield cost and values of solutions from other roots that fit as well, the first solution possibly among them."""
    unit = cost_of_a_row(stage.problem, stage.x)
    stage = _sampled(stage, ROWS_FOR_ROOTS)
    problem, imposed = stage.problem, ConstraintFunctions(stage.problem, stage.constraints)
    for start in other_roots(problem, stage.x, stage.lower, stage.upper):
        solved = solve_near(stage, problem, imposed, start, TOLERANCE * unit)
        if solved is not None and problem.cost(solved) - problem.cost(stage.x) < QUANTILE**2 * unit:
            yield problem.cost(solved), dict(zip(problem.free, (solved * problem.scale).tolist(), strict=True))


def with_consequences(result: FitResult) -> FitResult:
    """Return the result with what its bounds do, for each coefficient at a bound."""
    bounded = {c.name for c in result.coefficients if c.at_bound}
    consequences: list[BoundConsequence] = []
    for stage in result.whole_stages:
        names = [name for name in result.determined_by(stage) if name in bounded]
        if names:
            consequences += _of_stage(_sampled(stage, ROWS_FOR_BOUNDS), names)
    return replace(result, bounds=tuple(consequences))


def _of_stage(stage: StageResult, names: Sequence[str]) -> list[BoundConsequence]:
    problem = stage.problem
    imposed = ConstraintFunctions(problem, stage.constraints)
    tolerance = TOLERANCE * cost_of_a_row(stage.problem, stage.x)
    start = solve_near(stage, problem, imposed, stage.x, tolerance)
    start = stage.x if start is None else start
    before = _forces(problem, start)
    changes = []
    for name in names:
        j = problem.free.index(name)
        width = RELAXED * (stage.upper[j] - stage.lower[j])
        lower, upper = stage.lower.copy(), stage.upper.copy()
        at_lower = start[j] - lower[j] < upper[j] - start[j]
        lower[j], upper[j] = (lower[j] - width, upper[j]) if at_lower else (lower[j], upper[j] + width)
        solved = solve_near(stage, problem, imposed, start, tolerance, lower=lower, upper=upper)
        if solved is None:
            changes.append(BoundConsequence(name))
            continue
        changes.append(
            _consequence(problem, name, float(solved[j] * problem.scale[j]), before, _forces(problem, solved))
        )
    return changes


def _forces(problem: Problem, x: FloatArray) -> FloatArray:
    """Return the outputs at the rows, shape (n_outputs, n)."""
    code = fastest_code(problem.tire.symbolic_model)
    return code.forces(problem.tire.effective_inputs(problem.rows.inputs), problem.parameters(x))


def _consequence(problem: Problem, name: str, value: float, before: FloatArray, after: FloatArray) -> BoundConsequence:
    """Return the channel whose error changes most relative to its spread."""
    worst = BoundConsequence(name, value, "", 0.0, 0.0, 0.0)
    for index, channel in enumerate(problem.tire.outputs):
        measured = problem.rows.measured[:, index]
        present = np.isfinite(measured)
        if not present.any() or not problem.weights[:, index].any():
            continue
        old, new = (
            float(np.sqrt(np.mean((forces[index, present] - measured[present]) ** 2))) for forces in (before, after)
        )
        spread = float(np.std(measured[present]))
        change = float(np.abs(after[index] - before[index]).max()) / spread if spread > 0.0 else 0.0
        if change > worst.change:
            worst = BoundConsequence(name, value, channel, old, new, change)
    return worst
