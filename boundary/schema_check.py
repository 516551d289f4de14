"""The check of a file's content by its JSON Schema: what editors check is what the reader requires.

Numbers are finite, and texts have no NUL, which no path contains.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from itertools import islice
from typing import Any

from .errors import TirefmuError, nearest
from .escaping import quoted, visible

#: Largest number of a file. Larger ones overflow in the next multiplication.
LARGEST_NUMBER = 1e300
#: Number of differences that are compared; the clearest one is reported. A file of 2 MB may have a hundred thousand.
MAX_DIFFERENCES = 100
#: What an item of a list is, by its type in JSON.
_PLURALS = {
    "string": "texts", "number": "numbers", "integer": "whole numbers", "object": "tables", "array": "lists",
}  # fmt: skip
_SINGULARS = {"string": "a text", "number": "a number", "integer": "a whole number", "boolean": "true or false",
              "null": "null"}  # fmt: skip


def check_content(content: Any, schema: Mapping[str, Any], source: str, error: type[TirefmuError]) -> None:
    """Raise unless the content of a file satisfies a schema.

    `source`: the file, for the message. `error`: what is raised. The message names the place, as a dotted key of TOML.

    >>> schema = {"properties": {"fit": {"type": "object", "properties": {"rows": {"type": "integer", "minimum": 1}}}}}
    >>> check_content({"fit": {"rows": 0}}, schema, "fit.toml", TirefmuError)
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.TirefmuError: fit.toml: fit.rows is 0: expected a whole number of at least 1
    """
    from jsonschema.exceptions import best_match

    difference = best_match(islice(_validator_class()(schema).iter_errors(content), MAX_DIFFERENCES))
    if difference is None:
        return
    place, value = _place(difference.absolute_path), difference.instance
    within, start = f" in {place}" if place else "", f"{source}: {place}" if place else source
    rule, limits = difference.validator, difference.schema
    keys = limits.get("properties", {})
    if rule == "additionalProperties":
        key = next(key for key in value if key not in keys)
        raise error(f"{source}: unknown key {quoted(key)}{within}{nearest(key, keys)}")
    if rule == "required":
        name = next(name for name in limits["required"] if name not in value)
        raise error(f"{source}: {name} is missing{within}: it is {_described(keys.get(name, {}))}")
    if rule == "enum" and isinstance(value, str):
        raise error(f"{source}: unknown word {quoted(value)}{within}{nearest(value, limits['enum'])}")
    if "propertyNames" in difference.relative_schema_path:
        raise error(f"{source}: the name {quoted(value)}{within} is not {expected(limits)}")
    whole = difference.parent.schema if difference.parent else limits
    shown = quoted(value) if isinstance(value, str) else _shown(value)
    raise error(f"{start} is {shown}: expected {_described(limits, whole.get('description', ''))}")


def expected(schema: Mapping[str, Any]) -> str:
    """Return the values that a schema accepts, in words: its title, if it has one.

    >>> expected({"type": "array", "items": {"type": "string"}, "minItems": 1, "maxItems": 3})
    'a list of 1 to 3 texts'
    >>> expected({"type": "object", "additionalProperties": {"type": "number"}, "examples": [{"Fz0": 1000.0}]})
    'a table of numbers, such as {Fz0 = 1000.0}'
    """
    examples = f", such as {_shown(schema['examples'][0])}" if "examples" in schema else ""
    if "title" in schema:
        return str(schema["title"])
    if "const" in schema:
        return str(schema["const"])
    if "enum" in schema:
        return f"one of {', '.join(map(str, schema['enum']))}"
    for rule in ("anyOf", "oneOf"):
        if rule in schema:
            return " or ".join(dict.fromkeys(map(expected, schema[rule]))) + examples
    kind = schema.get("type", "")
    if isinstance(kind, list):
        return " or ".join(expected({"type": part}) for part in kind)
    if "prefixItems" in schema:
        return f"a list of {' and '.join(map(expected, schema['prefixItems']))}{examples}"
    if kind == "array":
        return f"a list of {_range(schema, 'Items')}{_plural(schema.get('items', {}))}{examples}"
    if kind == "object":
        values = schema.get("additionalProperties")
        of = f" of {_range(schema, 'Properties')}{_plural(values)}" if isinstance(values, Mapping) else ""
        return f"a table{of}{examples}"
    length = f" of at most {schema['maxLength']} characters" if "maxLength" in schema else ""
    return f"{_SINGULARS.get(kind, 'another value')}{_bounds(schema)}{length}{examples}"


def _described(schema: Mapping[str, Any], meaning: str = "") -> str:
    """Return what a schema accepts, and what the value means."""
    words, meaning = expected(schema), meaning or schema.get("description", "")
    return f"{words} ({meaning})" if meaning else words


def _bounds(schema: Mapping[str, Any]) -> str:
    words = {
        "minimum": "of at least",
        "exclusiveMinimum": "above",
        "maximum": "of at most",
        "exclusiveMaximum": "below",
    }
    texts = [f"{text} {schema[rule]:g}" for rule, text in words.items() if rule in schema]
    return f" {' and '.join(texts)}" if texts else ""


def _range(schema: Mapping[str, Any], what: str) -> str:
    least, most = schema.get(f"min{what}", 0), schema.get(f"max{what}")
    different = "different " if schema.get("uniqueItems") else ""
    if most is not None:
        return f"{f'{least} to' if least else 'at most'} {most} {different}"
    return f"one or more {different}" if least else different


def _plural(schema: Mapping[str, Any]) -> str:
    if "enum" in schema:
        return f"words out of {', '.join(map(str, schema['enum']))}"
    return _PLURALS.get(str(schema.get("type")), "values")


def _place(path: Iterable[str | int]) -> str:
    """Return a place in a file as a dotted key of TOML; items of lists count from 1."""
    parts = [f"[{part + 1}]" if isinstance(part, int) else f".{visible(part)[:80]}" for part in path]
    return "".join(parts).removeprefix(".")


def _shown(value: Any) -> str:
    """Return a value as in a TOML file, shortened."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{visible(str(key))} = {_shown(item)}' for key, item in value.items())}}}"[:80]
    if isinstance(value, list):
        return f"[{', '.join(map(_shown, value[:20]))}]"[:80]
    return {True: "true", False: "false"}[value] if isinstance(value, bool) else visible(repr(value))[:80]


@cache
def _validator_class() -> Any:
    from jsonschema import Draft202012Validator
    from jsonschema.validators import extend

    def is_number(_: Any, value: Any) -> bool:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < LARGEST_NUMBER

    types = {
        "number": is_number,
        "integer": lambda _, value: isinstance(value, int) and is_number(_, value),
        "string": lambda _, value: isinstance(value, str) and "\0" not in value,
    }
    return extend(Draft202012Validator, type_checker=Draft202012Validator.TYPE_CHECKER.redefine_many(types))
