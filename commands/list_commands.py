"""``tirefmu effects``, ``models``, ``published``, ``columns``, ``schema``: what there is, and kinds of files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .arguments import FILE, all_commands, check_output_paths, common, write_json
from .command import command


@command(
    section="What there is", place=3,
    examples=(
        "effects --model mf61",
        "effects temp_friction",
    ),
)  # fmt: skip
@click.argument("name", required=False)
@click.option("--model", help="Only effects that a tire of this model can have.")
@common
def effects(name: str | None, model: str | None, quiet: bool, json_file: Path | None) -> int:
    """List the effects of tires, or describe the effect NAME.

    A description has the formula, the coefficients, and how to measure it. Kinds: default (part of the model), optional
    (part of it on request), library (an addition to any model).
    """
    check_output_paths(json_file)
    from ..measurements.catalogue import effects as found_effects
    from .terminal import Terminal

    effects = found_effects(name, model)
    write_json(json_file, {"ok": True, "effects": effects})
    terminal = Terminal(quiet)
    if name:
        for effect in effects:
            terminal.print(*_description(effect))
            rows = [
                [key, coefficient["unit"], _bounds(coefficient["bounds"]), coefficient["description"]]
                for key, coefficient in effect["coefficients"].items()
            ]
            terminal.table("", (["coefficient", "unit", "bounds", "description"], rows))
        return 0
    rows = [[effect["name"], effect["kind"], ", ".join(effect["models"]), effect["physics"]] for effect in effects]
    terminal.table("", (["effect", "kind", "models", "description"], rows))
    terminal.print("tirefmu effects NAME describes one")
    return 0


def _description(effect: dict[str, Any]) -> list[str]:
    lines = [f"{effect['name']} ({effect['kind']}): {effect['physics']}"]
    lines += [f"  source: {effect['source']}"] if effect["source"] else []
    lines.append(f"  models: {', '.join(effect['models'])}")
    for formula in effect["formulas"]:
        lines += [
            f"  {formula['on']} * ({formula['factor']})"
            if "factor" in formula
            else f"  {formula['on']} + {formula['term']}"
        ]
    for key, title in (("states", "states"), ("needs", "inputs that must vary to find it"), ("channels", "channels"),
                       ("confounded_with", "confounded with")):  # fmt: skip
        lines += [f"  {title}: {', '.join(effect[key])}"] if effect[key] else []
    return [*lines, f"  to measure it: {effect['separate_by']}"] if effect["separate_by"] else lines


def _bounds(bounds: list[float | None]) -> str:
    return " to ".join("-" if bound is None else f"{bound:g}" for bound in bounds)


@command(
    section="What there is", place=2,
    examples=(
        "models",
        "models --json models.json",
    ),
)  # fmt: skip
@common
def models(quiet: bool, json_file: Path | None) -> int:
    """List the tire models.

    Inputs, outputs, number of coefficients, recipes of a fit.
    """
    check_output_paths(json_file)
    from ..measurements.catalogue import models as found_models
    from .terminal import Terminal

    models = found_models()
    write_json(json_file, {"ok": True, "models": models})
    rows = [
        [
            model["name"],
            " ".join(model["inputs"]),
            " ".join(model["outputs"]),
            str(model["coefficients"]),
            model["title"],
        ]
        for model in models
    ]
    Terminal(quiet).table("", (["model", "inputs", "outputs", "coefficients", "description"], rows))
    return 0


@command(
    section="What there is", place=4,
    examples=(
        "published",
    ),
)  # fmt: skip
@common
def published(quiet: bool, json_file: Path | None) -> int:
    """List the published tires. Every command takes their names in place of a file."""
    check_output_paths(json_file)
    from ..measurements.catalogue import published_tires
    from .terminal import Terminal

    tires = published_tires()
    write_json(json_file, {"ok": True, "published": tires})
    rows = [[tire["name"], tire["model"], f"{tire['Fz0']:g}", f"{tire['R0']:g}", tire["tire"]] for tire in tires]
    terminal = Terminal(quiet)
    terminal.table("", (["tire", "model", "Fz0 (N)", "R0 (m)", "description"], rows))
    terminal.print("tirefmu info NAME shows source, ranges and coefficients")
    return 0


@command(
    section="What there is", place=5,
    examples=(
        "schema",
        "schema recipe -o recipe.schema.json",
    ),
)  # fmt: skip
@click.argument("kind", required=False)
@click.option("-o", "--output", type=FILE, default=Path("-"), help="File to write (default: standard output).")
@common
@click.pass_context
def schema(context: click.Context, kind: str | None, output: Path, quiet: bool, json_file: Path | None) -> int:
    """List the kinds of files, or write the JSON Schema of KIND.

    With it, editors complete and check the keys of TOML files, and programs check results. A TOML file names its schema
    in the first line: #:schema ./FILE
    """
    check_output_paths(output, json_file)
    from .schemas import KINDS
    from .schemas import schema as schema_of
    from .terminal import Terminal

    terminal = Terminal(quiet)
    if kind is None:
        write_json(json_file, {"ok": True, "kinds": {name: text for name, (text, _) in KINDS.items()}})
        terminal.table("", (["kind", "file"], [[name, text] for name, (text, _) in KINDS.items()]))
        terminal.print("tirefmu schema KIND writes one")
        return 0
    write_json(output, schema_of(kind, all_commands(context)))
    if str(output) != "-":
        write_json(json_file, {"ok": True, "schema": str(output)})
        terminal.print(f"schema: {output}")
    return 0


@command(
    section="What there is", place=1,
    examples=(
        "columns",
    ),
)  # fmt: skip
@common
def columns(quiet: bool, json_file: Path | None) -> int:
    """List the columns of tables with their units and names.

    A header may declare a unit: alpha [deg]. --columns and --units of a command replace headers. A table with the
    columns ET, SA, IA and FZ is read as an FSAE TTC file, by its names, in its units and in SAE signs. A message
    suggests the channel also for names in German, French, Italian and Spanish.
    """
    check_output_paths(json_file)
    from ..measurements.catalogue import columns as known_columns
    from .terminal import Terminal

    columns = known_columns()
    write_json(json_file, {"ok": True, "columns": columns})
    rows = [
        [column["name"], column["meaning"], column["unit"], " ".join(column["units"]), " ".join(column["ttc"]),
         " ".join(column["aliases"])]
        for column in columns
    ]  # fmt: skip
    terminal = Terminal(quiet)
    header = ["channel", "meaning", "SI unit", "units in a header", "FSAE TTC", "a message suggests it for"]
    terminal.table("", (header, rows), most=len(rows))
    return 0
