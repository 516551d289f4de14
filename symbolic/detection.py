"""How a diagnosis detects an effect: required inputs, probe sizes, refinements, confounded explanations.

The declaration is the table ``[diagnosis]`` of an effect file (`tirefmu.symbolic.added.detection_file`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import product

#: Prior standard deviation and upper limit of an effect, as a multiple of the size that its file declares.
LARGEST_IN_SIZES = 5.0

Probe = Mapping[str, float]


@dataclass(frozen=True)
class Form:
    """One functional form of an effect.

    - `free`: coefficients that are fitted.
    - `probes`: typical sizes, as differences from the coefficients' neutral values; each probe is a regression column.
      For a coefficient whose neutral value is outside its bounds, the size is the value itself.
    - `scalable`: whether the effect is proportional to its coefficients; otherwise each probe is an initial value of a
      fit.
    - `given`: if the tire has this effect, the form replaces the other forms; '' for none.
    - `holds`: the role of a quantity (`tirefmu.symbolic.contract.ROLES`) that a probe does not change at nominal
      inputs, because its leading coefficient is rescaled; '' for none.
    - `grid`: further coefficients, to which the effect is not proportional, such as time constants. They are fitted as
      well. The probes are applied at each combination of their values (`points`).

    >>> Form.each({"PDY2": -0.15, "PDX2": -0.15}).probes
    ({'PDY2': -0.15}, {'PDX2': -0.15})
    """

    free: tuple[str, ...]
    probes: tuple[Probe, ...]
    scalable: bool = True
    given: str = ""
    holds: str = ""
    grid: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @classmethod
    def each(
        cls, sizes: Mapping[str, float], given: str = "", holds: str = "",
        grid: Mapping[str, tuple[float, ...]] | None = None,
    ) -> Form:  # fmt: skip
        """Return the form that probes every coefficient separately."""
        probes = tuple({name: size} for name, size in sizes.items())
        return cls((*sizes, *(grid or {})), probes, given=given, holds=holds, grid=grid or {})

    def points(self) -> tuple[Form, ...]:
        """Return the form at each point of its grid.

        >>> [form.grid for form in Form.each({"HMU": 0.1}, grid={"HTAU": (2.0, 8.0)}).points()]
        [{'HTAU': (2.0,)}, {'HTAU': (8.0,)}]
        """
        points = product(*self.grid.values())
        return tuple(replace(self, grid={n: (v,) for n, v in zip(self.grid, point, strict=True)}) for point in points)


@dataclass(frozen=True)
class Confounded:
    """A confounded explanation, an effect or a sensor error, and the measurement that separates the two."""

    other: str
    separate_by: str


@dataclass(frozen=True)
class Detection:
    """How a diagnosis detects an effect.

    - `requires`: inputs that must all vary, and outputs that must be measured: the cross-talk of an output can be
      removed only if it is measured.
    - `rate`: rows per second that a recording must have, 0 if any rate is sufficient.
    - `channels`: outputs that the effect changes, one of which must be measured; all if empty.
    - `forms`: from the simplest to the most general, with the coefficients that a model has. If it has none of them, or
      no form is declared, the coefficients of the effect are probed by an eighth of their range.
    - `refinements`: tested if the tire has the effect, so that an error of its form is not identified as a missing
      effect.
    - `contains`: an effect that is a special case of this one, or ''.
    - `spread`: prior standard deviation of coefficients, from the scatter among tires. Default for scalable forms:
      `LARGEST_IN_SIZES` times the size.
    - `separate_by`: the measurement that separates the effect from explanations that are not in `confounded`.
    - `confounded`: known pairs; each is declared in one of the two files.
    """

    requires: tuple[str, ...] = ()
    rate: float = 0.0
    channels: tuple[str, ...] = ()
    forms: tuple[Form, ...] = ()
    refinements: tuple[Form, ...] = ()
    contains: str = ""
    spread: Mapping[str, float] = field(default_factory=dict)
    separate_by: str = ""
    confounded: tuple[Confounded, ...] = ()

    @property
    def prior_center(self) -> dict[str, float]:
        """Prior means of the coefficients of forms that are not scalable: the first initial values of a form."""
        starts: dict[str, float] = {}
        for form in self.forms:
            if not form.scalable and not form.given:
                starts = {**form.probes[0], **starts}
        return starts

    @property
    def prior_spread(self) -> dict[str, float]:
        """The declared spread, and the default spread of the coefficients of scalable forms and refinements."""
        spread = dict(self.spread)
        for form in (*self.forms, *self.refinements):
            if form.scalable and not form.given:
                for probe in form.probes:
                    spread = {**{name: LARGEST_IN_SIZES * abs(size) for name, size in probe.items()}, **spread}
        return spread
