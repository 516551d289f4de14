"""``tirefmu check``: an FMU simulated over a table, compared with the data; or its proof repeated."""

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
from .command import command


@command(
    section="From a recording to a tire", place=5,
    examples=(
        "check my.fmu run.csv",
        "check my.fmu",
        "check my.fmu run.csv --tolerance 0.05 --figures figures",
    ),
)  # fmt: skip
@click.argument("fmu", type=FILE)
@click.argument("table", type=FILE, required=False)
@tables_read
@click.option(
    "--tolerance",
    type=click.FloatRange(min=0.0),
    help="Exit with code 1 if a channel's RMSE exceeds this share of its largest value.",
)
@click.option("--timeout", type=click.FloatRange(min=0.0, min_open=True), metavar="SECONDS",
              help="Time limit of the simulation  [default: 60, plus 0.005 per row]")  # fmt: skip
@click.option("--figures", type=FILE, help="Folder for figures of the data, the FMU and the error over time.")
@click.option("--report", type=FILE, help="HTML report: verdict, goodness of fit, errors over time and inputs.")
@common
def check(
    fmu: Path, table: Path | None, selection: TableOptions, tolerance: float | None, timeout: float | None,
    figures: Path | None, report: Path | None, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Simulate FMU over TABLE and compare it with the data.

    Without TABLE, the proof inside FMU is repeated.

    fmpy simulates the FMU, and the outputs must agree with direct evaluation of its tire. The FMU is native code and
    runs with your permissions, in a separate process: a crash or a hang is reported as an error.
    """
    check_output_paths(json_file, report, folder=figures)
    check_input_paths(fmu, table)
    if table is None:
        if selection.arguments or tolerance is not None or figures or report:
            raise TirefmuError("options of tables, --tolerance, --figures and --report need a TABLE")
        return _repeated_proof(fmu, timeout, json_file, quiet)
    from ..fmu import check as run
    from ..measurements import incomplete_rows, recording_from
    from .terminal import Terminal

    terminal = Terminal(quiet)
    recording = recording_from(table, **vars(selection))
    terminal.selection(recording)
    terminal.findings(incomplete_rows(recording))
    with terminal.working(f"simulating {fmu.name} over {table.name}"):
        result = run(fmu, recording, tolerance=tolerance, timeout=timeout)
    write_json(json_file, result.to_json())
    for name, statement in (("FMU", result.of_fmu), ("tire", result.of_tire)):
        terminal.graded(f"{name}: ", statement.text, statement.grade)
    terminal.print(*str(result).split("\n"))
    if figures:
        from ..fmu.comparison.figures import draw_check

        terminal.print(f"figures: {len(draw_check(result, figures))} in {figures}")
    if report:
        from ..fmu.comparison.report import write_check

        with terminal.working("writing the report"):
            write_check(result, report, command=command_line())
        terminal.print(f"report: {report}")
    else:
        page = ("--report", fmu.with_name(f"{file_name(fmu.stem)}_check.html"))
        terminal.print(f"next: {command_text('check', fmu, table, *selection.arguments, *page)}")
    return 0 if result.ok else 1


def _repeated_proof(fmu: Path, timeout: float | None, json_file: Path | None, quiet: bool) -> int:
    """Repeat the proof of an FMU and print the result; return the exit code."""
    from ..fmu import repeat_proof
    from .terminal import Terminal

    terminal = Terminal(quiet)
    with terminal.working(f"repeating the proof of {fmu.name}"):
        result = repeat_proof(fmu, timeout=timeout)
    write_json(json_file, result.to_json())
    terminal.print(*str(result).split("\n"))
    return 0 if result.ok else 1
