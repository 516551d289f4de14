"""What the user of a tire has to know: effects that do nothing, and what the data of its fit did not show."""

from __future__ import annotations

from collections.abc import Iterable

from .definition import TireDefinition
from .property_file.names import not_measured


def idle_effects(tire: TireDefinition) -> list[str]:
    """Return the effects of a tire that do nothing: their coefficients are neutral, but for references.

    >>> from tirefmu.tires import published
    >>> "camber_thrust" in idle_effects(published("trento_hoosier"))
    False
    """
    model, plain = tire.symbolic_model, tire.in_signs("adapted-sae")
    neutral = {name: declaration.neutral for name, declaration in model.coefficients.items()}
    idle = []
    for effect in (name for name in model.effects if name in tire.has):
        switched = [name for name in model.owned(effect) if neutral[name] is not None]
        if switched and all(plain.values[name] == neutral[name] for name in switched):
            idle.append(effect)
    return idle


def idle_notes(names: Iterable[str]) -> list[str]:
    """Return a sentence on each effect that does nothing.

    >>> idle_notes(["relax_mf"])
    ['the effect relax_mf does nothing: its coefficients have neutral values']
    """
    return [f"the effect {name} does nothing: its coefficients have neutral values" for name in names]


def limits_of(tire: TireDefinition) -> list[str]:
    """Return a sentence on each effect beyond those of its model that does nothing, and on what was not measured.

    The effects of a model do nothing in most tires; further ones were asked for.
    """
    idle = (name for name in idle_effects(tire) if name not in tire.symbolic_model.default_effects)
    return [*idle_notes(idle), *not_measured(tire).values()]
