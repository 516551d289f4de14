"""The command line: ``tirefmu COMMAND``. Exit codes: 0 success, 1 completed but a check failed, 2 invalid input.

A command imports its packages when it runs and its files exist: SymPy, pandas, CasADi and Matplotlib would delay every
``--help`` and every error message. TIRE is a .tir file or the name of a published tire.
"""

from __future__ import annotations

import io
import shlex
import sys
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

import click

from .. import commands
from ..boundary.errors import TirefmuError
from ..boundary.escaping import command_text, excerpt, file_name, visible
from .arguments import (
    DRAW_SIGNS,
    FILE,
    RADIUS,
    TableOptions,
    check_input_paths,
    check_output_paths,
    command_line,
    common,
    numbers,
    tables_read,
    write_json,
)
from .command_help import SectionedGroup, add_examples


@click.group(cls=SectionedGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="tirefmu")
def cli() -> None:
    """From tire bench data to a fitted Magic Formula tire, exported as an FMU and checked against the data.

    Exit codes: 0 success, 1 completed but a check failed, 2 invalid input.
    """


@cli.command()
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

    If TABLE has a column t and TIRE a relax_* effect, the slips have a first-order lag.
    """
    check_output_paths(output, json_file)
    check_input_paths(tire, table)
    from ..measurements import column_notes, recording_from, write_table
    from ..tires import tire_from
    from ..tires.property_file.use import use_notes
    from .terminal import Terminal

    terminal = Terminal(quiet)
    loaded = tire_from(tire, radius=radius)
    recording = recording_from(table, **vars(selection))
    if incomplete := recording.about.get("incomplete"):
        raise TirefmuError(f"{table}: {incomplete}: evaluate needs every input of every row")
    terminal.selection(recording)
    with terminal.working(f"evaluating {len(recording)} rows"):
        result = loaded.evaluate(recording, code=code, **conventions)
        write_table(result, output)
    rows, columns = len(result), list(result.columns)
    absent = [name for name in loaded.inputs if name not in recording.table]
    warnings = column_notes(recording, fitted=False)
    summary = {
        "ok": True, "rows": rows, "signs": recording.signs, **conventions, "nominal": absent,
        "warnings": warnings,
    }  # fmt: skip
    write_json(json_file, {**summary, "output": str(output), "columns": columns})
    terminal.print(f"{rows} rows, {len(columns)} columns, signs {recording.signs}: {output}")
    if absent:
        terminal.print(f"not in the table, nominal values used: {', '.join(absent)}")
    terminal.print(*(f"note: {note}" for note in use_notes(loaded)))
    terminal.print(*(f"warning: {warning}" for warning in warnings))
    return 0


@cli.command()
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

    fmpy simulates it; direct evaluation of its tire must agree. FMU runs in a separate process: a crash or a hang is
    reported as an error. It is native code with your permissions.
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


@cli.command()
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

    loaded = tire_from(tire, radius=radius)
    summary = describe(loaded, read_tir_with_notes(tire, radius).notes if tire.is_file() else ())
    write_json(json_file, summary)
    Terminal(quiet).tire(loaded, summary, every)
    return 0


@cli.command()
@click.argument("tire", type=FILE)
@click.argument("tables", type=FILE, nargs=-1)
@click.option("-o", "--output", type=FILE, required=True, help="Folder to write.")
@click.option("--loads", type=numbers, metavar="NUMBER,...",
              help="Loads in N (default: those of TABLES, or three over the tire's range).")  # fmt: skip
@click.option("--kappa", type=numbers, metavar="LOW,HIGH",
              help="Range of kappa, such as -1.1,1.1 (default: that of the tire, at most -1,1).")  # fmt: skip
@DRAW_SIGNS
@tables_read
@click.option("--format", "suffix", type=click.Choice(["png", "svg", "pdf"]), default="png", show_default=True)
@common
def draw(
    tire: Path, tables: tuple[Path, ...], output: Path, loads: tuple[float, ...] | None,
    kappa: tuple[float, ...] | None, selection: TableOptions,
    draw_signs: str | None, suffix: str, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Draw TIRE at several loads.

    Pure slip, surfaces of Fx and Fy over both slips, Fy against Fx. Measured rows of TABLES are drawn as points.
    """
    check_output_paths(json_file, folder=output)
    check_input_paths(tire, *tables)
    from ..tires import tire_from
    from ..tires.description import limits_of
    from ..tires.drawing.files import draw as run
    from ..tires.drawing.tire_figures import default_loads
    from ..tires.property_file.use import use_notes
    from .terminal import Terminal

    terminal = Terminal(quiet)
    loaded = tire_from(tire)
    points = None
    if tables:
        import pandas as pd

        from ..measurements import check_columns, levels, recordings_from

        recordings = recordings_from(tables, **vars(selection))
        terminal.selection(*recordings)
        for recording in recordings:
            check_columns(recording, fitted=False)
        parts = [recording.with_signs("iso").table for recording in recordings]
        nominal = loaded.in_signs("iso").nominal("Fz")
        points = pd.concat([part.assign(Fz=part.get("Fz", nominal)) for part in parts], ignore_index=True)
        measured = dict.fromkeys(float(f"{level:.2g}") for level in levels(points["Fz"]))
        loads = tuple(measured) or None if loads is None else loads
    loads = default_loads(loaded) if loads is None else loads
    shown = draw_signs or selection.signs or "iso"
    with terminal.working("drawing"):
        drawn = run(loaded, output, loads=loads, signs=shown, suffix=suffix, points=points, kappa=kappa)
    write_json(json_file, {"ok": True, "loads": list(loads), "signs": shown, "figures": [str(p) for p in drawn]})
    terminal.print(f"figures at {', '.join(f'{load:g}' for load in loads)} N, signs {shown}:")
    for path in drawn:
        terminal.print(f"  {path}")
    terminal.print(*(f"note: {note}" for note in use_notes(loaded)))
    terminal.print(*(f"note: {note}" for note in limits_of(loaded)))
    return 0


