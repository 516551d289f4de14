"""An explanation of a recording: the effects that a tire has in addition to its baseline model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...numerics.arrays import FloatArray
from ...symbolic.detection import Form
from ..thresholds import EFFECT_ODDS
from ..unexplained.features import Feature, Location

#: The name of the unknown component of an explanation.
UNKNOWN = "UNKNOWN"


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
        return (*self.effects, UNKNOWN) if self.terms else self.effects

    @property
    def log_prior(self) -> float:
        """Logarithm of the prior odds."""
        return len(self.parts) * float(np.log(EFFECT_ODDS)) + sum(term.log_prior for term in self.terms)

    def owner(self, coefficient: str) -> str:
        """Return the effect without which a coefficient is not free; empty if it is free in any case."""
        freeing = [effect for effect, form in self.forms if coefficient in form.free]
        return freeing[0] if len(freeing) == 1 else ""

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
