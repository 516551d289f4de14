"""The file of an effect: its physics, coefficients, what it acts on, how a diagnosis looks for it.

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
import tomllib
from dataclasses import dataclass
from math import isfinite
from typing import Any

import sympy as sp

from ..detection import Detection
from ..errors import EffectError
from ..escaping import quoted, toml_string, visible
from ..notation import Coefficient, Effect
from ..reserved import no_coefficient, no_effect
from .checks import LONGEST_FILE, check_effect
from .detection_file import detection_text, known_keys, read_detection
from .formula import formula, formula_text

#: What a declaration may say.
DECLARATION_KEYS = {"description": str, "unit": str, "lower": float, "upper": float, "neutral": float, "start": float,
             "flips": bool}  # fmt: skip
_KINDS = {str: "text", float: "finite number", bool: "truth value: true or false"}
#: The largest double.
MOST = sys.float_info.max


@dataclass(frozen=True)
class Act:
    """What an added effect does to one named quantity, given by name or by role: ``how`` is "factor" or "term"."""

    on: str
    how: str
    expression: sp.Expr


@dataclass(frozen=True)
class AddedEffect:
    """An effect beyond the book.

    Attributes
    ----------
    name, physics, source : str
    declarations : tuple of Coefficient
        Its coefficients; neutral ones make it vanish.
    acts : tuple of Act
    detection : Detection or None
        How a diagnosis looks for it, where its file declares that.
    """

    name: str
    physics: str
    source: str
    declarations: tuple[Coefficient, ...]
    acts: tuple[Act, ...]
    detection: Detection | None = None

    @property
    def acts_on(self) -> tuple[str, ...]:
        """The named quantities that it changes, by name or by role."""
        return tuple(dict.fromkeys(act.on for act in self.acts))

    @property
    def section(self) -> str:
        """The .tir section of its coefficients."""
        return f"TIREFMU_{self.name.upper()}"


def read_effect(text: str, source: str) -> AddedEffect:
    """Return the effect that a file's text describes.

    Parameters
    ----------
    text : str
        TOML.
    source : str
        The file's name, for messages.

    Returns
    -------
    AddedEffect

    Raises
    ------
    EffectError
        If the text is no TOML, says something that has no place in an effect, has a name that means something else
        (`tirefmu.symbolic.reserved`), or is beyond the bounds of formulas and texts.
    """
    told = _parsed(text, source)
    known_keys(told, ("name", "physics", "source", "coefficients", "acts", "diagnosis"), source)
    name = _text(told, "name", source)
    declarations = tuple(
        _declaration(key, declaration, source, f"TIREFMU_{name.upper()}")
        for key, declaration in _table(told, source).items()
    )
    acts = told.get("acts")
    if not isinstance(acts, list) or not acts:
        raise EffectError(f"{source}: an effect has at least one [[acts]]")
    effect = AddedEffect(
        name,
        _text(told, "physics", source),
        _text(told, "source", source) if "source" in told else "",
        declarations,
        tuple(_act(act, source) for act in acts),
        read_detection(told["diagnosis"], source, {declaration.name for declaration in declarations})
        if "diagnosis" in told
        else None,
    )
    check_effect(effect, source)
    _check_sizes(effect, source)
    unused = {declaration.name for declaration in declarations} - {
        s.name for act in effect.acts for s in act.expression.free_symbols
    }
    if unused:
        raise EffectError(f"{source}: {min(unused)} is declared but acts on nothing")
    return effect


def read_declared(text: str, file: str) -> Effect | AddedEffect:
    r"""Return the effect of a file of the package: in the lines of chapters where it has no [[acts]].

    Parameters
    ----------
    text : str
        TOML. In addition to the keys of `read_effect`, a file without [[acts]] may have ``optional`` and ``rescales``
        (`tirefmu.symbolic.notation.Effect`).
    file : str
        The file's name: that of the effect and ``.toml``.

    Returns
    -------
    Effect or AddedEffect

    Raises
    ------
    EffectError
        As `read_effect`, or if the file has another name than its effect.

    Examples
    --------
    >>> read_declared('name = "snow"\nphysics = "less grip"\noptional = true', "snow.toml")
    Effect(name='snow', physics='less grip', rescales=(), optional=True, detection=None)
    """
    told = _parsed(text, file)
    name = _text(told, "name", file)
    if f"{name}.toml" != file:
        raise EffectError(f"{file}: the effect {quoted(name)} has a file of its own name")
    if "acts" in told:
        return read_effect(text, file)
    known_keys(told, ("name", "physics", "optional", "rescales", "diagnosis"), file)
    if reason := no_effect(name):
        raise EffectError(f"{file}: name {quoted(name)} {reason}")
    rescales, optional = told.get("rescales", {}), told.get("optional", False)
    if not isinstance(rescales, dict) or not all(map(_is_number, rescales.values())):
        raise EffectError(f"{file}: rescales is not a table of coefficients and factors")
    if not isinstance(optional, bool):
        raise EffectError(f"{file}: optional is not a {_KINDS[bool]}")
    detection = read_detection(told["diagnosis"], file) if "diagnosis" in told else None
    return Effect(name, _text(told, "physics", file), tuple(rescales.items()), optional, detection)


def _parsed(text: str, source: str) -> dict[str, Any]:
    if len(text) > LONGEST_FILE:
        raise EffectError(f"{source}: the file of an effect has at most {LONGEST_FILE} characters")
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # ValueError also of integers with thousands of digits
        raise EffectError(f"{source}: {visible(str(error))}") from None


def effect_text(effect: AddedEffect) -> str:
    """Return the file's text of an effect."""
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
        said = {"description": toml_string(declaration.description), "unit": toml_string(declaration.unit)}
        said |= {key: repr(float(x)) for key, x in numbers.items() if x is not None and isfinite(x)}
        if declaration.flips:
            said["flips"] = "true"
        lines.append(f"{declaration.name} = {{{', '.join(f'{key} = {value}' for key, value in said.items())}}}")
    for act in effect.acts:
        lines += ["", "[[acts]]", f"on = {toml_string(act.on)}"]
        lines += [f"{act.how} = {toml_string(formula_text(act.expression))}"]
    if effect.detection is not None:
        lines += ["", detection_text(effect.detection)]
    return "\n".join(lines) + "\n"


