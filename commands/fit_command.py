"""``tirefmu fit``: a tire from recordings, with its verdict, findings about the data, figures and report."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..boundary.errors import writing
from ..boundary.escaping import command_text, file_name
from ..fitting.options import Declaration, declared_options
from .arguments import (
    FILE,
    MODEL,
    Spread,
    TableOptions,
    check_input_paths,
    check_output_paths,
    command_line,
    common,
    grouped,
    names,
    numbers_by_name,
    tables_read,
    write_json,
)
from .command import command

if TYPE_CHECKING:
    from ..fitting import FitResult
    from ..measurements import DataFinding, Recording
    from ..tires import Tire


@dataclass(frozen=True)
class Checks:
    """What is computed of a fit in addition: cross-validation, bootstrap."""

    folds: int | None
    replicates: int | None


def _weight(text: str) -> tuple[str, float]:
    """Read ``FACTOR: EXPRESSION``."""
    factor, colon, expression = text.partition(":")
    try:
        return expression.strip(), float(factor if colon else "")
    except ValueError:
        raise click.BadParameter(f"{text!r} is not like '2: Fz in 200..240 N'") from None


def _fit_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of `tirefmu.fit`."""
    for name, (option, default) in reversed(declared_options().items()):
        shown = option.kind in ("text", "integer", "number") and default is not None
        add = click.option(option.flag, name, help=option.help, show_default=shown, **_taken(option, default))
        function = add(function)
    return function


def _taken(option: Declaration, default: Any) -> dict[str, Any]:
    """Return how the command line takes the value of an option, by its kind."""
    if option.kind == "names":
        return {"callback": names, "default": None if default is None else "none"}
    if option.kind == "flag":
        return {"is_flag": True, "callback": lambda context, parameter, off: not off}
    if option.kind == "pairs":
        empty = {"callback": lambda context, parameter, pairs: default if pairs is None else pairs}
        return {"type": numbers_by_name, "metavar": "NAME=VALUE,...", **empty}
    if option.kind == "weights":
        collected = {"multiple": True, "callback": lambda context, parameter, pairs: dict(pairs)}
        return {"type": _weight, "metavar": option.metavar, **collected}
    if option.kind in ("integer", "number"):
        number = click.IntRange if option.kind == "integer" else click.FloatRange
        return {"type": number(min=option.least), "default": default}
    return {"metavar": option.metavar, "default": default}


@command(
    section="From a recording to a tire", place=2,
    examples=(
        "fit cornering.mat drivebrake.mat --model mf61 -o my.tir --report fit.html",
        "fit run.csv --model mf96 --nominal Fz0=700,R0=0.23 --effects load_friction,camber_thrust -o my.tir",
        "fit run.csv --start my.tir --recipe scaling -o scaled.tir",
    ),
)  # fmt: skip
@click.argument("tables", type=FILE, nargs=-1, required=True)
@MODEL
@click.option("-o", "--output", type=FILE, required=True, help="Tire file (.tir) to write.")
@click.option(
    "--start",
    type=click.Path(),
    help="Tire with initial values, or 'features' to read them from the data (default: generic).",
)
@_fit_options
@tables_read
@click.option("--cross-validate", "folds", type=click.IntRange(min=2),
              help="Also predict operating conditions out of sample, with this number of folds.")  # fmt: skip
@click.option("--bootstrap", "replicates", type=int, metavar="N",
              help="Percentile intervals from N fits with random weights of sweeps (200 or more).")  # fmt: skip
