"""A tire as plain values for the page: coefficients, effects, inputs, outputs, and which coefficient acts when.

The .tir file is divided so that the page can write it with changed values and effects.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import degrees, isfinite
from typing import Any

from ...boundary.escaping import excerpt, file_name
from ...drawing.labels import ZERO_CELSIUS
from ...symbolic.channels import CHANNELS
from ...symbolic.declarations import Coefficient, Quantity
from ...tires import Tire
from ...tires.definition import RANGES as RANGE_KEYS
from ...tires.property_file.names import ASSUMED, is_measured, listed, unmeasured_coefficients, unmeasured_outputs
from ...tires.property_file.writing import tir_text

#: Units of the sliders, and the factors from SI values; all other units are SI units.
_SHOWN = {"rad": ("deg", degrees(1.0)), "Pa": ("kPa", 1e-3), "1": ("", 1.0)}
_SHOWN |= {"degC": ("deg C", 1.0), "K": ("deg C", 1.0)}
#: Ranges of the sliders of inputs, in SI units, where neither the tire nor a recording has a range.
RANGES = {name: channel.typical for name, channel in CHANNELS.items() if channel.typical} | {"distance": (0.0, 5000.0)}
#: Range of a temperature of the tire, K.
NODE_RANGE = (253.15, 423.15)
#: Range of an input that is positive, as shares of its nominal value.
SHARES = (0.1, 2.5)
#: Room of a slider on each side of a fitted value, as a multiple of the 95 % interval.
SLIDER = 3.0
#: Roles of quantities that are drawn.
ROLES = ("friction_x", "friction_y", "stiffness_x", "stiffness_y", "weighting_x", "weighting_y")
#: Groups of coefficients that no effect owns.
CORE = "core"


def shown(unit: str) -> tuple[str, float]:
    """Return the unit in which an input is shown, and the factor from its SI value.

    >>> shown("Pa"), shown("N")
    (('kPa', 0.001), ('N', 1.0))
    """
    return _SHOWN.get(unit, (unit, 1.0))


def zero_of(unit: str) -> float:
    """Return the SI value that is shown as 0: all temperatures are shown in deg C."""
    return ZERO_CELSIUS if unit == "K" else 0.0


def switchable(tire: Tire) -> Tire:
    """Return a tire with the effects that can be switched: its own and all that a tire of its model has by default.

    Its forces are the same: coefficients of effects that were absent have their neutral values.

    `tire`: in ISO-W.
    """
    effects = tire.symbolic_model.default_effects | tire.has
    absent = tire.symbolic_model.owned(*sorted(tire.symbolic_model.effects.keys() - tire.has))
    given = {name: value for name, value in tire.values.items() if name not in tire.defaulted or name in absent}
    return replace(tire, values=given, effects=effects)


def tire_data(
    tire: Tire,
    name: str,
    read: Mapping[str, float],
    intervals: Mapping[str, tuple[float, float]],
    lags: Sequence[Quantity],
) -> dict[str, Any]:
    """Return what the page shows of a tire.

    `tire`: in ISO-W. `name`: shown where the tire has no name. `read`: the coefficients that the page's code reads:
    they have sliders, except the ends of ranges of inputs. `intervals`: 95 % intervals of coefficients in ISO-W.
    `lags`: the lagged slips of the page's code. Returns: JSON values.
    """
    whole = switchable(tire)
    model = whole.symbolic_model
    effects = {name: effect for name, effect in model.effects.items() if name in whole.has}
    # The ends of a range are not properties that a slider could change independently; start temperatures are inputs.
    ends = {name for pair in RANGE_KEYS.values() for name in pair} | _starts(whole).keys()
    adjustable = read.keys() - ends
    owners = {name: _owner(whole, name) for name in model.coefficients}
    unmeasured = unmeasured_coefficients(tire)
    return {
        "name": excerpt(tire.name or name, 80),
        "file_name": file_name(tire.name or name, "tire"),
        "model": model.name,
        "title": model.title,
        "inputs": _inputs(whole),
        "outputs": [
            {"name": q.name, "unit": q.unit, "text": q.description, "measured": q.name not in unmeasured_outputs(tire)}
            for q in model.outputs
        ],
        "roles": {role: _quantity(tire, role) for role in ROLES if model.quantity(role)},
        "states": [_state(whole, name) for name in model.states],
        "lags": [{"name": lag.name, "text": lag.description, "unit": ""} for lag in lags],
        "coefficients": [
            _coefficient(declared, whole.values[key], owners[key], key in adjustable, intervals.get(key))
            | {"measured": key not in unmeasured}
            for key, declared in model.coefficients.items()
        ],
        "effects": [
            {"name": key, "text": excerpt(effect.physics), "on": key in tire.has, "rescales": list(effect.rescales),
             "added": key in {added.name for added in model.added},
             "input": dict(model.on_demand).get(key, "")}
            for key, effect in effects.items()
        ],
        "targets": sorted({q.name for q in model.outputs} | set(model.results)),
        "lines": [
            [line.name, line.effects, [*line.earlier],
             [[*condition, c.number, c.reads] for condition, c in zip(line.conditions(), line.cases, strict=True)]]
            for line in model.structure.lines
        ],
        "file": property_file_template(whole),
    }  # fmt: skip


def _quantity(tire: Tire, role: str) -> dict[str, Any]:
    name = tire.symbolic_model.quantity(role)
    unit, text = tire.symbolic_model.structure.quantities[name]
    measured = is_measured(tire, role)
    text = excerpt(text.partition(";")[0])  # without its remarks
    return {"name": name, "unit": "" if unit == "1" else unit, "text": text, "measured": measured}


def _state(tire: Tire, name: str) -> dict[str, Any]:
    state = tire.symbolic_model.states[name]
    target, _, start, _ = state.line_names
    unit, zero = shown(state.unit)[0], zero_of(state.unit)
    effects = [
        effect
        for effect in tire.symbolic_model.effects
        if effect in tire.has and name in tire.symbolic_model.states_of([effect])
    ]
    return {
        "name": name, "text": excerpt(state.description or name), "unit": unit, "zero": zero,
        "settles": state.settles, "declares_start": state.has_start_value, "temperature": state.is_temperature,
        "target": target, "start": start,
        "lines": state.line_names, "effects": effects,
    }  # fmt: skip


def _owner(tire: Tire, name: str) -> str:
    """Return the effect under which a coefficient is listed: of several owners the one with the fewest coefficients."""
    owned = {effect: tire.symbolic_model.owned(effect) for effect in tire.symbolic_model.effects if effect in tire.has}
    owners = [effect for effect, names in owned.items() if name in names]
    return min(owners, key=lambda effect: len(owned[effect]), default=CORE)


def _coefficient(
    declared: Coefficient, value: float, owner: str, read: bool, interval: tuple[float, float] | None
) -> dict[str, Any]:
    """Return a coefficient; the bounds are those of its slider and contain its value."""
    lower, upper = declared.lower, declared.upper
    if declared.flips:
        lower, upper = -upper, -lower
    room = abs(value) or 1.0
    lower = lower if isfinite(lower) else min(value, 0.0) - room
    upper = upper if isfinite(upper) else max(value, 0.0) + room
    ends = [end for end in interval or () if isfinite(end)]
    if len(ends) == 2 and ends[0] < ends[1]:  # the slider has room for what the data allow, not for all tires
        lower, upper = (min(max(value + side * SLIDER * (ends[1] - ends[0]), lower), upper) for side in (-1.0, 1.0))
    fitted = declared.fitted
    return {
        "name": declared.name,
        "value": value,
        "neutral": declared.neutral,
        "unit": "" if declared.unit == "1" else declared.unit,
        "text": excerpt(declared.description),
        "lower": min(lower, value, *ends),
        "upper": max(upper, value, *ends),
        "owner": owner,
        "group": declared.channels[0] if fitted and declared.channels else declared.section,
        "read": read,
        "interval": ends,
    }


def _starts(tire: Tire) -> dict[str, str]:
    """Return the temperature that each coefficient is the start of."""
    states = tire.symbolic_model.states
    return {state.start: name for name, state in states.items() if state.is_temperature and state.start in tire.values}


def _inputs(tire: Tire) -> list[dict[str, Any]]:
    """Return the inputs of the page: those of the tire, and the temperatures of its parts."""
    model, nodes = tire.symbolic_model, _starts(tire).items()
    given = [quantity for quantity in model.inputs if quantity.name not in model.states]
    listed = [
        (quantity.name, quantity.description, quantity.unit, tire.nominal(quantity.name),
         tire.ranges.get(quantity.name) or RANGES.get(quantity.name)) for quantity in given
    ]  # fmt: skip
    for start, name in nodes:
        listed.append((name, model.states[name].description, model.states[name].unit, tire.values[start], NODE_RANGE))
    inputs = []
    for name, text, of, nominal, ends in listed:
        unit, scale = shown(of)
        low, high = ends or (SHARES[0] * nominal, SHARES[1] * nominal)
        inputs.append(
            {"name": name, "text": text, "unit": unit, "scale": scale, "zero": zero_of(of), "nominal": nominal,
             "low": min(low, nominal), "high": max(high, nominal)}
        )  # fmt: skip
    return inputs


#: A section, and a line with a value: the key, the value, a comment.
_SECTION = re.compile(r"\[(.*)\]")
_ENTRY = re.compile(r"(\w+) = (\S+)(.*)")
#: Key of the remark in `Tire.about` that lists what was changed on the page.
CHANGES = "changed"


def property_file_template(tire: Tire) -> list[Any]:
    """Return the lines of a tire's .tir file; those that depend on the state of the page are objects.

    `tire`: in ISO-W, with every effect that can be switched on the page. Returns: ``{"coefficient": name, "rest":
    comment}`` is the line of a coefficient, ``{"assumed": names, "title": section}`` the list of coefficients that the
    tire's file did not have. The page writes the entries of [TIREFMU] that depend on the effects at ``{"effects":
    True}``, and what was changed at ``{"changes": True}``.

    >>> from tirefmu.tires import published
    >>> lines = property_file_template(published("trento_hoosier").in_signs("iso"))
    >>> next(line for line in lines if isinstance(line, dict))["coefficient"]
    'UNLOADED_RADIUS'
    """
    sections = {name: declaration.section for name, declaration in tire.symbolic_model.coefficients.items()}
    lines: list[Any] = []
    section, has_about = "", False
    for line in tir_text(tire).splitlines():
        if heading := _SECTION.fullmatch(line):
            section = heading[1]
            has_about = has_about or section == "TIREFMU_ABOUT"
        entry = _ENTRY.fullmatch(line)
        key = entry[1] if entry else ""
        if entry and sections.get(key) == section:
            lines.append({"coefficient": key, "rest": entry[3]})
        elif entry and section == ASSUMED:
            lines.append({"assumed": list(listed(line.partition(" = ")[2])), "title": key})
        elif not _replaced(section, key):
            lines.append(line)
        if (section, key) == ("TIREFMU", "NAME"):
            lines.append({"effects": True})
        elif line == "[TIREFMU_ABOUT]":
            lines.append({"changes": True})
    return lines if has_about else [*lines, "", "[TIREFMU_ABOUT]", {"changes": True}]


def _replaced(section: str, key: str) -> bool:
    """Return whether the page writes its own entry instead."""
    if section == "TIREFMU":
        return key == "EFFECTS" or key.startswith("CORE_")
    return (section, key) == ("TIREFMU_ABOUT", CHANGES.upper())
