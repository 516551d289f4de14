"""Terms of unknown components: features at locations of the model, and which of them are errors of form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...numerics.arrays import FloatArray
from ...symbolic.model import Model
from ..least_squares import LeastSquares, Solution
from ..probing.candidates import Candidate
from ..thresholds import UNKNOWN_SHARE
from ..unexplained.features import CORE_INPUTS, LOCATIONS, Location, directions, features, placed
from .explanation import Explanation, Term

#: Variables of the past.
PAST = frozenset({"memory", "dalpha/dt", "dkappa/dt", "dFz/dt", "distance", "V"})
#: Roles whose quantities act like a force, a lagged slip or a relaxation length on which an effect acts.
ROLES_ACTED = {
    "Fy": "offset_y", "Mz": "residual_moment", "alpha_star": "shift_y", "relaxation_y": "shift_y",
    "relaxation_x": "shift_x",
}  # fmt: skip


@dataclass(frozen=True)
class FormErrors:
    """Which terms are errors of the form of an explanation, not unknown effects.

    - `inputs`: of the core, and of the effects of the explanation.
    - `roles`: of the quantities on which its effects of the past act: there, errors may depend on the past.
    """

    inputs: frozenset[str]
    roles: frozenset[str]

    def contain(self, location: Location, depends_on: frozenset[str]) -> bool:
        """Return whether a term at a location with these variables is an error of form."""
        of_past = self.roles.issuperset(LOCATIONS[location.name][1])
        return depends_on <= (self.inputs | PAST if of_past else self.inputs)


def form_errors(explanation: Explanation, candidates: Mapping[str, Candidate], model: Model) -> FormErrors:
    """Return which terms are errors of the form of an explanation."""
    inputs = CORE_INPUTS.union(*(candidates[name].requires for name in explanation.effects))
    acted = {
        act.on
        for effect in model.added
        if effect.name in explanation.effects and (effect.states or effect.name in model.relaxing_effects)
        for act in effect.acts
    }
    if set(explanation.effects) & set(model.relaxing_effects):
        acted |= {"relaxation_x", "relaxation_y"}
    roles = frozenset(ROLES_ACTED.get(name, name) for name in acted)
    return FormErrors(inputs | {"T", "distance"} if {"T", "distance"} & inputs else inputs, roles)


def unknown_terms(problem: LeastSquares, solution: Solution) -> list[Term]:
    """Return the terms that an explanation may have: features at locations of the model."""
    simulator = problem.simulator
    even, odd = features(simulator.signals, simulator.tire)
    acting = directions(simulator, solution.parameters)
    return [
        Term(location, feature, column, deviation)
        for location, feature in placed(simulator, even, [*odd, *even])
        for column in [acting[location.name, feature.inclined] * feature.values]
        if (deviation := prior_deviation(problem, column)) > 0.0
    ]


def prior_deviation(problem: LeastSquares, column: FloatArray) -> float:
    """Return the prior standard deviation of the coefficient of a term; 0 if its column is zero.

    The term is then `UNKNOWN_SHARE` of the measured forces. The deviation is at most 1, as a feature is of order 1 in
    normal operation: a recording of small slips does not make larger coefficients plausible.

    >>> from types import SimpleNamespace
    >>> signals = SimpleNamespace(measured=np.full((1, 4), 100.0))
    >>> problem = SimpleNamespace(inverse_noise=np.ones((1, 4)), simulator=SimpleNamespace(signals=signals))
    >>> [prior_deviation(problem, np.full((1, 4), size)) for size in (20.0, 1.0, 0.0)]
    [0.5, 1.0, 0.0]
    """
    measured, of_column = (
        float(np.linalg.norm(problem.inverse_noise * forces)) for forces in (problem.simulator.signals.measured, column)
    )
    return min(UNKNOWN_SHARE * measured / of_column, 1.0) if of_column > 0.0 else 0.0
