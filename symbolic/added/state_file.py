"""The tables [states.NAME] of an effect file: reading, checking and writing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tirefmu.boundary.errors import EffectError, nearest
from tirefmu.boundary.escaping import quoted, toml_string
from tirefmu.boundary.json_schema import one_of

from ..reserved import no_state
from .detection_file import known_keys
from .state import FITTED, KINDS, PATHS, SPEED, WITH_FITTED_START, State, with_speeds

#: Keys of the table of a state with the types of their values, in the order in which they are written.
KEYS: dict[str, Any] = {
    "kind": one_of(tuple(KINDS)),
    "drive": str | float | list[str],
    **dict.fromkeys(("rate", "length", "width", "ambient", "frequency", "damping", "start"), str | float),
    "unit": str,
    "description": str,
    "observed": bool,
}


def read_states(tables: object, source: str) -> tuple[State, ...]:
    """Return the states of an effect file, formulas as written there.

    `tables`: the value of the key ``states``. `source`: name of the file, for messages. Returns: the speed of an
    oscillator is a state behind it. Raises `EffectError` if a table is not that of a state.

    >>> (state,) = read_states({"late_load": {"kind": "lag", "drive": "Fz", "length": "LATE"}}, "example.toml")
    >>> state.kind, state.drive
    ('lag', ('Fz',))
    """
    if not isinstance(tables, dict):
        raise EffectError(f"{source}: states is not a table of states: [states.NAME]")
    states = [_state(name, table, f"{source}: [states.{name[:80]}]") for name, table in tables.items()]
    found = tuple(with_speeds(states))
    for speed in (state for state in found if state.kind == SPEED and state.name in tables):
        raise EffectError(f"{source}: [states.{speed.name}] has the name of the speed of an oscillator")
    return found


def _state(name: str, table: object, location: str) -> State:
    if reason := no_state(name):
        raise EffectError(f"{location}: {quoted(name)} {reason}")
    if not isinstance(table, dict):
        raise EffectError(f"{location} is not a table")
    known_keys(table, KEYS, location)
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        raise EffectError(f"{location}: unknown kind {quoted(str(kind))}{nearest(str(kind), KINDS)}")
    required, optional = KINDS[kind]
    article = "an" if kind[0] in "ao" else "a"
    for alternatives in required:
        if sum(key in table for key in alternatives) != 1:
            raise EffectError(f"{location}: {article} {kind} requires {' or '.join(alternatives)}")
    allowed = {
        "kind",
        "drive",
        "unit",
        "description",
        "observed",
        *optional,
        *(key for keys in required for key in keys),
    }
    for key in sorted(table.keys() - allowed):
        raise EffectError(f"{location}: {article} {kind} has no {key}{nearest(key, sorted(allowed))}")
    if table.get("start") == FITTED and kind not in WITH_FITTED_START:
        raise EffectError(f"{location}: {article} {kind} has no fitted start")
    observed = table.get("observed", False)
    if not isinstance(observed, bool):
        raise EffectError(f"{location}: observed is neither true nor false")
    texts = {key: _text(table, key, location) for key in table.keys() - {"kind", "drive", "observed"}}
    return State(name, kind, _drive(table, kind, location), observed=observed, **texts)


def _drive(table: dict[str, Any], kind: str, location: str) -> tuple[str, ...]:
    drive = table.get("drive")
    if kind not in PATHS:
        return (_text(table, "drive", location),)
    drives = [drive] if isinstance(drive, str) else drive
    if not isinstance(drives, list) or len(drives) not in (1, 2) or not all(isinstance(each, str) for each in drives):
        raise EffectError(f"{location}: drive is not the name of a lag, or a list of two")
    return tuple(drives)


def _text(table: dict[str, Any], key: str, location: str) -> str:
    value = table.get(key)
    if isinstance(value, (int, float)) and not isinstance(value, bool) and key not in ("unit", "description"):
        return repr(value)
    if not isinstance(value, str) or not value.strip():
        raise EffectError(f"{location}: {key} is missing or not a text")
    return value


def states_text(states: Sequence[State]) -> list[str]:
    """Return the lines of the states of an effect file."""
    lines: list[str] = []
    for state in (state for state in states if state.kind != SPEED):
        drives = [toml_string(drive) for drive in state.drive]
        lines += ["", f"[states.{state.name}]", f"kind = {toml_string(state.kind)}"]
        lines.append(f"drive = {drives[0]}" if len(drives) == 1 else f"drive = [{', '.join(drives)}]")
        lines += [f"{key} = {toml_string(text)}" for key in list(KEYS)[2:-1] if (text := getattr(state, key))]
        lines += ["observed = true"] if state.observed else []
    return lines
