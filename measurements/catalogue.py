"""Lists for the user: effects, models, published tires, columns of tables, as plain values."""

from __future__ import annotations

from math import isfinite
from typing import Any

from ..boundary.errors import UnknownName
from ..symbolic.added import AddedEffect, library
from ..symbolic.channels import CHANNELS
from ..symbolic.declarations import Coefficient, Effect
from ..symbolic.effects import EFFECTS
from ..symbolic.models import MODELS, model_named
from ..tires import published
from .units import UNITS_OF_TABLES

#: How a tire comes to have an effect: with the model, on request, or as an addition to any model.
KINDS = ("default", "optional", "library")


def columns() -> list[dict[str, Any]]:
    """Return the columns of tables with their units and names, as JSON values in the order of the contract.

    >>> [column["ttc"] for column in columns() if column["name"] == "alpha"]
    [['SA']]
    """
    return [
        {
            "name": channel.name,
            "meaning": channel.meaning,
            "role": "output" if channel.role == "output" else "input",
            "unit": channel.unit,
            "units": list(UNITS_OF_TABLES.get(channel.quantity, ())),
            "ttc": list(channel.bench_names),
            "aliases": list(channel.aliases),
        }
        for channel in CHANNELS.values()
    ]


def effects(name: str | None = None, only_model: str | None = None) -> list[dict[str, Any]]:
    """Return the effects, each with its mechanism, models, coefficients and how a diagnosis finds it.

    `name`: only this effect. `only_model`: only effects that a tire of this model can have. Returns: JSON values, by
    kind and name. Raises `UnknownName` if the effect or the model does not exist.

    >>> [found["models"] for found in effects("speed_friction")]
    [['mf52', 'mf61', 'mf62']]
    """
    if only_model is not None:
        model_named(only_model)  # raises for an unknown one
    available: dict[str, Effect | AddedEffect] = {**EFFECTS, **library()}
    for model in MODELS.values():
        available |= {effect.name: effect for effect in model.source.own_effects}
    if name is not None and name not in available:
        raise UnknownName("effect", name, available)
    effects = [_effect(effect) for effect in available.values() if name in (None, effect.name)]
    effects = [effect for effect in effects if only_model is None or only_model in effect["models"]]
    return sorted(effects, key=lambda effect: (KINDS.index(effect["kind"]), effect["name"]))


def _effect(effect: Effect | AddedEffect) -> dict[str, Any]:
    added = isinstance(effect, AddedEffect)
    if isinstance(effect, AddedEffect):
        models = [name for name, model in MODELS.items() if model.has_place_for(effect)]
        coefficients = {declared.name: _coefficient(declared) for declared in effect.declarations}
    else:
        models = [name for name, model in MODELS.items() if effect.name in model.effects]
        owned = [(MODELS[name], key) for name in models for key in sorted(MODELS[name].owned(effect.name))]
        coefficients = {key: _coefficient(model.coefficients[key]) for model, key in owned}
    optional = not added and any(MODELS[name].effects[effect.name].optional for name in models)
    detection = effect.detection
    return {
        "name": effect.name,
        "kind": "library" if added else "optional" if optional else "default",
        "physics": effect.physics,
        "source": getattr(effect, "source", ""),
        "models": models,
        "coefficients": coefficients,
        "formulas": [{"on": act.on, act.how: act.text} for act in getattr(effect, "acts", ())],
        "states": [state.name for state in getattr(effect, "states", ())],
        "needs": list(detection.requires) if detection else [],
        "channels": list(detection.channels) if detection else [],
        "confounded_with": [pair.other for pair in detection.confounded] if detection else [],
        "separate_by": detection.separate_by if detection else "",
    }


def _coefficient(declared: Coefficient) -> dict[str, Any]:
    bounds = [bound if isfinite(bound) else None for bound in (declared.lower, declared.upper)]
    return {"description": declared.description, "unit": declared.unit, "bounds": bounds}


def models() -> list[dict[str, Any]]:
    """Return the models: name, title, inputs, outputs, number of coefficients, effects.

    >>> [(found["name"], found["outputs"]) for found in models()][-1]
    ('mf96', ['Fx', 'Fy', 'Mz'])
    """
    return [
        {
            "name": name,
            "title": model.title,
            "inputs": [quantity.name for quantity in model.inputs],
            "outputs": [quantity.name for quantity in model.outputs],
            "coefficients": len(model.coefficients),
            "effects": sorted(model.default_effects),
            "recipes": list(model.fit.recipes),
        }
        for name, model in MODELS.items()
    ]


def published_tires() -> list[dict[str, Any]]:
    """Return the published tires: name, model, nominal load and radius, ranges, source.

    >>> [(found["name"], found["model"]) for found in published_tires()]
    [('trento_hoosier', 'mf96'), ('unicamp_small_tire', 'mf61')]
    """
    tires = []
    for name in published():
        tire = published(name)
        tires.append(
            {
                "name": name,
                "tire": tire.name,
                "model": tire.model,
                "Fz0": tire.values["FNOMIN"],
                "R0": tire.values["UNLOADED_RADIUS"],
                "signs": tire.signs,
                "ranges": {key: list(ends) for key, ends in tire.ranges.items()},
                "about": dict(tire.about),
            }
        )
    return tires
