"""The formula of what no effect of the library explains: features at a location of the model."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from .features import Feature, Location


@dataclass(frozen=True, eq=False)
class Structure:
    """A sum of features that acts on quantities of the model.

    Attributes
    ----------
    location : Location
    terms : tuple of Feature
    sizes : tuple of float
        The estimated coefficient of each term.
    """

    location: Location
    terms: tuple[Feature, ...]
    sizes: tuple[float, ...]

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The variables, sorted."""
        return tuple(sorted(frozenset(self.location.proportional_to).union(*(term.depends_on for term in self.terms))))

    @property
    def formula(self) -> str:
        """The formula as text."""
        return self.formula_with(self.sizes)

    def formula_with(self, sizes: Iterable[float]) -> str:
        """Return the formula with given coefficients.

        Parameters
        ----------
        sizes : iterable of float
            One per term.
        """
        terms = " ".join(f"{value:+.3g}*{_bracketed(term)}" for value, term in zip(sizes, self.terms, strict=True))
        head = "1 " if self.location.how == "factor" else ""
        return f"{' and '.join(self.location.quantities)}, {self.location.how}: {head}{terms}"


def _bracketed(term: Feature) -> str:
    return f"({term.text})" if " " in term.text else term.text
