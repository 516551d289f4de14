"""What could be added to an explanation: gains in the linear problem, and effects that take one another's place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...numerics.ties import graded
from ..thresholds import REPORTED
from ..weighted_columns import joined
from .evidence import NormalEquations, Projected
from .linearization import Addition, Linearization

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Gain:
    """An addition with the increase of the logarithm of the evidence, prior odds included, and its estimate."""

    gain: float
    addition: Addition
    estimate: FloatArray


def projected(linear: Linearization, additions: Sequence[Addition], *, exactly: bool = False) -> Projected:
    """Return the columns of additions without what an explanation contains; `exactly` as of `equations`."""
    equations = linear.equations(additions, exactly=exactly)
    return Projected.of(equations, [len(addition.deviation) for addition in additions])


def gains(columns: Projected, additions: Sequence[Addition]) -> dict[str, list[Gain]]:
    """Return what could be added to an explanation, by name, with its gain in the linear problem."""
    scored = dict[str, list[Gain]]()
    for addition, group in zip(additions, columns.groups, strict=True):
        gain, estimate = columns.gain(group)
        scored.setdefault(addition.name, []).append(Gain(gain + addition.log_prior, addition, estimate))
    return scored


def in_place_of(part: str, linear: Linearization, additions: Sequence[Addition]) -> Projected:
    """Return the columns of additions with the response to a part as the residual; its column is the first group.

    Of the explanation, only its other coefficients and the errors of the recording are projected out: how well an
    addition takes the place of the part does not depend on what its form may err by.
    """
    problem, solution = linear.problem, linear.solution
    owned = {name for effect, form in linear.explanation.forms if effect == part for name in form.free}
    others = [name for name in solution.free if name not in owned]
    recorded = problem.disturbances.of_recording()
    fixed = [recorded.columns, linear.simulator.jacobian(solution.parameters, others)]
    columns = joined([
        *map(problem.weighted_columns, (*fixed, linear.response(part)[:, :, None])),
        *(addition.weighted_columns or problem.weighted_columns(addition.columns) for addition in additions),
    ])  # fmt: skip
    deviations = [recorded.deviation, problem.prior(others)[1], np.ones(1), *(one.deviation for one in additions)]
    precision, matrix = np.concatenate(deviations) ** -2.0, columns.times(columns)
    response = len(recorded.deviation) + len(others)
    normal = NormalEquations(
        matrix, matrix[response], float(matrix[response, response]), precision, np.zeros(len(precision))
    )
    return Projected.of(normal, [1, *(len(addition.deviation) for addition in additions)])


def rivals_of(columns: Projected, additions: Sequence[Addition]) -> dict[str, Gain]:
    """Return the best addition of each effect that is confounded with a part, by `in_place_of`, most of all first."""
    correlation, best = dict[str, float](), dict[str, Gain]()
    for addition, group in zip(additions, columns.groups[1:], strict=True):
        size = float(columns.correlations(group)[0])
        correlation[addition.name] = max(correlation.get(addition.name, 0.0), size)
        gain, estimate = columns.gain(group)
        if addition.name not in best or graded(gain) > graded(best[addition.name].gain):
            best[addition.name] = Gain(gain, addition, estimate)
    confounded = [name for name, size in correlation.items() if size > REPORTED]
    return {name: best[name] for name in sorted(confounded, key=lambda name: -graded(correlation[name]))}
