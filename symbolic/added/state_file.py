"""The tables [states.NAME] of an effect file: reading, checking and writing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...boundary.errors import EffectError, nearest
from ...boundary.escaping import toml_string
from ...boundary.json_schema import FILLED, list_schema, one_of
from .state import FITTED, KINDS, PATHS, SPEED, WITH_FITTED_START, State, with_speeds

_FORMULA: dict[str, Any] = {"anyOf": [FILLED, {"type": "number"}]}
#: Keys of the table of a state with the schemas of their values, in the order in which they are written.
KEYS: dict[str, Any] = {
    "kind": one_of(KINDS),
    "drive": {"anyOf": [*_FORMULA["anyOf"], {**list_schema(FILLED, 1, 2), "title": "a list of one or two lags"}]},
    **dict.fromkeys(("rate", "length", "width", "ambient", "frequency", "damping", "start"), _FORMULA),
    "unit": FILLED,
    "description": FILLED,
}


def read_states(tables: Mapping[str, Mapping[str, Any]], source: str) -> tuple[State, ...]:
    """Return the states of an effect file whose tables satisfy the schema of `KEYS`, formulas as written there.

    `source`: name of the file, for messages. Returns: the speed of an oscillator is a state behind it. Raises
    `EffectError` if a kind of states lacks a key or does not have it.

    >>> (state,) = read_states({"late_load": {"kind": "lag", "drive": "Fz", "length": "LATE"}}, "example.toml")
    >>> state.kind, state.drive
    ('lag', ('Fz',))
    """
    states = [_state(name, table, f"{source}: [states.{name}]") for name, table in tables.items()]
    complete = tuple(with_speeds(states))
    for speed in (state for state in complete if state.kind == SPEED and state.name in tables):
        raise EffectError(f"{source}: [states.{speed.name}] has the name of the speed of an oscillator")
    return complete


def _state(name: str, table: Mapping[str, Any], location: str) -> State:
    kind = table["kind"]
    required, optional = KINDS[kind]
    article = "an" if kind[0] in "ao" else "a"
    for alternatives in required:
        if sum(key in table for key in alternatives) != 1:
            raise EffectError(f"{location}: {article} {kind} requires {' or '.join(alternatives)}")
    of_all, of_kind = {"kind", "drive", "unit", "description"}, {key for keys in required for key in keys}
    allowed = {*of_all, *of_kind, *optional}
    for key in sorted(table.keys() - allowed):
        raise EffectError(f"{location}: {article} {kind} has no {key}{nearest(key, sorted(allowed))}")
    if table.get("start") == FITTED and kind not in WITH_FITTED_START:
        raise EffectError(f"{location}: {article} {kind} has no fitted start")
    drive = table["drive"]
    if isinstance(drive, list) and kind not in PATHS:
        raise EffectError(f"{location}: drive of {article} {kind} is one formula, not a list")
    texts = {key: _formula(value) for key, value in table.items() if key not in ("kind", "drive")}
    drives = tuple(map(_formula, drive if isinstance(drive, list) else [drive]))
    return State(name, kind, drives, **texts)


def _formula(value: str | float) -> str:
    """Return a formula as text: a number may be written as such."""
    return value if isinstance(value, str) else repr(value)


def states_text(states: Sequence[State]) -> list[str]:
    """Return the lines of the states of an effect file."""
    lines: list[str] = []
    for state in (state for state in states if state.kind != SPEED):
        drives = [toml_string(drive) for drive in state.drive]
        lines += ["", f"[states.{state.name}]", f"kind = {toml_string(state.kind)}"]
        lines.append(f"drive = {drives[0]}" if len(drives) == 1 else f"drive = [{', '.join(drives)}]")
        lines += [f"{key} = {toml_string(text)}" for key in list(KEYS)[2:] if (text := getattr(state, key))]
    return lines
