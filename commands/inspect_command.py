"""``tirefmu inspect``: what recordings contain, lack and contradict; the columns of the log of a drive."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..boundary.errors import TirefmuError, writing
from ..boundary.escaping import command_text, file_name
from .arguments import (
    FILE,
    TableOptions,
    check_input_paths,
    check_output_paths,
    command_line,
    common,
    tables_read,
    write_json,
)
from .command import command

if TYPE_CHECKING:
    from ..measurements.files.columns.content import Content

#: Rows of a table in the terminal; page and JSON have all of them.
MAX_ROWS = 14


@command(
    section="From a recording to a tire", place=1,
    examples=(
        "inspect cornering.mat drivebrake.mat -o page.html",
        'inspect run.csv --where "p in 70..90 kPa"',
        "inspect run.csv --columns Fy=FYC,alpha=-SA --units alpha=deg,Fz=lbf",
    ),
)  # fmt: skip
@click.argument("tables", type=FILE, nargs=-1, required=True)
@click.option(
    "-o",
    "--output",
    type=FILE,
    help="HTML page with tables and figures; for a log, the car file (.toml) with its [columns].",
)
@tables_read
@click.option("--table", "selected", type=FILE,
              help="Write the selected rows of one table as CSV or Parquet, in SI units.")  # fmt: skip
@click.option("--all", "every", is_flag=True, help="List every operating condition, sweep and excluded row.")
@common
def inspect(
    tables: tuple[Path, ...], output: Path | None, selection: TableOptions, selected: Path | None,
    every: bool, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Summarize TABLES and list the problems in the data.

    The summary has channels, sweeps, operating conditions and drifts. Exit code 1: a problem is serious, and a fit of
    these data would be misleading. For the log of a drive: its columns, and the probable channel of each.
    """
    check_output_paths(output, json_file, selected)
    check_input_paths(*tables)
    if selected and len(tables) > 1:
        raise TirefmuError("--table writes the rows of one table")
    car_file = output is not None and output.suffix.lower() == ".toml"
    if len(tables) == 1 and not (selection.signs or selection.where or selected) and (car_file or not output):
        from ..applications.driving.inputs.nearest_channel import is_drive_log
        from ..measurements.files.reading import read_content

        content = read_content(tables[0])
        if car_file or is_drive_log(content, selection.columns or ()):
            return _log(tables[0], content, selection, output, quiet, json_file)
    from ..measurements import recordings_from, write_table
    from ..measurements.inspection import tables as texts
    from ..measurements.inspection.inspection import inspect as run
    from .terminal import Terminal

    terminal = Terminal(quiet)
    recordings = recordings_from(tables, **vars(selection))
    with terminal.working("inspecting"):
        result = run(recordings)
        if selected:
            write_table(recordings[0].table, selected)
        if output:
            from ..measurements.inspection.report import write_inspection

            write_inspection(result, output, command=command_line())
    write_json(json_file, result.to_json())
    terminal.print(f"verdict: {result.verdict}")
    terminal.findings(result.findings)
    for inspection in result.recordings:
        terminal.heading(inspection.recording.source, texts.title(inspection))
        terminal.not_read(inspection.recording.about.get("ignored", ""))
        for name, explanation, table in texts.all_tables(inspection):
            terminal.table(name, table, most=10_000 if every else MAX_ROWS)
            if every and explanation:
                terminal.print(explanation)
        for note in inspection.exclusion.notes if every else ():
            terminal.print(f"excluded from a fit: {note}")
    for path, kind in ((output, "page"), (selected, "selected rows")):
        if path:
            terminal.print(f"{kind}: {path}")
    if result.ok:
        name = file_name(tables[0].stem)
        written = ("-o", f"{name}.tir", "--report", f"{name}_fit.html")
        terminal.print(f"next: {command_text('fit', *tables, *selection.arguments, *written)}")
    return 0 if result.ok else 1


def _log(
    path: Path, content: Content, selection: TableOptions, output: Path | None, quiet: bool, json_file: Path | None
) -> int:  # fmt: skip
    """Print the columns of the log of a drive, and write the proposed section of a car file."""
    from ..applications.driving.inputs.survey import survey
    from .terminal import Terminal

    if output and output.exists():
        raise TirefmuError(f"{output} exists: its numbers would be lost; give another file")
    if selection.units:
        raise TirefmuError("--units is for tables of a bench; for a log: --columns 'NAME=HEADER [unit]'")
    surveyed = survey(content, str(path), selection.columns)
    if output:
        with writing(output):
            output.write_text(surveyed.car_text(), encoding="utf-8")
    columns = [vars(column) for column in surveyed.columns]
    write_json(json_file, {"ok": True, "log": str(path), "columns": columns, "proposal": surveyed.proposal,
                           "notes": surveyed.notes, "ignored": content.ignored})  # fmt: skip
    terminal = Terminal(quiet)
    terminal.print(f"verdict: the log of a drive, {len(columns)} columns of numbers")
    header = ["column", "unit", "samples", "Hz", "longest gap (s)", "lowest", "highest", "probably"]
    rows = [
        [
            f"{column.group}/{column.header}" if column.group else column.header, column.unit, str(column.samples),
            f"{column.rate:.4g}" if column.rate else "", f"{column.longest_gap:.3g}" if column.longest_gap else "",
            f"{column.lowest:.4g}", f"{column.highest:.4g}", column.nearest,
        ]
        for column in surveyed.columns
    ]  # fmt: skip
    terminal.table("Columns", (header, rows), most=10_000)
    terminal.not_read("; ".join(content.ignored))
    terminal.print("proposal for the car file:", *surveyed.section.splitlines())
    if output:
        terminal.print(f"car file: {output}")
    return 0
