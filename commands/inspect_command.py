"""``tirefmu inspect``: what recordings contain, lack and contradict."""

from __future__ import annotations

from pathlib import Path

import click

from ..boundary.errors import TirefmuError
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

#: Rows of a table in the terminal; page and JSON have all of them.
MAX_ROWS = 14


@click.command()
@click.argument("tables", type=FILE, nargs=-1, required=True)
@click.option("-o", "--output", type=FILE, help="HTML page with tables and figures.")
@tables_read
@click.option("--table", "selected", type=FILE,
              help="Write the selected rows of one table as CSV or Parquet, in SI units.")  # fmt: skip
@click.option("--all", "every", is_flag=True, help="List every operating condition, sweep and excluded row.")
@common
def inspect(
    tables: tuple[Path, ...], output: Path | None, selection: TableOptions, selected: Path | None,
    every: bool, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Summarize TABLES, and what the data lack or contradict.

    Channels, sweeps, operating conditions, drifts. Exit code 1 if a finding is serious: a fit of these data would be
    misleading.
    """
    check_output_paths(output, json_file, selected)
    check_input_paths(*tables)
    if selected and len(tables) > 1:
        raise TirefmuError("--table writes the rows of one table")
    from ..measurements import check_columns, recordings_from, write_table
    from ..measurements.checks.recordings.finding import verdict_on
    from ..measurements.inspection import tables as texts
    from ..measurements.inspection.inspection import inspect as run
    from .terminal import Terminal

    terminal = Terminal(quiet)
    recordings = recordings_from(tables, **vars(selection))
    for recording in recordings:
        recording.measured()  # raises for a table without a measured output
        check_columns(recording)
    with terminal.working("inspecting"):
        inspections, findings = run(recordings)
        if selected:
            write_table(recordings[0].table, selected)
        if output:
            from ..measurements.inspection.report import write_inspection

            write_inspection(inspections, findings, output, command=command_line())
    ok = not any(finding.serious for finding in findings)
    write_json(
        json_file,
        {
            "ok": ok,
            "verdict": verdict_on(findings),
            "findings": [vars(finding) for finding in findings],
            "recordings": [inspection.to_json() for inspection in inspections],
        },
    )
    terminal.print(f"verdict: {verdict_on(findings)}")
    terminal.findings(findings)
    for inspection in inspections:
        terminal.heading(inspection.recording.source, texts.title(inspection))
        for name, explanation, content in texts.all_tables(inspection):
            terminal.table(name, content, most=10_000 if every else MAX_ROWS)
            if every and explanation:
                terminal.print(explanation)
        for note in inspection.exclusion.notes if every else ():
            terminal.print(f"excluded from a fit: {note}")
    for path, kind in ((output, "page"), (selected, "selected rows")):
        if path:
            terminal.print(f"{kind}: {path}")
    if ok:
        name = file_name(tables[0].stem)
        written = ("-o", f"{name}.tir", "--report", f"{name}_fit.html")
        terminal.print(f"next: {command_text('fit', *tables, *selection.arguments, *written)}")
    return 0 if ok else 1
