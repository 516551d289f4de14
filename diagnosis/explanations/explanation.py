"""An explanation of a recording: the effects that a tire has in addition to its baseline model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.detection import Form

from ..thresholds import EFFECT_ODDS
from ..unexplained.features import Feature, Location

FloatArray = npt.NDArray[np.float64]

#: The names of the unknown component of an explanation, and of errors of the functional form of the model.
UNKNOWN, FORM = "UNKNOWN", "FORM"


@dataclass(frozen=True, eq=False)
class Term:
    """A term that no effect of the library explains: a feature at a location of the model.

    - `part`: `UNKNOWN` or `FORM`.
    - `column`, shape (n_channels, n): change of the forces per unit of its coefficient, N and N m.
    - `deviation`: prior standard deviation of the coefficient.
    - `log_prior`: logarithm of its prior odds.
    """

    part: str
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
    """A set of effects with or without an unknown component, and errors of the functional form.

    - `forms`: the form of each effect by its name; coefficients of a grid are fitted from the point of the form.
    - `terms`: of the unknown component and of errors of the functional form.
    """

    forms: tuple[tuple[str, Form], ...] = ()
    terms: tuple[Term, ...] = ()

    @property
    def effects(self) -> tuple[str, ...]:
        """The names of the effects in alphabetical order."""
        return tuple(sorted(name for name, _ in self.forms))

    @property
    def parts(self) -> tuple[str, ...]:
        """The effects, then `FORM` and `UNKNOWN` if it has such terms: equal parts are the same explanation."""
        return (*self.effects, *sorted({term.part for term in self.terms}))

    def terms_of(self, part: str) -> tuple[Term, ...]:
        """Return the terms of the unknown component, or of errors of the functional form."""
        return tuple(term for term in self.terms if term.part == part)

    @property
    def log_prior(self) -> float:
        """Logarithm of the prior odds."""
        return len(self.forms) * float(np.log(EFFECT_ODDS)) + sum(term.log_prior for term in self.terms)

    def extended(self, name: str, part: Form | Term) -> Explanation:
        """Return the explanation with an effect of a form, or with a term."""
        if isinstance(part, Term):
            return Explanation(self.forms, (*self.terms, part))
        return Explanation((*self.forms, (name, part)), self.terms)

    def without(self, part: str) -> Explanation:
        """Return the explanation without an effect, or without the terms of a part.

        >>> one = Explanation((("conicity", Form((), ())), ("plysteer", Form((), ()))))
        >>> one.without("plysteer").parts
        ('conicity',)
        """
        terms = tuple(term for term in self.terms if term.part != part)
        return Explanation(tuple((name, form) for name, form in self.forms if name != part), terms)
