"""The JSON Schemas of all files that are read or written, by the kind of the file."""

from __future__ import annotations

from collections.abc import Mapping
from pkgutil import resolve_name
from typing import Any

import click

from ..boundary.errors import UnknownName

#: By kind: what the file is, and the function that returns its schema.
KINDS: Mapping[str, tuple[str, str]] = {
    "project": (
        "tirefmu.toml of the commands init and run",
        "tirefmu.applications.project.project_file:project_schema",
    ),
    "effect": ("effect of a user, or one that a diagnosis proposes", "tirefmu.symbolic.added:effect_schema"),
    "recipe": ("stages of a fit", "tirefmu.fitting.problem.recipe:recipe_schema"),
    "jobs": ("job list of fit-many", "tirefmu.applications.batch.jobs:jobs_schema"),
    "study": ("runs of the command study", "tirefmu.applications.batch.study_file:study_schema"),
    "bench": ("bench file of the command plan", "tirefmu.applications.planning.bench_file:bench_schema"),
    "car": ("car of the command drive", "tirefmu.applications.driving.inputs.car_entries:car_schema"),
    "fit": ("fit.json, the result of a fit", "tirefmu.fitting.fit_result:fit_schema"),
    "diagnosis": ("diagnosis.json, the result of a diagnosis", "tirefmu.diagnosis.verdict.result:diagnosis_schema"),
    "drive": ("drive.json, the answer of the command drive", "tirefmu.applications.driving.result:drive_schema"),
    "plan": ("plan.json, the program of the command plan", "tirefmu.applications.planning.plan:plan_schema"),
    "proof": ("proof.json, the proof inside an FMU", "tirefmu.fmu.proof.proof_content:proof_schema"),
    "run": ("run.json, the records of the command run", "tirefmu.applications.project.records:records_schema"),
}


def schema(kind: str, commands: click.Group) -> dict[str, Any]:
    """Return the JSON Schema of a kind of files.

    `commands`: those whose options the keys of a project file are. Raises `UnknownName` for an unknown kind.
    """
    if kind not in KINDS:
        raise UnknownName("kind of file", kind, KINDS)
    function = resolve_name(KINDS[kind][1])
    arguments = [lambda *option: _option(commands, *option)] if kind == "project" else []
    return dict(function(*arguments))


def _option(commands: click.Group, section: str, option: str) -> dict[str, Any]:
    """Return help and choices of an option of the command of a section; options of [data] are those of fit."""
    command = commands.commands["fit" if section == "data" else section]
    (parameter,) = (
        option_of for option_of in command.params if isinstance(option_of, click.Option) and option in option_of.opts
    )
    choices = {"enum": list(parameter.type.choices)} if isinstance(parameter.type, click.Choice) else {}
    return {"description": parameter.help, **choices}
