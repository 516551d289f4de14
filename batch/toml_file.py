"""Keys of job lists and studies and the types of their values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_origin

from tirefmu.boundary.errors import FitError, UnknownName
from tirefmu.boundary.escaping import quoted
from tirefmu.boundary.json_schema import is_of

KINDS = {
    str: "a text", list: "a list of texts", dict: "a table of numbers", int: "a whole number", bool: "true or false",
    float: "a number",
}  # fmt: skip


def check_keys(table: Any, kinds: Mapping[str, Any], location: str) -> None:
    """Raise unless a table has known keys with values of their types only."""
    if not isinstance(table, dict):
        raise FitError(f"{location} is not a table")
    for key, value in table.items():
        if key not in kinds:
            raise UnknownName(f"key in {location}", key, kinds)
        if not is_of(value, kinds[key]):
            raise FitError(f"{location}: {key} = {quoted(value)} is not {KINDS[get_origin(kinds[key]) or kinds[key]]}")
