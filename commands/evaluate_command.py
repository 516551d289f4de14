"""``tirefmu evaluate``: forces of a tire for every row of a table."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from warnings import catch_warnings, simplefilter

import click

from ..boundary.errors import TirefmuError
from .arguments import (
    FILE,
    RADIUS,
    TableOptions,
    check_input_paths,
    check_output_paths,
    common,
    tables_read,
    write_json,
)
from .command import command


@command(
    section="Work with a tire", place=2,
    examples=(
        "evaluate my.tir table.csv -o forces.csv",
        "evaluate trento_hoosier run.mat -o forces.parquet --steady",
    ),
)  # fmt: skip
@click.argument("tire", type=FILE)
@click.argument("table", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="CSV or Parquet file to write.")
@click.option(
    "--convention",
    type=click.Choice(["tno", "book"]),
    default="tno",
    show_default=True,
    help="MF5.2 to 6.2: as in industrial solvers, or as in Pacejka (2012).",
)
@click.option(
    "--slip-angle",
    type=click.Choice(["tan", "angle"]),
    default="tan",
    show_default=True,
    help="MF5.2 to 6.2: alpha* and gamma* are tangent and sine, or the angles.",
)
@tables_read
@click.option("--limits", is_flag=True, help="Clamp the inputs to the valid range of the tire.")
@click.option("--mirror", is_flag=True, help="Evaluate the tire mounted on the other side of the vehicle.")
@click.option("--steady", is_flag=True, help="No transient slip: evaluate each row independently.")
@click.option("--hold", is_flag=True, help="Inputs constant over each step, as in a co-simulation (default: linear).")
@RADIUS
@click.option("--code", type=click.Choice(["auto", "numpy", "c", "casadi", "batch"]), default="auto",
              show_default=True, help="Generated code to use.")  # fmt: skip
@common
def evaluate(
    tire: Path,
    table: Path,
    output: Path,
    selection: TableOptions,
    code: str,
    radius: float | None,
    quiet: bool,
    json_file: Path | None,
    **conventions: Any,
) -> int:
    """Evaluate TIRE for every row of TABLE.

    The result has forces, moments and every named quantity.

    If TABLE has a column t and TIRE has a relax_* effect, the slips have a first-order lag (relaxation).
    """
    check_output_paths(output, json_file)
    check_input_paths(tire, table)
    from ..measurements import column_notes, recording_from, write_table
    from ..tires import tire_from
    from .terminal import Terminal

    terminal = Terminal(quiet)
    loaded = tire_from(tire, radius=radius)
    recording = recording_from(table, **vars(selection))
    if incomplete := recording.about.get("incomplete"):
        raise TirefmuError(f"{table}: {incomplete}: evaluate needs every input of every row")
    terminal.selection(recording)
    with terminal.working(f"evaluating {len(recording)} rows"):
        with catch_warnings(record=True) as caught:
            simplefilter("always")
            result = loaded.evaluate(recording, code=code, **conventions)
        write_table(result, output)
    rows, columns = len(result), list(result.columns)
    absent = [name for name in loaded.inputs if name not in recording.table]
    warnings = [*column_notes(recording, fitted=False), *(str(warning.message) for warning in caught)]
    summary = {
        "ok": True, "rows": rows, "signs": recording.signs, **conventions, "nominal": absent,
        "warnings": warnings,
    }  # fmt: skip
    write_json(json_file, {**summary, "output": str(output), "columns": columns})
    terminal.print(f"{rows} rows, {len(columns)} columns, signs {recording.signs}: {output}")
    if absent:
        terminal.print(f"not in the table, nominal values used: {', '.join(absent)}")
    terminal.print(*(f"warning: {warning}" for warning in warnings))
    return 0
