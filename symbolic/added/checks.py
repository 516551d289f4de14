"""Checks of added effects from files, tires and programs: names, texts, numbers, sizes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite

from ...boundary.errors import EffectError, nearest
from ...boundary.escaping import quoted
from ..declarations import Coefficient
from ..reserved import no_coefficient, no_effect, no_state
from .effect import AddedEffect
from .state import KINDS, SPEED, State, with_speeds

#: Upper limits, in characters and in numbers of items.
LONGEST_FILE, LONGEST_TEXT, LONGEST_UNIT = 100_000, 600, 40
MAX_COEFFICIENTS, MAX_ACTS, MAX_EFFECTS, MAX_STATES = 100, 50, 50, 10


def check_effect(effect: AddedEffect, location: str) -> None:
    """Raise `EffectError` if an effect violates the rules.

    `effect`: with formulas as returned by `formula`. `location`: origin of the effect, for messages.
    """
    if reason := next(_objections(effect), ""):
        raise EffectError(f"{location}: {reason}")


def check_effects(effects: Sequence[AddedEffect]) -> None:
    """Raise `EffectError` if effects or their formulas violate the rules, or if two have the same name."""
    from .formula import formula  # SymPy

    if len(effects) > MAX_EFFECTS:
        raise EffectError(f"a tire has at most {MAX_EFFECTS} added effects, not {len(effects)}")
    seen: set[str] = set()
    for effect in effects:
        location = f"effect {quoted(effect.name)}"
        check_effect(effect, location)
        for act in effect.acts:
            formula(act.text, location)
        for state in effect.states:
            for key, text in state.formulas():
                formula(text, f"{location}, state {state.name}: {key}")
        if effect.name.lower() in seen:  # keys of .tir files are not case-sensitive
            raise EffectError(f"two added effects have the name {effect.name}")
        seen.add(effect.name.lower())


def _objections(effect: AddedEffect) -> Iterator[str]:
    if reason := no_effect(effect.name):
        yield f"name {quoted(effect.name)} {reason}"
    for key, text in (("physics", effect.physics), ("source", effect.source)):
        if len(text) > LONGEST_TEXT:
            yield f"{key} has more than {LONGEST_TEXT} characters"
    if len(effect.declarations) > MAX_COEFFICIENTS:
        yield f"an effect has at most {MAX_COEFFICIENTS} coefficients, not {len(effect.declarations)}"
    if len(effect.acts) > MAX_ACTS:
        yield f"an effect has at most {MAX_ACTS} [[acts]], not {len(effect.acts)}"
    for state in effect.states:
        if len(state.description) > LONGEST_TEXT or len(state.unit) > LONGEST_UNIT:
            yield f"state {state.name}: description or unit is longer than {LONGEST_TEXT} or {LONGEST_UNIT} characters"
    yield from _state_objections(effect.states, frozenset().union(*(act.reads for act in effect.acts)))
    for declaration in effect.declarations:
        for reason in _declaration_objections(declaration):
            yield f"coefficient {reason}"


def _declaration_objections(declaration: Coefficient) -> Iterator[str]:
    if reason := no_coefficient(declaration.name):
        yield f"{quoted(declaration.name)} {reason}"
    for key, text, longest in (
        ("description", declaration.description, LONGEST_TEXT),
        ("unit", declaration.unit, LONGEST_UNIT),
    ):
        if len(text) > longest:
            yield f"{declaration.name}: {key} has more than {longest} characters"
    if not declaration.lower < declaration.upper:
        yield f"{declaration.name}: lower {declaration.lower} is not below upper {declaration.upper}"
    for key, value in (("neutral", declaration.neutral), ("start", declaration.start)):
        if value is not None and not (isfinite(value) and declaration.lower <= value <= declaration.upper):
            limits = f"lower {declaration.lower} and upper {declaration.upper}"
            yield f"{declaration.name}: {key} {value} is not between {limits}"
    if declaration.neutral is None:
        yield f"{declaration.name}: an added effect requires a neutral value for each coefficient"


def _state_objections(states: Sequence[State], read: frozenset[str]) -> Iterator[str]:
    """Yield why states are not valid together. `read`: the names that the acts of their effect read."""
    if len(states) > MAX_STATES:
        yield f"an effect has at most {MAX_STATES} states, not {len(states)}"
    if tuple(with_speeds(state for state in states if state.kind != SPEED)) != tuple(states):
        yield "the speed of an oscillator is a state behind it"
    used = read.union(*(state.reads for state in states))
    for state in states:
        if state.oscillates and used.isdisjoint((state.name, state.speed_name)):
            yield f"state {state.name} is declared but not used"
    lags = {state.name for state in states if state.kind == "lag"}
    for i, state in enumerate(states):
        if reason := no_state(state.name):
            yield f"state {quoted(state.name)} {reason}"
        if state.kind not in (*KINDS, SPEED):
            yield f"state {state.name}: unknown kind {quoted(state.kind)}{nearest(state.kind, KINDS)}"
        for name in state.drive if state.follows_a_path else ():
            if name not in lags:
                yield f"state {state.name}: drive {quoted(name)} is no lag of this effect{nearest(name, sorted(lags))}"
        used = read.union(*(other.reads for other in (*states[:i], *states[i + 1 :])))
        if state.name not in used and not (state.is_temperature or state.oscillates or state.kind == SPEED):
            yield f"state {state.name} is declared but not used"
