"""The file of an effect: physics, coefficients, changed quantities, and its detection by a diagnosis.

Examples
--------
>>> text = '''
... name = "speed_friction"
... physics = "friction changes with speed"
... source = "an example"
... [coefficients]
... VMU1 = {description = "friction, change with speed", unit = "1", lower = -1.0, upper = 1.0}
... [[acts]]
... on = "mu_y"
... factor = "1 + VMU1*log(V/LONGVL)"
... '''
>>> effect = read_effect(text, "example.toml")
>>> effect.acts[0].expression
VMU1*log(V/LONGVL) + 1
>>> read_effect(effect_text(effect), "again.toml") == effect
True
"""

from __future__ import annotations

import sys
from dataclasses import replace
from math import isfinite
from typing import Any

from tirefmu.boundary.bounded_file import toml_content
from tirefmu.boundary.errors import EffectError
from tirefmu.boundary.escaping import quoted, toml_string, visible
from tirefmu.boundary.json_schema import by_name, document, object_schema, tables_schema

from ..declarations import Coefficient, Effect
from ..detection import Detection
from ..reserved import COEFFICIENT_NAME, STATE_NAME, no_coefficient, no_effect
from .checks import LONGEST_FILE, MAX_ACTS, check_effect
from .detection_file import KEYS as DETECTION_KEYS
from .detection_file import NAME, TEXT, detection_text, known_keys, read_detection
from .effect import Act, AddedEffect
from .state import State
from .state_file import KEYS as STATE_KEYS
from .state_file import read_states, states_text

#: Keys of a coefficient declaration and their types.
DECLARATION_KEYS = {"description": str, "unit": str, "lower": float, "upper": float, "neutral": float, "start": float,
             "flips": bool}  # fmt: skip
#: Keys of [[acts]] and of the file with the JSON Schemas of their values.
ACT_KEYS: dict[str, Any] = dict.fromkeys(("on", "factor", "term"), str)
EFFECT_KEYS: dict[str, Any] = {
    "name": NAME,
    "physics": TEXT,
    "source": TEXT,
    "coefficients": by_name(COEFFICIENT_NAME, object_schema(DECLARATION_KEYS)),
    "states": by_name(STATE_NAME, object_schema(STATE_KEYS, ["kind", "drive"])),
    "acts": {**tables_schema(ACT_KEYS, MAX_ACTS, ["on"]), "minItems": 1},
    "diagnosis": object_schema(DETECTION_KEYS),
}
_KINDS = {str: "text", float: "finite number", bool: "truth value: true or false"}
#: Largest finite double.
LARGEST_DOUBLE = sys.float_info.max


def read_effect(text: str, source: str) -> AddedEffect:
    """Return the effect that the text of a file declares.

    Parameters
    ----------
    text : str
        TOML.
    source : str
        Name of the file, for messages.

    Returns
    -------
    AddedEffect
        Checked: names, formulas, units and limits.

    Raises
    ------
    EffectError
        If the text is not TOML, has an entry that an effect cannot have, uses a reserved name
        (`tirefmu.symbolic.reserved`), or exceeds the limits of formulas and texts.
    """
    effect = _effect(_parsed(text, source), source)
    acts = tuple(_checked(act, f"{source}: [[acts]]") for act in effect.acts)
    states = tuple(_checked_state(state, f"{source}: [states.{state.name}]") for state in effect.states)
    effect = replace(effect, acts=acts, states=states)
    check_effect(effect, source)
    _check_sizes(effect, source)
    if unused := {each.name for each in effect.declarations} - effect.reads:
        raise EffectError(f"{source}: {min(unused)} is declared but not used")
    return effect


def _checked(act: Act, location: str) -> Act:
    """Check the formula of an act and return the act with the formula as it is written to files."""
    from .formula import formula, formula_text  # SymPy

    return replace(act, text=formula_text(formula(act.text, location)))


def _checked_state(state: State, location: str) -> State:
    """Check the formulas of a state and return the state with the formulas as they are written to files."""
    from .formula import formula, formula_text  # SymPy

    written = {key: formula_text(formula(text, f"{location} {key}")) for key, text in state.formulas()}
    drive = (written.pop("drive"),) if "drive" in written else state.drive
    changed: dict[str, Any] = {"drive": drive, **written}
    return replace(state, **changed)


def _effect(table: dict[str, Any], source: str) -> AddedEffect:
    """Return the effect of a file, with the formulas as written in the file."""
    known_keys(table, EFFECT_KEYS, source)
    name = _text(table, "name", source)
    declarations = tuple(
        _declaration(key, declaration, source, f"TIREFMU_{name.upper()}")
        for key, declaration in _table(table, source).items()
    )
    acts = table.get("acts")
    if not isinstance(acts, list) or not acts:
        raise EffectError(f"{source}: an effect has at least one [[acts]]")
    return AddedEffect(
        name,
        _text(table, "physics", source),
        _text(table, "source", source) if "source" in table else "",
        declarations,
        tuple(_act(act, source) for act in acts),
        read_detection(table["diagnosis"], source, {declaration.name for declaration in declarations})
        if "diagnosis" in table
        else None,
        read_states(table.get("states", {}), source),
    )


