"""What was found: effects with their coefficients' intervals and their evidence."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Interval:
    """A coefficient's value and the 95 % interval under coloured noise."""

    value: float
    lower: float
    upper: float

    def mirrored(self) -> Interval:
        """Return the same with the opposite sign."""
        return Interval(turned_sign(self.value), turned_sign(self.upper), turned_sign(self.lower))


@dataclass(frozen=True)
class Finding:
    """A missing effect.

    Attributes
    ----------
    effect : str
        Its name, or "UNKNOWN".
    channels : tuple of str
        Those in which it shows.
    coefficients : mapping of str to Interval
        In the signs of the diagnosis.
    p : float
        Probability of such a response by chance, under coloured noise, adjusted for everything tried.
    cv_gain, cv_gain_se : float
        Share of the squared misfit that it takes away in blocked cross-validation, and its standard error.
    when : tuple of (float, float)
        The stretches of time, s, that carry most of the evidence.
    """

    effect: str
    channels: tuple[str, ...]
    coefficients: Mapping[str, Interval]
    p: float
    cv_gain: float
    cv_gain_se: float
    when: tuple[tuple[float, float], ...] = ()

    def mirrored(self, names: Collection[str]) -> Finding:
        """Return the same with the opposite sign of some coefficients."""
        coefficients = {name: one.mirrored() if name in names else one for name, one in self.coefficients.items()}
        return replace(self, coefficients=coefficients)


def turned_sign(value: float, turned: bool = True) -> float:
    """Return a number with the opposite sign, or as it is; never -0.0."""
    return 0.0 - value if turned else value
