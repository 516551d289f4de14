"""Identified effects with confidence intervals of their coefficients and their evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from ...numerics.arrays import FloatArray


@dataclass(frozen=True)
class CoefficientInterval:
    """A coefficient's value and its 95 % confidence interval under coloured noise, within the coefficient's bounds."""

    value: float
    lower: float
    upper: float

    def mirrored(self) -> CoefficientInterval:
        """Return the interval with the opposite sign."""
        return CoefficientInterval(turned_sign(self.value), turned_sign(self.upper), turned_sign(self.lower))


class Size(NamedTuple):
    """Change of a force by an effect in the recording, N and N m."""

    rms: float
    largest: float

    @classmethod
    def by_channel(cls, channels: Sequence[str], change: FloatArray) -> dict[str, Size]:
        """Return the sizes of a change of the forces, shape (n_channels, n), without channels that do not change."""
        rows = zip(channels, change, strict=True)
        return {name: cls(float(np.sqrt(np.mean(row**2))), float(np.abs(row).max())) for name, row in rows if row.any()}


@dataclass(frozen=True)
class FoundEffect:
    """An identified missing effect.

    - `channels`: channels that the effect changes.
    - `coefficients`: in the sign convention of the diagnosis.
    - `p`: p-value under coloured noise, adjusted for the number of forms tested.
    - `cv_gain`, `cv_gain_se`: reduction of the squared misfit in blocked cross-validation, as a share, and its standard
      error.
    - `size`: by channel.
    - `flips`: coefficients whose sign depends on the convention.
    - `at_bounds`: coefficients at a bound: the form of the effect is not that of the tire, or the recording does not
      determine it.
    """

    JSON_KEYS: ClassVar = (
        "effect", "probability", "channels", "coefficients", "p", "cv_gain", "cv_gain_se", "when", "size",
    )  # fmt: skip

    effect: Annotated[str, "name, or UNKNOWN for unexplained structure"]
    channels: tuple[str, ...]
    coefficients: Mapping[str, CoefficientInterval]
    p: float
    cv_gain: float
    cv_gain_se: float
    probability: Annotated[float, "of all compared explanations that contain it", {"minimum": 0, "maximum": 1}]
    when: Annotated[tuple[Sequence[float], ...], "stretches of time with most of the evidence, s"] = ()
    size: Mapping[str, Size] = field(default_factory=dict)
    flips: frozenset[str] = frozenset()
    at_bounds: tuple[str, ...] = ()

    def mirrored(self) -> FoundEffect:
        """Return the finding in the other sign convention of coefficients."""
        mirrored = {name: interval.mirrored() for name, interval in self.coefficients.items() if name in self.flips}
        return replace(self, coefficients={**self.coefficients, **mirrored})


@dataclass(frozen=True)
class FormCorrection:
    """The correction of the formula's own form; it is no effect.

    - `channels`: empty if there is none.
    - `delivered`: whether the delivered tire has it.
    """

    channels: Annotated[Mapping[str, Size], "change of the forces by it"]
    delivered: bool

    @property
    def sentence(self) -> str:
        """The sentence of the verdict.

        >>> FormCorrection({"Fy": Size(20.7, 60.0)}, True).sentence
        "The formula's own form errs by 20.7 N rms in Fy within the tested range; corrected"
        """
        sizes = [
            f"{size.rms:.3g} {'N' if name[0] == 'F' else 'N m'} rms in {name}" for name, size in self.channels.items()
        ]
        return f"The formula's own form errs by {', '.join(sizes)} within the tested range; corrected"


def turned_sign(value: float, turned: bool = True) -> float:
    """Return a number with the opposite sign if `turned`; never -0.0."""
    return 0.0 - value if turned else value
