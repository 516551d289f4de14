"""An explanation of a recording: what a tire has in addition to its baseline model, effects and unknown terms.

Terms of an unknown component are features at locations of the model; some are errors of form.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...numerics.arrays import FloatArray
from ...symbolic.detection import Form
from ...symbolic.model import Model
from ..least_squares import LeastSquares, Solution
from ..probing.candidates import Candidate
from ..thresholds import EFFECT_ODDS, UNKNOWN_SHARE
from ..unexplained.features import CORE_INPUTS, LOCATIONS, Feature, Location, directions, features, placed

#: The name of the unknown component of an explanation.
UNKNOWN = "UNKNOWN"
#: Variables of the past.
PAST = frozenset({"memory", "dalpha/dt", "dkappa/dt", "dFz/dt", "distance", "V"})
#: Roles whose quantities act like a force, a lagged slip or a relaxation length on which an effect acts.
ROLES_ACTED = {
    "Fy": "offset_y", "Mz": "residual_moment", "alpha_star": "shift_y", "relaxation_y": "shift_y",
    "relaxation_x": "shift_x",
}  # fmt: skip


def in_order(parts: Collection[str]) -> tuple[str, ...]:
    """Return parts in the order that equal explanations have in common: effects alphabetically, then `UNKNOWN`."""
    return tuple(sorted(parts, key=lambda part: (part == UNKNOWN, part)))


@dataclass(frozen=True, eq=False)
class Term:
    """A term that no effect of the library explains: a feature at a location of the model.

    - `column`, shape (n_channels, n): change of the forces per unit of its coefficient, N and N m.
    - `deviation`: prior standard deviation of the coefficient.
    - `log_prior`: logarithm of its prior probability among all that were tested.
    """

    location: Location
    feature: Feature
    column: FloatArray
    deviation: float
    log_prior: float = 0.0

    @property
    def text(self) -> str:
        """What acts where."""
        return f"{self.location.name}: {self.feature.text}"

    @property
    def depends_on(self) -> frozenset[str]:
        """The variables of the feature, and those that the location is proportional to."""
        return self.feature.depends_on.union(self.location.proportional_to)


@dataclass(frozen=True, eq=False)
class Explanation:
    """A set of effects with or without an unknown component.

    - `forms`: the form of each effect by its name; coefficients of a grid are fitted from the point of the form.
    - `terms`: of the unknown component.
    """

    forms: tuple[tuple[str, Form], ...] = ()
    terms: tuple[Term, ...] = ()

    @property
    def effects(self) -> tuple[str, ...]:
        """The names of the effects in alphabetical order."""
        return tuple(sorted(name for name, _ in self.forms))

    @property
    def parts(self) -> tuple[str, ...]:
        """The effects, then `UNKNOWN` if it has such terms: equal parts are the same explanation."""
        return in_order([*self.effects, UNKNOWN]) if self.terms else self.effects

    @property
    def log_prior(self) -> float:
        """Logarithm of the prior odds."""
        return len(self.parts) * float(np.log(EFFECT_ODDS)) + sum(term.log_prior for term in self.terms)

    def owner(self, coefficient: str) -> str:
        """Return the effect without which a coefficient is not free; empty if it is free in any case."""
        freeing = [effect for effect, form in self.forms if coefficient in form.free]
        return freeing[0] if len(freeing) == 1 else ""

    def only_of(self, effect: str, owned: Collection[str]) -> frozenset[str]:
        """Return the coefficients that are absent without an effect: those of its form or owned, of no other form.

        `owned`: by the effect in the model.

        >>> one = Explanation((("conicity", Form(("PVY1", "PVY2"), ())), ("plysteer", Form(("PHY1", "PVY2"), ()))))
        >>> sorted(one.only_of("conicity", ["PHY1", "LVY"]))
        ['LVY', 'PVY1']
        """
        others = {name for other, form in self.forms if other != effect for name in form.free}
        return frozenset({*dict(self.forms)[effect].free, *owned} - others)

    def with_effect(self, name: str, form: Form) -> Explanation:
        """Return the explanation with an effect of a form."""
        return replace(self, forms=(*self.forms, (name, form)))

    def with_term(self, term: Term) -> Explanation:
        """Return the explanation with a term of the unknown component."""
        return replace(self, terms=(*self.terms, term))

    def with_a_term_less(self) -> list[Explanation]:
        """Return the explanations that lack one of the terms."""
        return [replace(self, terms=tuple(other for other in self.terms if other is not term)) for term in self.terms]

    def without(self, part: str) -> Explanation:
        """Return the explanation without an effect, or without the unknown component.

        >>> one = Explanation((("conicity", Form((), ())), ("plysteer", Form((), ()))))
        >>> one.without("plysteer").parts
        ('conicity',)
        """
        forms = tuple((name, form) for name, form in self.forms if name != part)
        return Explanation(forms, () if part == UNKNOWN else self.terms)


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
    inputs = CORE_INPUTS.union(*(candidates[name].reads for name in explanation.effects))
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


def terms_of_form(problem: LeastSquares, solution: Solution) -> list[Term]:
    """Return the terms that read the inputs of the core alone; left and right are alike in them."""
    terms = unknown_terms(problem, solution)
    return [term for term in terms if term.depends_on <= CORE_INPUTS and term.feature.odd is term.location.sideways]


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
