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

from dataclasses import replace
from math import isfinite
from typing import Any

from ...boundary.bounded_file import toml_content
from ...boundary.errors import EffectError, nearest
from ...boundary.escaping import quoted, toml_string
from ...boundary.json_schema import FILLED, by_name, document, list_schema, name_schema, object_schema
from ...boundary.schema_check import check_content
from ..declarations import Coefficient, Effect
from ..detection import Detection
from ..reserved import LONGEST_NAME, STATE_FORM, STATE_NAME
from .checks import LONGEST_FILE, MAX_ACTS, check_effect
from .detection_file import COEFFICIENT, NAME, TEXT, detection_text, read_detection
from .detection_file import KEYS as DETECTION_KEYS
from .effect import Act, AddedEffect
from .state import State
from .state_file import KEYS as STATE_KEYS
from .state_file import read_states, states_text

#: Keys of a coefficient declaration, of [[acts]], of an effect of a chapter and of an added effect, with their schemas.
DECLARATION_KEYS: dict[str, Any] = {
    "description": str, "unit": str, **dict.fromkeys(("lower", "upper", "neutral", "start"), float), "flips": bool,
    "fitted": bool,
}  # fmt: skip
ACT_KEYS: dict[str, Any] = dict.fromkeys(("on", "factor", "term"), FILLED)
CHAPTER_KEYS: dict[str, Any] = {
    "name": NAME, "physics": TEXT, "optional": bool, "rescales": dict[str, float],
    "diagnosis": object_schema(DETECTION_KEYS),
}  # fmt: skip
EFFECT_KEYS: dict[str, Any] = {
    "name": NAME,
    "physics": TEXT,
    "source": TEXT,
    "coefficients": by_name(COEFFICIENT, object_schema(DECLARATION_KEYS)),
    "states": by_name(name_schema(STATE_NAME, LONGEST_NAME, STATE_FORM), object_schema(STATE_KEYS, ["kind", "drive"])),
    "acts": list_schema(object_schema(ACT_KEYS, ["on"]), 1, MAX_ACTS),
    "diagnosis": object_schema(DETECTION_KEYS),
}


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
    return effect_from(_parsed(text, source), source)


def effect_from(table: dict[str, Any], source: str) -> AddedEffect:
    """Return the effect that the content of a file declares, checked as by `read_effect`."""
    check_content(table, effect_schema(), source, EffectError)
    effect = _effect(table, source)
    acts = tuple(_checked(act, f"{source}: [[acts]]") for act in effect.acts)
    states = tuple(_checked_state(state, f"{source}: [states.{state.name}]") for state in effect.states)
    effect = replace(effect, acts=acts, states=states)
    check_effect(effect, source)
    _check_detection(effect, source)
    if unused := {declaration.name for declaration in effect.declarations} - effect.reads:
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
    section = f"TIREFMU_{table['name'].upper()}"
    declarations = tuple(_declaration(name, item, section) for name, item in table.get("coefficients", {}).items())
    detection = read_detection(table["diagnosis"], source) if "diagnosis" in table else None
    acts, states = tuple(_act(act, source) for act in table["acts"]), read_states(table.get("states", {}), source)
    return AddedEffect(table["name"], table["physics"], table.get("source", ""), declarations, acts, detection, states)


def read_declared(text: str, file: str, *, checked: bool = True) -> Effect | AddedEffect:
    r"""Return the effect of a file of a package; without [[acts]] it belongs to the equations of chapters.

    `text`: TOML. In addition to the keys of `read_effect`, a file without [[acts]] may have ``optional`` and
    ``rescales`` (`tirefmu.symbolic.declarations.Effect`). `file`: name of the file: the effect's name and ``.toml``.
    `checked`: false for files that tests check; formulas are never. Raises `EffectError`: as `read_effect`, or if the
    names of file and effect differ.

    >>> read_declared('name = "snow"\nphysics = "less grip"\noptional = true', "snow.toml")
    Effect(name='snow', physics='less grip', rescales=(), optional=True, detection=None)
    """
    table = _parsed(text, file)
    if checked:
        schema = effect_schema() if "acts" in table else object_schema(CHAPTER_KEYS, ["name", "physics"])
        check_content(table, schema, file, EffectError)
    if f"{table['name']}.toml" != file:
        raise EffectError(f"{file}: the file of the effect {quoted(table['name'])} must have the effect's name")
    if "acts" in table:
        return _effect(table, file)
    detection = read_detection(table["diagnosis"], file) if "diagnosis" in table else None
    rescales = tuple(table.get("rescales", {}).items())
    return Effect(table["name"], table["physics"], rescales, table.get("optional", False), detection)


def effect_schema() -> dict[str, Any]:
    """Return the JSON Schema of a user's effect file."""
    return document("effect", "1.2", "Effect of a tire", object_schema(EFFECT_KEYS, ["name", "physics", "acts"]))


def _parsed(text: str, source: str) -> dict[str, Any]:
    if len(text) > LONGEST_FILE:
        raise EffectError(f"{source}: the file of an effect has at most {LONGEST_FILE} characters")
    return toml_content(text, source, EffectError)


def effect_text(effect: AddedEffect) -> str:
    """Return the text of an effect's file. It is stored in the effect: every tire with the effect requests it."""
    stored = vars(effect)
    if "_text" not in stored:
        stored["_text"] = _written(effect)
    return str(stored["_text"])


def _written(effect: AddedEffect) -> str:
    """Return the text of an effect's file, which `effect_text` stores."""
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
        if declaration.fitted is False:
            fields["fitted"] = "false"
        lines.append(f"{declaration.name} = {{{', '.join(f'{key} = {value}' for key, value in fields.items())}}}")
    lines += states_text(effect.states)
    for act in effect.acts:
        lines += ["", "[[acts]]", f"on = {toml_string(act.on)}"]
        lines += [f"{act.how} = {toml_string(act.text)}"]
    if effect.detection is not None:
        lines += ["", detection_text(effect.detection)]
    return "\n".join(lines) + "\n"


def _check_detection(effect: AddedEffect, source: str) -> None:
    """Raise `EffectError` if [diagnosis] has a coefficient of another effect, or a probe exceeds its bounds."""
    declarations = {declaration.name: declaration for declaration in effect.declarations}
    detection, location = effect.detection or Detection(), f"{source}: [diagnosis]"
    forms = (*detection.forms, *detection.refinements)
    for name in (*(name for form in forms for name in form.free), *detection.spread):
        if name not in declarations:
            raise EffectError(f"{location}: {name} is not a coefficient of this effect{nearest(name, declarations)}")
    for name, size in (item for form in forms for probe in form.probes for item in probe.items()):
        declaration = declarations[name]
        if not declaration.lower <= declaration.default + size <= declaration.upper:
            raise EffectError(f"{location} {name}: neutral {declaration.default} and size {size} exceed its bounds")


def _declaration(name: str, table: dict[str, Any], section: str) -> Coefficient:
    declaration = Coefficient(**{"description": "", "fitted": True, **table})
    declaration.name, declaration.section = name, section
    return declaration


def _act(table: dict[str, Any], source: str) -> Act:
    ways = [how for how in ("factor", "term") if how in table]
    if len(ways) != 1:
        raise EffectError(f"{source}: [[acts]]: either factor or term is required")
    return Act(table["on"], ways[0], table[ways[0]])
