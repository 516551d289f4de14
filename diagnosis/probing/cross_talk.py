"""Cross-talk that is not significant is no disturbance: it would take a part of the tire's own forces."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from ..least_squares import LeastSquares, Solution
from ..recording.disturbances import CROSS_TALK
from ..thresholds import CONFIRMED_Z
from .effect_probing import Screen

#: The cross-talk that has nearly the shape of an effect, the trail.
LEVER = f"{CROSS_TALK}Fy_in_Mz"
#: Iterations of the fit without it.
ITERATIONS = 4


def doubtful_cross_talk(problem: LeastSquares, solution: Solution) -> tuple[str, ...]:
    """Return the names of the cross-talk that is less significant than an effect has to be."""
    screen = Screen(problem, solution)
    screen.learn_noise({})
    names, errors = problem.disturbances.names, screen.standard_errors()[len(solution.free) :]
    return tuple(
        name
        for name, value, error in zip(names, solution.disturbance, errors, strict=True)
        if name.startswith(CROSS_TALK) and not abs(value) > CONFIRMED_Z * error
    )


def without(problem: LeastSquares, disturbances: Collection[str]) -> LeastSquares:
    """Return a problem without some of the disturbances."""
    return replace(problem, disturbances=problem.disturbances.without(disturbances))


def without_doubtful_lever(problem: LeastSquares, solution: Solution) -> tuple[LeastSquares, Solution]:
    """Return problem and solution without a lever of Fy in Mz, unless it is significant: it hides a change of trail."""
    if LEVER not in doubtful_cross_talk(problem, solution):
        return problem, solution
    problem = without(problem, (LEVER,))
    return problem, problem.solve(solution.parameters, solution.free, iterations=ITERATIONS)


def with_lever(problem: LeastSquares, source: LeastSquares) -> LeastSquares:
    """Return a problem with the lever of another one."""
    column = source.disturbances.names.index(LEVER)
    disturbances = problem.disturbances.with_columns(
        (LEVER,), source.disturbances.columns[:, :, [column]], source.disturbances.deviation[[column]]
    )
    return replace(problem, disturbances=disturbances)
