r"""Profile likelihood of a coefficient: the largest likelihood for each of its values, over all other coefficients.

The noise is correlated in time, so the decrease of the cost has no chi-squared distribution. It is divided by its mean
under the hypothesis (Rotnitzky and Jewell, 1990, for one parameter): with the curvature H of the cost, the covariance M
of its gradient and the direction v = H^-1 e along which the coefficient changes,

    deviance = 2 (cost - least cost) v'Hv / v'Mv.

If the cost is quadratic, its square root is the distance in standard errors, and the interval is that of the sandwich
estimator (`uncertainty.sandwich`). Otherwise the interval is not symmetric, and it respects bounds and constraints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from ...boundary.errors import FitError, UnknownName
from ...numerics.arrays import FloatArray
from ..constraints.constraint_functions import ConstraintFunctions
from ..results.fit_result import FitResult
from ..results.resampled import Profile
from ..results.solved_stage import SolvedStage
from ..uncertainty.sandwich import QUANTILE, sandwich
from .near_solution import solve_near

#: Distance between two points of a curve and its end, in standard errors; upper limit of the solutions of a side.
STEP, END = 0.5, 2.5
MAX_POINTS = 16
#: Predicted reduction of the deviance at which a point of the curve is an optimum.
TOLERANCE = 1e-3


@dataclass(frozen=True, eq=False)
class SideTask:
    """One side of the profile of a coefficient: what a worker needs. `direction` is -1 or 1."""

    stage: SolvedStage
    name: str
    direction: int


@dataclass(frozen=True)
class Side:
    """One side of a profile: values (not scaled) and roots of the deviance, from the solution on; why it ends."""

    values: tuple[float, ...]
    roots: tuple[float, ...]
    end: str


def side_tasks(result: FitResult, names: Sequence[str]) -> list[SideTask]:
    """Return the tasks of profiles, two for each coefficient.

    Raises `UnknownName` if a coefficient was not fitted. Raises `FitError` if no stage with all its rows determined it.
    """
    stages = {name: stage for stage in result.solution.stages for name in stage.determined & set(stage.problem.free)}
    for name in names:
        if name not in {coefficient.name for coefficient in result.coefficients}:
            raise UnknownName("fitted coefficient", name, [coefficient.name for coefficient in result.coefficients])
        if name not in stages:
            raise FitError(f"profile of {name}: no stage with all of its rows determined it")
    return [SideTask(stages[name], name, direction) for name in dict.fromkeys(names) for direction in (-1, 1)]


def side_of(task: SideTask) -> Side:
    """Compute one side of a profile, in any process."""
    stage, problem = task.stage, task.stage.problem
    j = problem.free.index(task.name)
    imposed = ConstraintFunctions(problem, stage.constraints)
    along, mean = _direction(stage, j)
    tolerance = 0.5 * TOLERANCE * mean
    best = solve_near(stage, problem, imposed, stage.x, tolerance)
    x = stage.x if best is None else best
    least = problem.cost(x)
    step, points, end = STEP * float(np.sqrt(mean * along[j])), [(float(x[j]), 0.0)], "flat"
    for _ in range(MAX_POINTS):
        following = float(np.clip(x[j] + task.direction * step, stage.lower[j], stage.upper[j]))
        if abs(following - x[j]) <= 1e-9 * step:
            end = "bound"
            break
        lower, upper = stage.lower.copy(), stage.upper.copy()
        lower[j] = upper[j] = following
        start = np.clip(x + along / along[j] * (following - x[j]), lower, upper)
        solved = solve_near(stage, problem, imposed, start, tolerance, lower=lower, upper=upper)
        if solved is None:
            end = "no solution"
            break
        # The optimum may be better than the solution by the tolerance.
        root = float(np.sqrt(max(2.0 * (problem.cost(solved) - least) / mean, 0.0)))
        rise = root - points[-1][1]
        step *= float(np.clip(STEP / rise, 0.25, 2.0)) if rise > 0.0 else 2.0
        if rise > 2.0 * STEP:
            continue  # too far for an interpolation
        x = solved
        points.append((following, root))
        if root >= END:
            break
    end = "likelihood" if points[-1][1] >= QUANTILE else end
    scale = float(problem.scale[j])
    return Side(tuple(value * scale for value, _ in points), tuple(root for _, root in points), end)


def profiles_of(result: FitResult, tasks: Sequence[SideTask], sides: Sequence[Side]) -> FitResult:
    """Return a fit with profiles.

    `sides`: of `side_of`, in the order of the tasks.
    """
    units = {coefficient.name: coefficient.unit for coefficient in result.coefficients}
    pairs = zip(tasks[::2], sides[::2], sides[1::2], strict=True)
    profiles = tuple(_profile(task.name, units[task.name], below, above) for task, below, above in pairs)
    return replace(result.in_signs("adapted-sae"), profiles=profiles).in_signs(result.signs)


def _profile(name: str, unit: str, below: Side, above: Side) -> Profile:
    values = (*reversed(below.values), *above.values[1:])
    roots = (*reversed(below.roots), *above.roots[1:])
    return Profile(
        name, unit, above.values[0], _end(below), _end(above), below.end, above.end, values,
        tuple(root**2 for root in roots),
    )  # fmt: skip


def _end(side: Side) -> float:
    """Return the value at which the deviance reaches the quantile, or where it cannot be computed."""
    if side.end == "likelihood":
        roots = np.maximum.accumulate(side.roots)
        rising = np.concatenate([[True], np.diff(roots) > 0.0])
        return float(PchipInterpolator(roots[rising], np.array(side.values)[rising])(QUANTILE))
    return float("nan") if side.end == "flat" else side.values[-1]


def _direction(stage: SolvedStage, j: int) -> tuple[FloatArray, float]:
    """Return H^-1 e, 0 for other coefficients at a bound, and the mean of twice the decrease of the cost."""
    curvature, noise, _ = sandwich(stage.problem, stage.x)
    near = 1e-6 * np.maximum(1.0, np.abs(stage.x))
    free = (stage.x - stage.lower > near) & (stage.upper - stage.x > near)
    free[j] = True
    block = np.ix_(free, free)
    regular = curvature[block] + stage.ridge * np.eye(int(free.sum()))
    along = np.zeros(len(free))
    along[free] = np.linalg.solve(regular, np.eye(len(free))[j][free])
    return along, float(along @ noise @ along / (along[free] @ regular @ along[free]))
