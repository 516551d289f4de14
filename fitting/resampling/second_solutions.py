"""A second solution of a fit, with other values of some coefficients, which the data do not distinguish from it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ...numerics.ties import graded
from ..constraints.constraint_functions import ConstraintFunctions
from ..fit_result import FitResult
from ..results.stages import StageResult
from ..solvers.restarts import other_roots
from ..uncertainty.sandwich import QUANTILE
from .near_solution import cost_of_a_row, sampled, solve_near

#: Largest number of rows with which a stage is solved again.
MAX_ROWS = 30_000
#: Predicted reduction of the cost at which a point is the optimum, in costs of an independent row.
TOLERANCE = 0.05


def with_second_solutions(result: FitResult) -> FitResult:
    """Return the result with the values of the best second solution of each stage, and intervals that contain both.

    `result`: with coefficients in adapted SAE.
    """
    other: dict[str, float] = {}
    for stage in result.whole_stages:
        determined = [c for c in result.coefficients if c.name in result.determined_by(stage)]
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
    unit = cost_of_a_row(stage)
    stage = sampled(stage, MAX_ROWS)
    problem, imposed = stage.problem, ConstraintFunctions(stage.problem, stage.constraints)
    for start in other_roots(problem, stage.x, stage.lower, stage.upper):
        solved = solve_near(stage, problem, imposed, start, TOLERANCE * unit)
        if solved is not None and problem.cost(solved) - problem.cost(stage.x) < QUANTILE**2 * unit:
            yield problem.cost(solved), dict(zip(problem.free, (solved * problem.scale).tolist(), strict=True))
