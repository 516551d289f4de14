"""Which values of a JSON document are yes or no, by the declared types of the classes whose values it has."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any


def declared_flags(*classes: type) -> set[str]:
    """Return the names of the fields and properties that are declared as bool."""
    declared = {one.name: str(one.type) for own in classes for one in fields(own)}
    for own in classes:
        declared |= {
            name: str(value.fget.__annotations__["return"])
            for name, value in vars(own).items()
            if isinstance(value, property)
        }
    return {name for name, kind in declared.items() if kind in ("bool", "bool | None")}


def flags(document: Any, names: set[str], path: str = "") -> Iterator[tuple[str, bool]]:
    """Yield the path of every value that is true or false or declared so, and whether it is both (or unknown: null)."""
    for key, value in document.items() if isinstance(document, dict) else enumerate(document):
        at = f"{path}/{key}"
        if isinstance(value, (dict, list)):
            yield from flags(value, names, at)
        elif key in names or isinstance(value, bool):
            yield at, key in names and (value is None or isinstance(value, bool))