@click.option("--workers", type=click.IntRange(min=1),
              help="Processes for --bootstrap  [default: the processors], and for --cross-validate  "
                   "[default: the one of the fit]")  # fmt: skip
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler for --bootstrap and --cross-validate.")
@click.option("--figures", type=FILE, help="Folder for figures of the fit against the data.")
@click.option("--report", type=FILE, help="HTML report with tables and figures.")
@click.option("--all", "every", is_flag=True, help="List every coefficient, constraint and stage.")
@common
@grouped(checks=Checks, spread=Spread)
def fit(
    tables: tuple[Path, ...], model: str | None, output: Path, selection: TableOptions, checks: Checks,
    spread: Spread, figures: Path | None, report: Path | None, every: bool, quiet: bool, json_file: Path | None,
    **options: Any,
) -> int:  # fmt: skip
    """Fit a tire to TABLES under physical constraints.

    TABLES are bench files, CSV or Parquet. The output starts with a verdict: good, usable with limits, or not usable
    (exit code 1), with the reasons.

    Ctrl-C stops a fit; the best values so far are written, and the exit code is 1.
    """
    check_output_paths(output, json_file, report, folder=figures)
    check_input_paths(*tables)
    from ..measurements import check_columns, recordings_from
    from .terminal import Terminal

    terminal = Terminal(quiet)
    recordings = recordings_from(tables, **vars(selection))
    for recording in recordings:  # before the slower imports
        check_columns(recording)
    terminal.selection(*recordings)
    from ..applications.batch.intervals import bootstrap
    from ..applications.batch.intervals import cross_validate as distributed
    from ..fitting import assign_folds, cross_validate
    from ..fitting import fit as run
    from ..fitting.resampling.bootstrap import check_replicates

    if checks.replicates is not None:
        check_replicates(checks.replicates, recordings)
    if checks.folds:
        assign_folds(recordings, checks.folds)  # raises before the fit if there are too few parts
    workers = vars(spread)
    with terminal.fitting() as progress:
        result = run(recordings, model, progress=progress, **options)
    if checks.folds and not result.run.interrupted:
        # The fit of a fold has the other folds' rows.
        distributes = any(workers.values())
        expected = None if distributes else (checks.folds, (checks.folds - 1) * result.run.seconds)
        with terminal.counting("cross-validation", singly=True, expected=expected) as counted:
            parts: dict[str, Any] = {"folds": checks.folds, "whole": result, **options}
            held_out = (
                distributed(recordings, model, progress=counted, **workers, **parts)
                if distributes
                else cross_validate(recordings, model, compute=partial(_one_by_one, counted), **parts)
            )
        result = replace(result, held_out=held_out)
    result = replace(result, tire=replace(result.tire, name=result.tire.name or output.stem))
    result.tire.save(output)
    if checks.replicates and not result.run.interrupted:
        with terminal.counting("bootstrap") as counted:
            seed: int = options["seed"]
            result = bootstrap(result, recordings, checks.replicates, seed=seed, progress=counted, **workers)
    residual = _residual_findings(result.tire, output, tables, recordings, selection.arguments)
    result = replace(result, data_findings=(*result.data_findings, *residual))
    write_json(json_file, result.to_json())
    terminal.fit_result(result, every)
    terminal.print(f"tire: {output}")
    drawn = None
    if figures:
        from ..drawing.picture import write_figures
        from ..fitting.reporting.figures import figures_of

        with terminal.working("drawing figures"):
            drawn = figures_of(result, recordings)
            with writing(figures):
                write_figures(drawn, figures)
        terminal.print(f"figures: {len(drawn)} in {figures}")
    if report:
        from ..fitting.reporting.report import write_report

        with terminal.working("writing the report"):
            write_report(result, recordings, report, drawn, findings=result.data_findings, command=command_line())
        terminal.print(f"report: {report}")
    if not result.run.interrupted:
        terminal.print(f"next: {_next_command(result, output, tables, selection.arguments)}")
    return 0 if result.verdict.usable else 1


def _next_command(result: FitResult, tire: Path, tables: Sequence[Path], chosen: Sequence[str]) -> str:
    """Return the diagnosis of the recording whose error is farthest above its noise floor, or the export.

    The options `chosen` select and interpret the rows.
    """
    from ..fitting.results.verdict import lacks_something
    from ..numerics.ties import graded

    sources = list(dict.fromkeys(c.recording for c in result.channels))
    lacking = [c for c in result.channels if lacks_something(c)]
    if not lacking or len(sources) != len(tables):
        return command_text("export", tire, "-o", tire.with_suffix(".fmu"))
    worst = max(lacking, key=lambda c: graded(c.above_floor))
    table = tables[sources.index(worst.recording)]
    folder = tire.with_name(f"{file_name(table.stem)}_diagnosis")
    return command_text("diagnose", table, "--tire", tire, *chosen, "-o", folder)


def _one_by_one(
    counted: Callable[[int, int], None], function: Callable[[Any], Any], tasks: Sequence[Any]
) -> Iterator[Any]:
    """Yield the result of each task, computed in this process."""
    for number, task in enumerate(tasks, 1):
        yield function(task)
        counted(number, len(tasks))


def _residual_findings(
    tire: Tire, path: Path, tables: Sequence[Path], recordings: Sequence[Recording], chosen: Sequence[str]
) -> list[DataFinding]:
    """Return what the residual of the tire still contains, with the command to diagnose it.

    The options `chosen` select and interpret the rows.
    """
    from ..measurements import residual_findings
    from ..measurements.evaluation import predicted_outputs

    findings = []
    for table, recording in zip(tables, recordings, strict=True):
        for finding in residual_findings([recording], [predicted_outputs(tire, recording)]):
            testable = _testable(finding.effects, tire, recording)
            folder = path.with_name(f"{file_name(table.stem)}_diagnosis")
            options = ("--tire", path, *chosen, "--candidates", ",".join(testable), "-o", folder)
            command = command_text("diagnose", table, *options) if testable else ""
            findings.append(replace(finding, command=command))
    return findings


def _testable(effects: Sequence[str], tire: Tire, recording: Recording) -> list[str]:
    """Return the effects that a diagnosis of a recording can test for a tire."""
    from ..diagnosis.diagnose import with_library
    from ..diagnosis.probing.candidates import candidates_for

    candidates = candidates_for(with_library(tire)) if "Fz" in recording.table else {}
    return [name for name in effects if name in candidates and {*candidates[name].requires} <= {*recording.table}]
