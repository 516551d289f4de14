"""JSON Schemas from the types that declare what a file contains, and values of JSON.

A reader lists its keys with types (``{"tables": list[str]}``), a writer has frozen classes and typed dictionaries. Both
are enough for `schema_of`, so that no schema repeats a declaration.

The keys of a frozen class are its fields, unless it lists others: ``JSON_KEYS = ("name", "run.seconds", "tire.has as
effects")`` has the keys ``name``, ``seconds`` and ``effects``, values and types of which are those of fields and
properties.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from inspect import getattr_static, getdoc
from math import isfinite
from operator import attrgetter
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, ClassVar, Union, get_args, get_origin, get_type_hints, is_typeddict

#: The schema of a text that is not empty.
FILLED = {"type": "string", "pattern": r"\S", "title": "a text that is not empty"}
_TYPES = {bool: "boolean", int: "integer", float: "number", str: "string", NoneType: "null"}


def schema_of(kind: Any, *, missing: bool = False) -> dict[str, Any]:
    """Return the JSON Schema of a type; a schema, which is a dictionary, is returned as it is.

    `kind`: bool, int, float, str, None, Any; lists, tuples, sets, mappings with text keys, unions of types; arrays;
    frozen classes, named tuples and typed dictionaries. ``Annotated[type, text or mapping]`` adds a description or
    further keywords.
    `missing`: a number may be null, as in `json_value`. Raises `TypeError` for another type.

    >>> schema_of(list[float] | None)
    {'anyOf': [{'type': 'array', 'items': {'type': 'number'}}, {'type': 'null'}]}
    >>> schema_of(Annotated[int, "number of rows", {"minimum": 1}])
    {'type': 'integer', 'description': 'number of rows', 'minimum': 1}
    """
    origin, parts = get_origin(kind), get_args(kind)
    if isinstance(kind, dict):
        return kind
    if kind is Any:
        return {}
    if origin is Annotated:
        schema = schema_of(parts[0], missing=missing)
        for fact in parts[1:]:
            schema |= {"description": fact} if isinstance(fact, str) else fact
        return schema
    if origin is ClassVar:
        return schema_of(parts[0], missing=missing)
    if kind in _TYPES:
        return {"type": [_TYPES[kind], "null"] if missing and kind is float else _TYPES[kind]}
    if origin in (Union, UnionType):
        return {"anyOf": [schema_of(part, missing=missing) for part in parts]}
    if origin is tuple and parts[-1] is not Ellipsis:
        pair = [schema_of(part, missing=missing) for part in parts]
        return {"type": "array", "prefixItems": pair, "items": False, "minItems": len(pair)}
    if origin in (list, tuple, frozenset, Sequence):
        return {"type": "array", "items": schema_of(parts[0], missing=missing)}
    if getattr(origin, "__name__", "") in ("ndarray", "NDArray"):  # from NumPy 2.5 on the alias has a name of its own
        return {"type": "array"}
    if origin in (dict, Mapping):
        return {"type": "object", "additionalProperties": schema_of(parts[1], missing=missing)}
    if is_typeddict(kind):
        types = get_type_hints(kind, include_extras=True)
    elif paths := _paths(kind):
        types = {key: _type_of(kind, path) for key, path in paths.items()}
    else:
        raise TypeError(f"no JSON Schema of {kind}")
    return object_schema({key: schema_of(part, missing=missing) for key, part in types.items()}, types)


def _paths(value: Any) -> dict[str, str]:
    """Return the path of the attribute of each key of a frozen class or a named tuple; nothing of another type."""
    names = [part.name for part in fields(value)] if is_dataclass(value) else getattr(value, "_fields", ())
    entries = [entry.partition(" as ") for entry in getattr(value, "JSON_KEYS", names)]
    return {key or path.rpartition(".")[2]: path for path, _, key in entries}


def _type_of(kind: Any, path: str) -> Any:
    """Return the declared type of an attribute: that of a field, or that of what a property returns, with its text."""
    for name in path.split("."):
        owner = get_args(kind)[0] if get_origin(kind) is Annotated else kind
        attribute = getattr_static(owner, name, None)
        getter = getattr(attribute, "fget", None) or getattr(attribute, "func", None)
        kind = get_type_hints(getter or owner, include_extras=True)["return" if getter else name]
        if getter:
            kind = Annotated[kind, (getdoc(getter) or "").partition("\n")[0]]
    return kind


def object_schema(properties: Mapping[str, Any], required: Iterable[str] = ()) -> dict[str, Any]:
    """Return the schema of a table with these keys only.

    `properties`: a type or a schema by key.

    >>> object_schema({"rows": int}, ["rows"])["properties"]
    {'rows': {'type': 'integer'}}
    """
    schemas = {key: schema_of(part) for key, part in properties.items()}
    # An unknown key is reported before a missing one, of which it may be a misspelling.
    return {"type": "object", "properties": schemas, "additionalProperties": False, "required": list(required)}


def one_of(names: Iterable[str]) -> dict[str, Any]:
    """Return the schema of a text that is one of some names."""
    return {"enum": list(names)}


def list_schema(item: Any, least: int, most: int) -> dict[str, Any]:
    """Return the schema of a list of least to most items; `item`: a type or a schema."""
    return {"type": "array", "items": schema_of(item), "minItems": least, "maxItems": most}


def name_schema(form: re.Pattern[str], longest: int, meaning: str) -> dict[str, Any]:
    """Return the schema of a text that has the form of a name, which `meaning` describes, and a largest length."""
    return {"type": "string", "maxLength": longest, "pattern": f"^({form.pattern})$", "title": meaning}


def by_name(name: Mapping[str, Any], value: Any) -> dict[str, Any]:
    """Return the schema of a table of values (a type or a schema) by names with a schema."""
    return {"type": "object", "propertyNames": name, "additionalProperties": schema_of(value)}


def document(kind: str, version: str, title: str, schema: Mapping[str, Any]) -> dict[str, Any]:
    """Return the schema of a kind of files, with its name and version.

    `version`: new keys increment the second number, changed meanings the first.
    """
    name = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$id": f"urn:tirefmu:schema:{kind}:{version}"}
    return {**name, "title": title, **schema}


def write_toml(path: Path, text: str, schema: Mapping[str, Any]) -> None:
    """Write a TOML file and its schema beside it; the first line of the file names the schema, for editors.

    `schema`: of `document`. Raises `OSError` if a file cannot be written.
    """
    file = schema_file(schema)
    path.write_text(f"#:schema ./{file}\n{text}", encoding="utf-8")
    (path.parent / file).write_text(json.dumps(schema, indent=1) + "\n", encoding="utf-8")


def schema_file(schema: Mapping[str, Any]) -> str:
    """Return the name of the file of a schema.

    >>> schema_file(document("project", "1.0", "Project", {}))
    'tirefmu-project.schema.json'
    """
    return f"tirefmu-{schema['$id'].split(':')[3]}.schema.json"


def json_value(value: Any) -> Any:
    """Return a result as values of JSON: a frozen class becomes an object, a number that is not finite null.

    A set becomes a list in order.

    >>> json_value({"size": (1.0, float("nan"))})
    {'size': [1.0, None]}
    """
    if not isinstance(value, type) and (paths := _paths(value)):
        return {key: json_value(attrgetter(path)(value)) for key, path in paths.items()}
    if isinstance(value, Mapping):
        return {str(key): json_value(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [json_value(item) for item in value]
    if isinstance(value, frozenset):
        return sorted(value)
    if hasattr(value, "tolist"):  # a number or an array of NumPy
        return json_value(value.tolist())
    return None if isinstance(value, float) and not isfinite(value) else value
