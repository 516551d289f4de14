"""What a bound does to a fit: the last stage is solved again without the bound.

The bounds of other coefficients remain. If the error of no channel falls and no force changes by more than is seen in a
curve, the bound has no consequence.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...numerics.arrays import FloatArray
from ...tires.code import fastest_code
from ..constraints.constraint_functions import ConstraintFunctions
from ..fit_result import FitResult
from ..problem.weighted_residuals import Problem
from ..results.records import BoundConsequence
from ..results.stages import StageResult
from .near_solution import cost_of_a_row, sampled, solve_near

#: Largest number of rows with which a stage is solved again.
MAX_ROWS = 3000
#: Distance by which a bound is moved, as a multiple of the distance of both bounds.
RELAXED = 2.0
#: Predicted reduction of the cost at which a point is the optimum, in costs of an independent row.
TOLERANCE = 0.05


def with_consequences(result: FitResult) -> FitResult:
    """Return the result with what its bounds do, for each coefficient at a bound."""
    bounded = {c.name for c in result.coefficients if c.at_bound}
    consequences: list[BoundConsequence] = []
    for stage in result.whole_stages:
        names = [name for name in result.determined_by(stage) if name in bounded]
        if names:
            consequences += _of_stage(sampled(stage, MAX_ROWS), names)
    return replace(result, bounds=tuple(consequences))


def _of_stage(stage: StageResult, names: Sequence[str]) -> list[BoundConsequence]:
    problem = stage.problem
    imposed = ConstraintFunctions(problem, stage.constraints)
    tolerance = TOLERANCE * cost_of_a_row(stage)
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
