"""``tirefmu info``: what is in a tire."""

from __future__ import annotations

from pathlib import Path

import click

from .arguments import (
    FILE,
    RADIUS,
    check_input_paths,
    check_output_paths,
    common,
    write_json,
)
from .command import command


@command(
    section="Work with a tire", place=1,
    examples=(
        "info my.tir",
        "info trento_hoosier --all",
    ),
)  # fmt: skip
@click.argument("tire", type=FILE)
@click.option(
    "--all", "every", is_flag=True, help="List every coefficient, assumed values, other contents of the file."
)
@RADIUS
@common
def info(tire: Path, every: bool, radius: float | None, quiet: bool, json_file: Path | None) -> int:
    """Summarize TIRE: model, ranges, effects, coefficients, warnings."""
    check_output_paths(json_file)
    check_input_paths(tire)
    from ..tires import tire_from
    from ..tires.description import describe
    from ..tires.property_file.reading import read_tir_with_notes
    from .terminal import Terminal

    read = read_tir_with_notes(tire, radius) if tire.is_file() else None
    loaded = read.tire if read else tire_from(tire, radius=radius)
    summary = describe(loaded, read.notes if read else ())
    write_json(json_file, summary)
    Terminal(quiet).tire(loaded, summary, every)
    return 0
