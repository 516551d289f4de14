"""Additions to an FMU with wheel motion for standstill: a damper, and relaxation lengths if a tire has none."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from ...tires import Tire
from .variables import Variable

#: Relaxation length of a slip for which a tire has none, per free radius.
DEFAULT_LENGTH = 0.5
LOW_SPEED = Variable("LOW_SPEED", "parameter", "m/s", "speed below which standstill is approximated", 1.0, 1e-3, inf)
LOW_SPEED_DAMPING = Variable(
    "LOW_SPEED_DAMPING", "parameter", "1", "damping ratio of the tire at standstill", 0.7, 0.0, inf
)
FRICTION_LIMIT = Variable(
    "FRICTION_LIMIT", "parameter", "1",
    "share of the force beyond the friction ellipse that is removed above walking speed", 0.0, 0.0, 1.0,
)  # fmt: skip
DEFAULT_SIGMA = Variable(
    "DEFAULT_SIGMA", "parameter", "m", "relaxation length of a slip for which the tire has none", 0.15, 0.0, inf
)


def with_lengths(tire: Tire) -> tuple[Tire, str]:
    """Return a tire with relaxation lengths for an FMU with wheel inputs, and a note about assumed ones.

    A tire that has relaxation is returned itself, with an empty note. Otherwise it has the lengths of its model, such
    as sigma = K/c of the Magic Formula, provided that the tire has values of the coefficients they need.

    >>> from tirefmu.tires import published
    >>> tire, note = with_lengths(published("trento_hoosier"))
    >>> tire.lags, note
    (False, 'the tire has no relaxation: the relaxation lengths are half of its free radius, 0.115 m (DEFAULT_SIGMA)')
    """
    if tire.lags:
        return tire, ""
    half = f"half of its free radius, {_default_length(tire):.3g} m (DEFAULT_SIGMA)"
    scale, *needed = tire.symbolic_model.motion.own_relaxation or ("",)
    if not scale or set(needed) & set(tire.defaulted):
        return tire, f"the tire has no relaxation: the relaxation lengths are {half}"
    (effect,) = (
        effect for effect in tire.symbolic_model.relaxing_effects if scale in tire.symbolic_model.owned(effect)
    )
    given = {name: value for name, value in tire.values.items() if name not in tire.defaulted}
    relaxing = replace(tire, effects=tire.has | {effect}, values={**given, scale: 1.0})
    return relaxing, (
        f"the tire has no relaxation: the relaxation lengths are those of its model ({scale} = 1);"
        f" where they are 0, {half}"
    )


def standstill_parameters(tire: Tire) -> tuple[Variable, ...]:
    """Return the parameters of standstill.

    Returns: the start value of LOW_SPEED is the model's own low speed, if any.

    >>> from tirefmu.tires import published
    >>> [variable.name for variable in standstill_parameters(published("trento_hoosier"))]
    ['LOW_SPEED', 'LOW_SPEED_DAMPING', 'DEFAULT_SIGMA', 'FRICTION_LIMIT']
    """
    declared = tire.values.get(tire.symbolic_model.motion.low_speed, 0.0)
    return (
        replace(LOW_SPEED, start=declared if declared >= LOW_SPEED.lower else LOW_SPEED.start),
        LOW_SPEED_DAMPING,
        replace(DEFAULT_SIGMA, start=_default_length(tire)),
        FRICTION_LIMIT,
    )


def _default_length(tire: Tire) -> float:
    """Return a typical relaxation length where the tire does not determine one, m."""
    return DEFAULT_LENGTH * tire.values["UNLOADED_RADIUS"]
