"""The file of an added effect: TOML with a name, its physics, coefficients, and what it acts on.

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

import tomllib
from dataclasses import dataclass
from typing import Any

import sympy as sp

from ..errors import EffectError, nearest
from ..notation import Coefficient
from .formula import formula, formula_text

#: What a card may say.
CARD_KEYS = {"description": str, "unit": str, "lower": float, "upper": float, "neutral": float, "start": float,
             "flips": bool}  # fmt: skip


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
    cards : tuple of Coefficient
        Its coefficients; neutral ones make it vanish.
    acts : tuple of Act
    """

    name: str
    physics: str
    source: str
    cards: tuple[Coefficient, ...]
    acts: tuple[Act, ...]

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
        If the text is no TOML or says something that has no place in an effect.
    """
    try:
        told = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise EffectError(f"{source}: {error}") from None
    _known(told, {"name", "physics", "source", "coefficients", "acts"}, source)
    name = _text(told, "name", source)
    if not name.isidentifier():
        raise EffectError(f"{source}: name {name!r} is not a word of letters, digits and _")
    cards = tuple(_card(key, card, source, f"TIREFMU_{name.upper()}") for key, card in _table(told, source).items())
    acts = told.get("acts")
    if not isinstance(acts, list) or not acts:
        raise EffectError(f"{source}: an effect has at least one [[acts]]")
    effect = AddedEffect(
        name,
        _text(told, "physics", source),
        str(told.get("source", "")),
        cards,
        tuple(_act(act, source) for act in acts),
    )
    unused = {card.name for card in cards} - {s.name for act in effect.acts for s in act.expression.free_symbols}
    if unused:
        raise EffectError(f"{source}: {min(unused)} is declared but acts on nothing")
    return effect


def effect_text(effect: AddedEffect) -> str:
    """Return the file's text of an effect."""
    lines = [
        f'name = "{effect.name}"',
        f"physics = {_quoted(effect.physics)}",
        f"source = {_quoted(effect.source)}",
        "",
    ]
    lines.append("[coefficients]")
    for card in effect.cards:
        said = {"description": _quoted(card.description), "unit": _quoted(card.unit), "lower": repr(float(card.lower)),
                "upper": repr(float(card.upper)), "neutral": repr(float(card.default))}  # fmt: skip
        if card.start is not None:
            said["start"] = repr(float(card.start))
        if card.flips:
            said["flips"] = "true"
        lines.append(f"{card.name} = {{{', '.join(f'{key} = {value}' for key, value in said.items())}}}")
    for act in effect.acts:
        lines += ["", "[[acts]]", f'on = "{act.on}"', f"{act.how} = {_quoted(formula_text(act.expression))}"]
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _known(told: dict[str, Any], keys: set[str], place: str) -> None:
    for key in told:
        if key not in keys:
            raise EffectError(f"{place}: unknown key {key!r}{nearest(key, sorted(keys))}")


def _text(told: dict[str, Any], key: str, source: str) -> str:
    value = told.get(key)
    if not isinstance(value, str) or not value.strip():
        raise EffectError(f"{source}: {key} is missing, or is no text")
    return value


def _table(told: dict[str, Any], source: str) -> dict[str, Any]:
    cards = told.get("coefficients", {})
    if not isinstance(cards, dict):
        raise EffectError(f"{source}: [coefficients] is not a table")
    return cards


def _card(name: str, told: object, source: str, section: str) -> Coefficient:
    place = f"{source}: coefficient {name}"
    if name != name.upper() or not name.isidentifier():
        raise EffectError(f"{place}: a coefficient is a word of capital letters, digits and _")
    if not isinstance(told, dict):
        raise EffectError(f"{place} is not a table {{description = ..., unit = ...}}")
    _known(told, set(CARD_KEYS), place)
    for key, value in told.items():
        kind = CARD_KEYS[key]
        good = (
            isinstance(value, (int, float)) and not isinstance(value, bool)
            if kind is float
            else isinstance(value, kind)
        )
        if not good:
            raise EffectError(f"{place}: {key} = {value!r} is not a {kind.__name__}")
    card = Coefficient(**{"description": "", **told})
    if not card.lower < card.upper:
        raise EffectError(f"{place}: lower {card.lower} is not below upper {card.upper}")
    card.name, card.section = name, section
    return card


def _act(told: object, source: str) -> Act:
    place = f"{source}: [[acts]]"
    if not isinstance(told, dict):
        raise EffectError(f"{place} is not a table")
    _known(told, {"on", "factor", "term"}, place)
    ways = [how for how in ("factor", "term") if how in told]
    if len(ways) != 1:
        raise EffectError(f"{place}: say one of factor and term")
    return Act(_text(told, "on", place), ways[0], formula(_text(told, ways[0], place), place))
