"""How a diagnosis looks for an effect: what has to vary, sizes to probe with, refinements, what it is confounded with.

The declaration is the table ``[diagnosis]`` of an effect's file (`tirefmu.symbolic.added.detection_file`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

#: An effect is believed to be at most this many times as large as the size that its file declares.
LARGEST_IN_SIZES = 5.0

Probe = Mapping[str, float]


@dataclass(frozen=True)
class Form:
    """One functional form of an effect.

    Attributes
    ----------
    free : tuple of str
        The coefficients that a fit frees.
    probes : tuple of mapping of str to float
        Typical sizes, as differences from the coefficients' neutral values; each probe gives a trace of its own. A
        coefficient whose neutral value is a limit outside its bounds takes the size itself.
    scalable : bool
        True where the effect is proportional to its coefficients; otherwise each probe is a start of a fit.
    given : str
        The effect that a tire already has where this form applies instead of the others; '' for none.
    holds : str
        The role of a quantity (`tirefmu.symbolic.contract.ROLES`) that a probe leaves as it is at nominal inputs, by
        rescaling its leading coefficient; '' for none.

    Examples
    --------
    >>> Form.each({"PDY2": -0.15, "PDX2": -0.15}).probes
    ({'PDY2': -0.15}, {'PDX2': -0.15})
    """

    free: tuple[str, ...]
    probes: tuple[Probe, ...]
    scalable: bool = True
    given: str = ""
    holds: str = ""

    @classmethod
    def each(cls, sizes: Mapping[str, float], given: str = "", holds: str = "") -> Form:
        """Return the form in which every coefficient is probed by itself."""
        return cls(tuple(sizes), tuple({name: size} for name, size in sizes.items()), given=given, holds=holds)


@dataclass(frozen=True)
class Confounded:
    """Another explanation for the same forces, an effect or a sensor error, and the measurement that separates both."""

    other: str
    separate_by: str


@dataclass(frozen=True)
class Detection:
    """How a diagnosis looks for an effect.

    Attributes
    ----------
    requires : tuple of str
        Inputs that have to vary, each of them.
    channels : tuple of str
        The outputs in which the effect shows: one of them has to be measured. All where empty.
    forms : tuple of Form
        From the plainest to the richest. A model tries those of the coefficients that it has. Where it has none of
        them, or no form is declared, the coefficients are probed by an eighth of their range.
    refinements : tuple of Form
        Tried where the tire has the effect, so that a base of another form is not taken for a missing effect.
    contains : str
        An effect that is a special case of this one, or ''.
    spread : mapping of str to float
        Standard deviation among tires of coefficients that a recording leaves undetermined. For a scalable form it is
        `LARGEST_IN_SIZES` times the size where nothing is declared.
    separate_by : str
        The measurement that separates the effect from an explanation that `confounded` does not list.
    confounded : tuple of Confounded
        Known pairs; one of the two files declares a pair.
    """

    requires: tuple[str, ...] = ()
    channels: tuple[str, ...] = ()
    forms: tuple[Form, ...] = ()
    refinements: tuple[Form, ...] = ()
    contains: str = ""
    spread: Mapping[str, float] = field(default_factory=dict)
    separate_by: str = ""
    confounded: tuple[Confounded, ...] = ()

    @property
    def prior_center(self) -> dict[str, float]:
        """Where coefficients are believed to lie that have no neutral value of their own: a form's first start."""
        starts: dict[str, float] = {}
        for form in self.forms:
            if not form.scalable and not form.given:
                starts = {**form.probes[0], **starts}
        return starts

    @property
    def prior_spread(self) -> dict[str, float]:
        """The declared spread, and that of the coefficients of scalable forms."""
        spread = dict(self.spread)
        for form in self.forms:
            if form.scalable and not form.given:
                for probe in form.probes:
                    spread = {**{name: LARGEST_IN_SIZES * abs(size) for name, size in probe.items()}, **spread}
        return spread
