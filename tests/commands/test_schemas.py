"""JSON Schemas: valid, complete, and of one opinion with the readers on every example and on changes of it."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, NamedTuple

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.json_schemas import check_file, objections, validator
from tirefmu.applications.batch import read_jobs, read_study
from tirefmu.applications.driving.inputs.car import read_car
from tirefmu.applications.driving.inputs.car_entries import example_text as car_text
from tirefmu.applications.planning import example_text as bench_text
from tirefmu.applications.planning import read_bench
from tirefmu.applications.project import project_text, read_project, steps_of
from tirefmu.boundary.json_schema import json_value, schema_of
from tirefmu.commands.cli import cli
from tirefmu.commands.schemas import KINDS
from tirefmu.fitting import load_recipe
from tirefmu.symbolic.added import read_effect

ROOT = Path(__file__).parents[2]
#: Effect files with [[acts]]; those without belong to the equations of a model, and users cannot have them.
EFFECTS = [
    path
    for folder in ("symbolic/effects", "docs/effects", "examples/plugins/effect/example_effect")
    for path in sorted((ROOT / folder).glob("*.toml"))
    if "[[acts]]" in path.read_text(encoding="utf-8")
]
RECIPES = sorted((ROOT / "fitting" / "recipes").glob("*.toml"))
#: The indented TOML examples of docs/many_tires.md.
BLOCKS = [
    re.sub(r"^    ", "", block, flags=re.MULTILINE)
    for block in re.findall(
        r"((?:^    .*\n|^\n)+)", (ROOT / "docs" / "many_tires.md").read_text(encoding="utf-8"), flags=re.MULTILINE
    )
]
JOBS = next(block for block in BLOCKS if "[[jobs]]" in block)
STUDY = next(block for block in BLOCKS if "[parameters]" in block)
STATES = (ROOT / "symbolic" / "effects" / "heat_friction.toml").read_text(encoding="utf-8")


#: SHA-256 of each version of each schema without its texts.
DIGESTS = json.loads((Path(__file__).parent / "schema_digests.json").read_text(encoding="utf-8"))


def read_run(path):
    """Read a project as `tirefmu run` does: the options of all steps are checked first."""
    for step in steps_of(read_project(path)):
        cli.commands[step.command].make_context(step.command, list(step.arguments))


#: An example of each kind that is read, and its reader.
EXAMPLES = {
    "project": (project_text(["a.csv"], "mf96", {"Fz0": 220.0}, ["load_friction"], "iso"), read_run),
    "effect": (STATES, lambda path: read_effect(path.read_text(encoding="utf-8"), path.name)),
    "recipe": (RECIPES[0].read_text(encoding="utf-8"), lambda path: load_recipe(str(path), "mf61")),
    "jobs": (JOBS, read_jobs),
    "study": (STUDY, read_study),
    "bench": (bench_text(), read_bench),
    "car": (car_text(), read_car),
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_schema_is_valid_and_has_a_name_and_a_version(kind, command):
    jsonschema.Draft202012Validator.check_schema(validator(kind).schema)
    assert re.fullmatch(rf"urn:tirefmu:schema:{kind}:\d+\.\d+", validator(kind).schema["$id"])
    assert json.loads(command("schema", kind).out) == validator(kind).schema
    assert kind in command("schema").out


def without_texts(schema):
    """Return a schema without its titles and descriptions, which say the same in other words."""
    if isinstance(schema, dict):
        texts = [key for key in ("title", "description") if isinstance(schema.get(key), str)]
        return {key: without_texts(part) for key, part in schema.items() if key not in texts}
    return [without_texts(part) for part in schema] if isinstance(schema, list) else schema


@pytest.mark.parametrize("kind", KINDS)
def test_a_changed_schema_has_a_new_version(kind):
    """Add the entry of a new version; never change that of a released one."""
    version = validator(kind).schema["$id"].rsplit(":", 1)[1]
    text = json.dumps(without_texts(validator(kind).schema), sort_keys=True)
    assert DIGESTS[kind].get(version) == hashlib.sha256(text.encode()).hexdigest(), f"increment the version of {kind}"


def test_there_is_no_digest_of_another_kind():
    assert DIGESTS.keys() == KINDS.keys()


@pytest.mark.parametrize("path", EFFECTS, ids=lambda path: path.stem)
def test_every_effect_of_the_tree_is_valid(path):
    check_file("effect", path)


@pytest.mark.parametrize("path", RECIPES, ids=lambda path: path.stem)
def test_every_recipe_is_valid(path):
    check_file("recipe", path)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_the_examples_are_valid(kind, tmp_path):
    text, reader = EXAMPLES[kind]
    (tmp_path / "heat_friction.toml").write_text(text, encoding="utf-8")
    reader(tmp_path / "heat_friction.toml")
    check_file(kind, tmp_path / "heat_friction.toml")


def test_files_that_commands_write_are_valid(command, chain, validated, bench_csv, tmp_path):
    check_file("fit", chain[0] / "fit.json")
    assert objections("fit", validated[1]) == []
    assert validated[1]["held_out"]
    project = tmp_path / "tirefmu.toml"
    arguments = (bench_csv, "--model", "mf96", "--nominal", "Fz0=220,R0=0.23", "-o", project)
    assert command("init", *arguments).status == 0
    assert project.read_text(encoding="utf-8").startswith("#:schema ./tirefmu-project.schema.json\n")
    check_file("project", project)
    assert command("drive", "--example", tmp_path / "car.toml").status == 0
    check_file("car", tmp_path / "car.toml")


@dataclass(frozen=True)
class Sample:
    """A result of the kinds of fields that results have."""

    number: float
    name: str | None
    flags: tuple[bool, ...]
    pairs: dict[str, tuple[float, int]]


@given(st.builds(Sample))
def test_the_values_of_a_class_follow_its_schema(sample):
    """Also numbers that are not finite, which JSON does not have."""
    values = json.loads(json.dumps(json_value(sample), allow_nan=False))
    jsonschema.validate(values, schema_of(Sample, missing=True))
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({**values, "name": 1}, schema_of(Sample, missing=True))


class Extent(NamedTuple):
    """A named tuple is an object, too."""

    rms: float
    largest: float


@dataclass(frozen=True)
class Listed:
    """A result whose keys are those of its parts, and what it derives from them."""

    JSON_KEYS: ClassVar = ("version", "sample.number", "sample.name as called", "extent", "tags", "large")
    version: ClassVar[str] = "1.0"

    sample: Sample
    extent: Extent
    tags: frozenset[str]

    @property
    def large(self) -> bool:
        """Whether the number is large."""
        return self.sample.number > 1.0


def test_the_keys_of_a_class_may_be_attributes_of_its_parts_and_properties():
    listed = Listed(Sample(2.0, "a", (), {}), Extent(1.0, float("inf")), frozenset("cab"))
    assert json_value(listed) == {
        "version": "1.0", "number": 2.0, "called": "a", "extent": {"rms": 1.0, "largest": None},
        "tags": ["a", "b", "c"], "large": True,
    }  # fmt: skip
    schema = schema_of(Listed, missing=True)
    jsonschema.validate(json_value(listed), schema)
    assert schema["properties"]["large"] == {"type": "boolean", "description": "Whether the number is large."}
    with pytest.raises(KeyError):
        schema_of(type("Wrong", (Listed,), {"JSON_KEYS": ("sample.absent",)}))


def test_the_schema_of_a_fit_has_the_fields_of_its_parts():
    """A bootstrap and temperatures, which no fit here has, follow from their classes."""
    properties = validator("fit").schema["properties"]
    assert {"type": "null"} in properties["bootstrap"]["anyOf"]
    assert "holdout_rmse" in properties["temperature"]["anyOf"][0]["required"]