def _check_sizes(effect: AddedEffect, source: str) -> None:
    """Raise `EffectError` where a coefficient that is probed leaves its bounds."""
    declarations, detection = (
        {declaration.name: declaration for declaration in effect.declarations},
        effect.detection or Detection(),
    )
    for form in (*detection.forms, *detection.refinements):
        for name, size in (item for probe in form.probes for item in probe.items()):
            declaration = declarations[name]
            if not declaration.lower <= declaration.default + size <= declaration.upper:
                place = f"{source}: [diagnosis] {name}"
                raise EffectError(f"{place}: neutral {declaration.default} and size {size} are beyond its bounds")


def _text(told: dict[str, Any], key: str, source: str) -> str:
    value = told.get(key)
    if not isinstance(value, str) or not value.strip():
        raise EffectError(f"{source}: {key} is missing, or is no text")
    return value


def _table(told: dict[str, Any], source: str) -> dict[str, Any]:
    declarations = told.get("coefficients", {})
    if not isinstance(declarations, dict):
        raise EffectError(f"{source}: [coefficients] is not a table")
    return declarations


def _declaration(name: str, told: object, source: str, section: str) -> Coefficient:
    if reason := no_coefficient(name):
        raise EffectError(f"{source}: coefficient {quoted(name)} {reason}")
    place = f"{source}: coefficient {name}"
    if not isinstance(told, dict):
        raise EffectError(f"{place} is not a table {{description = ..., unit = ...}}")
    known_keys(told, DECLARATION_KEYS, place)
    for key, value in told.items():
        if not (_is_number(value) if DECLARATION_KEYS[key] is float else isinstance(value, DECLARATION_KEYS[key])):
            raise EffectError(f"{place}: {key} = {visible(repr(value))[:80]} is not a {_KINDS[DECLARATION_KEYS[key]]}")
    declaration = Coefficient(**{"description": "", **told})
    declaration.name, declaration.section = name, section
    return declaration


def _is_number(value: object) -> bool:
    """Return whether a value is a number that a double holds."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= MOST


def _act(told: object, source: str) -> Act:
    place = f"{source}: [[acts]]"
    if not isinstance(told, dict):
        raise EffectError(f"{place} is not a table")
    known_keys(told, ("on", "factor", "term"), place)
    ways = [how for how in ("factor", "term") if how in told]
    if len(ways) != 1:
        raise EffectError(f"{place}: say one of factor and term")
    return Act(_text(told, "on", place), ways[0], formula(_text(told, ways[0], place), place))