@cli.command()
@click.option("-o", "--output", type=FILE, default=Path("demo-output"), show_default=True, help="Folder to write.")
@common
def demo(output: Path, quiet: bool, json_file: Path | None) -> int:
    """Run the full workflow on the virtual bench.

    Measurement, fit, tire, FMU, check, a missing effect; a page tells the story.
    """
    check_output_paths(json_file, folder=output)
    from .demo import run
    from .terminal import Terminal

    terminal = Terminal(quiet)
    summary = run(output, terminal)
    write_json(json_file, summary)
    return 0 if summary["ok"] else 1


for module in iter_modules(commands.__path__, f"{commands.__name__}."):
    if module.name.endswith(("_command", "_commands")):
        for value in vars(import_module(module.name)).values():
            if isinstance(value, click.Command):
                cli.add_command(value)
add_examples(cli)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code.

    `arguments`: none for the arguments of the process. Returns: 0: success; 1: completed, but a check failed; 2:
    invalid input.

    >>> main(["info", "missing.tir", "--quiet"])
    2
    """
    return run(cli, "tirefmu", arguments)


def run(command: click.Command, name: str, arguments: list[str] | None) -> int:
    """Run a command and return its exit code; an error is one line."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # for encodings that lack a character of a file name
    try:
        given = sys.argv[1:] if arguments is None else arguments
        line = shlex.join([name, *given])
        status = command.main(args=given or ["--help"], prog_name=name, standalone_mode=False, obj=line)
    except TirefmuError as error:
        return _invalid(name, str(error))
    except click.ClickException as error:
        return _invalid(name, _usage(error))
    except OSError as error:  # a name that is too long, a disk that is full
        return _invalid(name, f"{excerpt(error.filename, 200)}: {error.strerror}" if error.filename else str(error))
    except (click.Abort, KeyboardInterrupt):
        print(f"{name}: interrupted", file=sys.stderr)
        return 130
    return int(status or 0)


def _usage(error: click.ClickException) -> str:
    """Return the message of an error in the command line; of an unknown name with the command that lists all."""
    message = " ".join(error.format_message().split())
    unknown = {"No such option": "options", "No such command": "commands"}
    listed = next((kind for start, kind in unknown.items() if message.startswith(start)), "")
    context = error.ctx if isinstance(error, click.UsageError) else None
    return f"{message} {context.command_path} --help lists all {listed}." if listed and context else message


def _invalid(name: str, message: str) -> int:
    print(f"{name}: error: {visible(message)}", file=sys.stderr)
    return 2
