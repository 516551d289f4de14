"""Summary of a tire as plain values, for ``tirefmu info``."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from typing import Any

import numpy as np

from ..symbolic.declarations import Coefficient
from ..symbolic.models import MODELS
from . import Tire
from .definition import TireDefinition, default_loads
from .evaluation import quantities
from .implausible import implausible
from .property_file.names import MAX_SEARCHED, OWN_SECTIONS, near_miss, not_given, not_measured, unit_of
from .property_file.text import number_and_rest
from .property_file.use import transient_notes
from .summary import idle_effects, idle_notes

#: Sections without information about the tire, or with information reported elsewhere.
_OURS = ("MDI_HEADER", *OWN_SECTIONS)
#: Roles of the quantities that a summary lists over load.
CHARACTERISTICS = ("friction_x", "friction_y", "stiffness_x", "stiffness_y")


def describe(tire: Tire, notes: Iterable[str] = ()) -> dict[str, Any]:
    """Return a summary of a tire: model, effects, ranges, sources of its values, warnings.

    `notes`: notes from reading its file. Returns: plain JSON values. ``missing`` has the assumed values of coefficients
    that the file lacks, ``assumed`` those of them that are properties without a neutral value, such as a radius;
    ``unknown`` the unknown keys of the file, with the nearest coefficient; ``unused`` known keys that this model does
    not read; ``ignored`` those of them that are coefficients of other models and not zero; ``tables`` the sections with
    lines that are not keys.

    >>> from tirefmu.tires import published
    >>> summary = describe(published("trento_hoosier"))
    >>> summary["model"], summary["nominal"]["Fz"], [doubt["name"] for doubt in summary["implausible"]]
    ('mf96', 220.0, ['E_t'])
    """
    model, plain = tire.symbolic_model, tire.in_signs("adapted-sae")
    declared = model.coefficients
    at_neutral = [
        name
        for name, declaration in declared.items()
        if declaration.neutral is not None and plain.values[name] == declaration.neutral
    ]
    idle = idle_effects(tire)
    stored, entries = tire.other_entries, _entries(tire)
    unknown = [entry for entry in entries if unit_of(entry["key"]) is None]
    missing = {name: tire.values[name] for name in not_given(tire)}
    near = {entry["key"]: near_miss(entry["key"], declared) for entry in unknown[:MAX_SEARCHED]}
    return {
        "ok": True,
        "name": tire.name,
        "model": tire.model,
        "title": model.title,
        "signs": tire.signs,
        "side": tire.side,
        "about": dict(tire.about),
        "nominal": {name: tire.nominal(name) for name in tire.inputs if name not in model.states},
        "ranges": {name: list(bounds) for name, bounds in tire.ranges.items()},
        "effects": [name for name in model.effects if name in tire.has and name not in idle],
        "effects_at_neutral": idle,
        "effects_absent": [name for name in model.effects if name not in tire.has],
        "coefficients_at_neutral": at_neutral,
        "not_measured": list(not_measured(tire).values()),
        "missing": missing,
        "assumed": {name: value for name, value in missing.items() if _is_property(declared[name], value)},
        "unknown": [{**entry, "near": near.get(entry["key"])} for entry in unknown],
        "unused": [e for e in entries if unit_of(e["key"]) is not None],
        "ignored": ignored_coefficients(tire),
        "tables": list(dict.fromkeys(section for section, key, _ in stored if not key)),
        "notes": list(notes),
        "characteristics": _characteristics(tire),
        "implausible": [
            {"name": doubt.name, "value": doubt.value if isfinite(doubt.value) else None, "reason": doubt.reason}
            for doubt in implausible(tire)
        ],
        "values": dict(tire.values),
    }


def ignored_coefficients(tire: TireDefinition) -> list[dict[str, str]]:
    """Return the entries of the file of a tire that are coefficients of other models and not zero."""
    return [entry for entry in _entries(tire) if _is_influential(entry["key"], entry["value"])]


def _entries(tire: TireDefinition) -> list[dict[str, str]]:
    """Return the entries of the file of a tire that its model does not read, without those of tirefmu."""
    return [
        {"section": section, "key": key, "value": value}
        for section, key, value in tire.other_entries
        if key and section not in _OURS
    ]


def _characteristics(tire: Tire) -> list[dict[str, float]]:
    """Return friction and slip stiffness of the upright tire in pure slip, at loads of its range."""
    loads = default_loads(tire)
    computed = {"Fz": np.array(loads), **quantities(tire.in_signs("iso"), {"Fz": loads})}
    listed = map(tire.symbolic_model.quantity, CHARACTERISTICS)
    names = ["Fz", *(name for name in listed if name in computed)]
    return [{name: float(computed[name][i]) for name in names} for i in range(len(loads))]


def limits_of(tire: TireDefinition) -> list[str]:
    """Return sentences on effects that do nothing, on slips that do not lag, and on what was not measured.

    The effects of a model do nothing in most tires; only further ones, which were requested, are named.
    """
    idle = (name for name in idle_effects(tire) if name not in tire.symbolic_model.default_effects)
    return [*idle_notes(idle), *transient_notes(tire), *not_measured(tire).values()]


def _is_property(declared: Coefficient, value: float) -> bool:
    """Return whether a value is a property of the tire, with a unit, that has no neutral value."""
    return declared.neutral is None and not declared.fitted and declared.unit != "1" and value != 0.0


def _is_influential(key: str, value: str) -> bool:
    """Return whether a key is a fitted coefficient of some model with a value other than zero."""
    declared = [model.coefficients[key] for model in MODELS.values() if key in model.coefficients]
    number, _ = number_and_rest(value)
    return any(declaration.fitted for declaration in declared) and isfinite(number) and number != 0.0
