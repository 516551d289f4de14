"""Keys of job lists and studies and the types of their values."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any

from tirefmu.boundary.errors import FitError, UnknownName
from tirefmu.boundary.escaping import quoted

KINDS = {
    str: "a text", list: "a list of texts", dict: "a table of numbers", int: "a whole number", bool: "true or false",
    float: "a number",
}  # fmt: skip
#: Keys whose lists and tables have other contents, which are checked later.
NESTED = ("jobs", "defaults", "parameters")


def check_keys(table: Any, kinds: Mapping[str, type], location: str) -> None:
    """Raise unless a table has known keys with values of their types only."""
    if not isinstance(table, dict):
        raise FitError(f"{location} is not a table")
    for key, value in table.items():
        if key not in kinds:
            raise UnknownName(f"key in {location}", key, kinds)
        if not _is_of(value, kinds[key], key):
            raise FitError(f"{location}: {key} = {quoted(value)} is not {KINDS[kinds[key]]}")


def is_number(value: Any) -> bool:
    """Return whether a value is a finite number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e300 and isfinite(value)


def _is_of(value: Any, kind: type, key: str) -> bool:
    if kind is list:
        return isinstance(value, list) and (key in NESTED or all(isinstance(one, str) for one in value))
    if kind is dict:
        return isinstance(value, dict) and (key in NESTED or all(map(is_number, value.values())))
    if kind is float:
        return is_number(value)
    return isinstance(value, kind) and isinstance(value, bool) == (kind is bool)
