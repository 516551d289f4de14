"""An explanation of a recording: the effects that a tire has in addition to its baseline model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.detection import Form

from ..thresholds import EFFECT_ODDS

FloatArray = npt.NDArray[np.float64]

#: The name of the unknown component of an explanation.
UNKNOWN = "UNKNOWN"


@dataclass(frozen=True, eq=False)
class Term:
    """A term of the unknown component.

    - `name`: the quantity and the formula, which identify it.
    - `column`, shape (n_channels, n): change of the forces per unit of its coefficient, N and N m.
    - `deviation`: prior standard deviation of the coefficient.
    - `tests`: number of terms of which it is one.
    """

    name: str
    column: FloatArray
    deviation: float
    tests: int


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
        """The effects, then `UNKNOWN` if it has an unknown component: equal parts are the same explanation."""
        return (*self.effects, UNKNOWN) if self.terms else self.effects

    @property
    def log_prior(self) -> float:
        """Logarithm of the prior odds: one number for all effects and the unknown component, shared by its terms.

        >>> odds = [Explanation((), (Term("", np.ones(1), 1.0, tests),)).log_prior for tests in (1, 100)]
        >>> round(float(np.exp(odds[0] - odds[1])))
        100
        """
        terms = sum(float(np.log(term.tests)) for term in self.terms)
        return (len(self.forms) + bool(self.terms)) * float(np.log(EFFECT_ODDS)) - terms

    def without(self, part: str) -> Explanation:
        """Return the explanation without an effect, or without its unknown component.

        >>> one = Explanation((("conicity", Form((), ())), ("plysteer", Form((), ()))))
        >>> one.without("plysteer").parts
        ('conicity',)
        """
        terms = () if part == UNKNOWN else self.terms
        return Explanation(tuple(each for each in self.forms if each[0] != part), terms)
