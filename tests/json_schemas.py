"""Files compared with the JSON Schemas that the program publishes."""

from __future__ import annotations

import json
import tomllib
from functools import cache

import jsonschema

from tirefmu.commands.cli import cli
from tirefmu.commands.schemas import schema


@cache
def validator(kind):
    """Return what checks the content of a kind of files."""
    return jsonschema.Draft202012Validator(schema(kind, cli))


def objections(kind, content):
    """Return how a content differs from the schema of its kind."""
    return [f"{error.json_path}: {error.message[:200]}" for error in validator(kind).iter_errors(content)]


def check_file(kind, path):
    """Check a file; one that names a schema has that of its kind beside it."""
    text = path.read_text(encoding="utf-8")
    content = tomllib.loads(text) if path.suffix == ".toml" else json.loads(text)
    assert objections(kind, content) == [], path
    if text.startswith("#:schema"):
        named = json.loads((path.parent / text.split()[1]).read_text(encoding="utf-8"))
        assert named == schema(kind, cli)
