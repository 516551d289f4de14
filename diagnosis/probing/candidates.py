"""Candidate effects of a diagnosis: the declarations of their files, for the coefficients that a model has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...symbolic.channels import OUTPUTS
from ...symbolic.declarations import Coefficient
from ...symbolic.detection import Detection, Form
from ...symbolic.model import Model
from ...tires.tire import Tire
from ..signals.signals import Signals
from ..thresholds import MAX_BLOCKS, MIN_VARIATION

#: The same in standard deviations of the input's noise. Not recorded.
MIN_VARIATION_IN_NOISE = 4.0

#: Inputs whose common deviation from zero an effect of two of them requires.
SLIPS = ("kappa", "alpha", "gamma", "phit")
#: The steps of a recording may be longer by this factor than the declared rate requires.
RATE_TOLERANCE = 1.02
#: The name of the baseline model without effects, whose errors are refinements.
CORE = "core"


@dataclass(frozen=True)
class Candidate:
    """An effect that the model may lack.

    - `forms`: from the simplest to the most general.
    - `requires`: inputs that must all vary, and outputs that must be measured.
    - `reads`: what it requires, and the inputs that lines of its own read: errors of its form depend on these.
    - `channels`: outputs that the effect changes.
    - `contains`: an effect that is a special case of this one, or ''.
    - `has_states`: whether it depends on the past by states of its own, or on the rate of an input.
    - `rate`: rows per second that a recording must have.
    """

    forms: tuple[Form, ...]
    requires: tuple[str, ...]
    channels: tuple[str, ...]
    contains: str = ""
    has_states: bool = False
    rate: float = 0.0
    reads: frozenset[str] = frozenset()


def candidates_for(tire: Tire) -> dict[str, Candidate]:
    """Return the effects that a tire lacks and that its model supports.

    `tire`: library and user-defined effects are in its `added` ones. Returns: in alphabetical order.
    """
    model = tire.symbolic_model
    present = [detection for name, detection in model.detections.items() if name in tire.has]
    names = sorted(model.effects.keys() - tire.has - {detection.contains for detection in present})
    candidates = {name: declared_candidate(name, model, tire.has) for name in names}
    return {name: candidate for name, candidate in candidates.items() if candidate}


def declared_candidate(name: str, model: Model, present: frozenset[str] = frozenset()) -> Candidate | None:
    """Return the candidate that an effect file or the model declares, or None.

    `present`: the effects that a tire has. Returns: if the model has none of the declared coefficients, or none is
    declared, the coefficients of the effect are probed by their bounds.
    """
    detection, declarations = model.detections.get(name, Detection()), model.coefficients
    channels, forms, added = detection.channels or OUTPUTS, detection.forms, {effect.name for effect in model.added}
    if any(set(form.free) & declarations.keys() for form in forms):
        given = present.intersection(form.given for form in forms) or {""}
        forms = tuple(form for form in forms if form.given in given)
    else:
        declaring = added.union(model.detections, (effect.name for effect in model.source.own_effects))
        names = model.owned(name) if name in declaring.intersection(model.effects) else ()
        owned = [declarations[key] for key in declarations if key in names and declarations[key].neutral is not None]
        if not owned:
            return None
        forms = (_by_bounds(owned),)
        if name not in added:
            channels = tuple(dict.fromkeys(channel for declaration in owned for channel in declaration.channels))
    stateful = any(effect.states for effect in model.added if effect.name == name)
    reads = model.read_by(name).union(detection.requires)
    return Candidate(forms, detection.requires, channels, detection.contains, stateful, detection.rate, reads)


def _by_bounds(declarations: Sequence[Coefficient]) -> Form:
    """Return the form that probes each coefficient by an eighth of its range."""
    sizes = {}
    for declaration in declarations:
        start = 0.0 if counts_from_neutral(declaration) else declaration.default
        sizes[declaration.name] = (declaration.upper - declaration.default) / 8.0 + start
    return Form.each(sizes)


def counts_from_neutral(declaration: Coefficient) -> bool:
    """Return whether the size of a probe is a difference from the neutral value, not the value itself."""
    return declaration.neutral is not None and declaration.lower <= declaration.neutral <= declaration.upper


def refinements_for(tire: Tire, identified: frozenset[str]) -> list[tuple[str, Form]]:
    """Return the refinements of the baseline and of the effects that a model has, each with its effect or `CORE`.

    `identified`: the identified effects.
    """
    forms = [(CORE, Form.each(sizes)) for sizes in tire.symbolic_model.baseline.refinements]
    return forms + [
        (name, form)
        for name, detection in sorted(tire.symbolic_model.detections.items())
        if name in tire.has | identified
        for declared in detection.refinements
        for form in declared.points()
    ]


def is_testable(signals: Signals, tire: Tire, candidate: Candidate) -> bool:
    """Return whether a recording is fast enough for a candidate, and its inputs vary (`excited`)."""
    return rows_per_second(signals) >= candidate.rate and excited(signals, tire, candidate.requires)


def rows_per_second(signals: Signals) -> float:
    """Return the median rate of a recording, infinite if it has no time and its rate does not matter."""
    if not signals.timed:
        return float("inf")
    steps = np.diff(signals.t)
    return RATE_TOLERANCE / float(np.median(steps[steps > 0.0]))


def excited(signals: Signals, tire: Tire, names: Sequence[str]) -> bool:
    """Return whether inputs vary by more than their noise in a recording, and jointly.

    An effect of two inputs is not determined if one of them varies only while the other one is constant: in a
    recording of pure slip, noise of kappa times the slope of a curve resembles combined slip.

    `names`: inputs, "t", or outputs, which must be measured.
    """
    if not all(varies(signals, tire, name) for name in names):
        return False
    inputs = [name for name in names if name in SLIPS]
    if len(inputs) < 2:
        return True
    named = signals.named()
    away = [np.abs(named[name]) > 0.5 * _least_variation(signals, tire, name) for name in inputs]
    return float(np.mean(np.all(away, axis=0))) > 1.0 / MAX_BLOCKS  # one block, the least that can be left out


def varies(signals: Signals, tire: Tire, name: str) -> bool:
    """Return whether an input varies by more than its noise in a recording, or an output is measured."""
    if name == "t":
        return signals.timed
    if name in OUTPUTS:
        return name in signals.channels
    if name not in signals.origin.recorded | signals.origin.derived or name not in signals.names:
        return False
    values = signals.named()[name]
    return float(values.max() - values.min()) > _least_variation(signals, tire, name)


def _least_variation(signals: Signals, tire: Tire, name: str) -> float:
    least = MIN_VARIATION.get(name, 0.0) * (tire.nominal(name) if name in ("Fz", "V") else 1.0)
    return max(least, MIN_VARIATION_IN_NOISE * signals.origin.noise.get(name, 0.0), 1e-9)