def read_declared(text: str, file: str) -> Effect | AddedEffect:
    r"""Return the effect of a file of the package; without [[acts]] it belongs to the equations of chapters.

    `text`: TOML. In addition to the keys of `read_effect`, a file without [[acts]] may have ``optional`` and
    ``rescales`` (`tirefmu.symbolic.declarations.Effect`). `file`: name of the file: the effect's name and ``.toml``.
    Raises `EffectError`: as `read_effect`, or if the names of file and effect differ.

    >>> read_declared('name = "snow"\nphysics = "less grip"\noptional = true', "snow.toml")
    Effect(name='snow', physics='less grip', rescales=(), optional=True, detection=None)
    """
    table = _parsed(text, file)
    name = _text(table, "name", file)
    if f"{name}.toml" != file:
        raise EffectError(f"{file}: the file of the effect {quoted(name)} must have the effect's name")
    if "acts" in table:  # the tests read these files like files of users
        return _effect(table, file)
    known_keys(table, ("name", "physics", "optional", "rescales", "diagnosis"), file)
    if reason := no_effect(name):
        raise EffectError(f"{file}: name {quoted(name)} {reason}")
    rescales, optional = table.get("rescales", {}), table.get("optional", False)
    if not isinstance(rescales, dict) or not all(map(_is_number, rescales.values())):
        raise EffectError(f"{file}: rescales is not a table of coefficients and factors")
    if not isinstance(optional, bool):
        raise EffectError(f"{file}: optional is not a {_KINDS[bool]}")
    detection = read_detection(table["diagnosis"], file) if "diagnosis" in table else None
    return Effect(name, _text(table, "physics", file), tuple(rescales.items()), optional, detection)


def effect_schema() -> dict[str, Any]:
    """Return the JSON Schema of a user's effect file."""
    return document("effect", "1.0", "Effect of a tire", object_schema(EFFECT_KEYS, ["name", "physics", "acts"]))


def _parsed(text: str, source: str) -> dict[str, Any]:
    if len(text) > LONGEST_FILE:
        raise EffectError(f"{source}: the file of an effect has at most {LONGEST_FILE} characters")
    return toml_content(text, source, EffectError)


def effect_text(effect: AddedEffect) -> str:
    """Return the text of an effect's file."""
    lines = [f"{key} = {toml_string(text)}" for key, text in (("name", effect.name), ("physics", effect.physics))]
    lines += [f"source = {toml_string(effect.source)}"] if effect.source else []
    lines += ["", "[coefficients]"]
    for declaration in effect.declarations:
        numbers = {
            "lower": declaration.lower,
            "upper": declaration.upper,
            "neutral": declaration.default,
            "start": declaration.start,
        }
        fields = {"description": toml_string(declaration.description), "unit": toml_string(declaration.unit)}
        fields |= {key: repr(float(x)) for key, x in numbers.items() if x is not None and isfinite(x)}
        if declaration.flips:
            fields["flips"] = "true"
        lines.append(f"{declaration.name} = {{{', '.join(f'{key} = {value}' for key, value in fields.items())}}}")
    lines += states_text(effect.states)
    for act in effect.acts:
        lines += ["", "[[acts]]", f"on = {toml_string(act.on)}"]
        lines += [f"{act.how} = {toml_string(act.text)}"]
    if effect.detection is not None:
        lines += ["", detection_text(effect.detection)]
    return "\n".join(lines) + "\n"


def _check_sizes(effect: AddedEffect, source: str) -> None:
    """Raise `EffectError` if a probe exceeds the bounds of a coefficient."""
    declarations, detection = (
        {declaration.name: declaration for declaration in effect.declarations},
        effect.detection or Detection(),
    )
    for form in (*detection.forms, *detection.refinements):
        for name, size in (item for probe in form.probes for item in probe.items()):
            declaration = declarations[name]
            if not declaration.lower <= declaration.default + size <= declaration.upper:
                location = f"{source}: [diagnosis] {name}"
                raise EffectError(f"{location}: neutral {declaration.default} and size {size} exceed its bounds")


def _text(table: dict[str, Any], key: str, source: str) -> str:
    value = table.get(key)
    if not isinstance(value, str) or not value.strip():
        raise EffectError(f"{source}: {key} is missing or not a text")
    return value


def _table(table: dict[str, Any], source: str) -> dict[str, Any]:
    declarations = table.get("coefficients", {})
    if not isinstance(declarations, dict):
        raise EffectError(f"{source}: [coefficients] is not a table")
    return declarations


def _declaration(name: str, table: object, source: str, section: str) -> Coefficient:
    if reason := no_coefficient(name):
        raise EffectError(f"{source}: coefficient {quoted(name)} {reason}")
    location = f"{source}: coefficient {name}"
    if not isinstance(table, dict):
        raise EffectError(f"{location} is not a table {{description = ..., unit = ...}}")
    known_keys(table, DECLARATION_KEYS, location)
    for key, value in table.items():
        if not (_is_number(value) if DECLARATION_KEYS[key] is float else isinstance(value, DECLARATION_KEYS[key])):
            raise EffectError(
                f"{location}: {key} = {visible(repr(value))[:80]} is not a {_KINDS[DECLARATION_KEYS[key]]}"
            )
    declaration = Coefficient(**{"description": "", **table})
    declaration.name, declaration.section = name, section
    return declaration


def _is_number(value: object) -> bool:
    """Return whether a value is a number in the range of a double."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= LARGEST_DOUBLE


def _act(table: object, source: str) -> Act:
    location = f"{source}: [[acts]]"
    if not isinstance(table, dict):
        raise EffectError(f"{location} is not a table")
    known_keys(table, ACT_KEYS, location)
    ways = [how for how in ("factor", "term") if how in table]
    if len(ways) != 1:
        raise EffectError(f"{location}: either factor or term is required")
    return Act(_text(table, "on", location), ways[0], _text(table, ways[0], location))
