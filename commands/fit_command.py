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
from .arguments import (
    FILE,
    MODEL,
    NOMINAL,
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


@command(
    section="From a recording to a tire", place=2,
    examples=(
        "fit cornering.mat drivebrake.mat --model mf61 -o my.tir --report fit.html",
        "fit run.csv --model mf96 --nominal Fz0=220,R0=0.23 --effects load_friction,camber_thrust -o my.tir",
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
@click.option("--effects", callback=names, help="Exactly these effects in addition to the core, or 'none'.")
@click.option("--without", callback=names, default="none", help="All effects except these.")
@click.option("--family", type=FILE, metavar="FOLDER|NAME",
              help="Prior of the coefficients: .tir files of similar tires, or a published tire.")  # fmt: skip
@click.option("--recipe", help="progressive, joint, trento, scaling (of --start), one of the model's own, or a TOML "
                               "file  [default: the model's]")  # fmt: skip
@click.option("--method", default="ipopt", show_default=True,
              help="ipopt, or ioa: an evolutionary algorithm without derivatives, for comparison.")  # fmt: skip
@click.option(
    "--iterations",
    type=click.IntRange(min=1),
    help="Iteration limit of a stage  [default: ipopt 300, ioa 10000]",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Seed of the random numbers of ioa and --bootstrap.",
)
@click.option("--constraint", "constraints", callback=names, default="none",
              help="Physical constraints in addition to the default ones: extrapolation (signs and E up to "
                   "1.5 times the range), stiffness_saturating (also K_xkappa), or all.")  # fmt: skip
@click.option("--without-constraint", "without_constraints", callback=names, default="none",
              help="Physical constraints to remove: signs, curvature, friction_falling, stiffness_saturating, "
                   "extrapolation, a single one (curvature:E_y), or all.")  # fmt: skip
@click.option("--loss", default="squares", show_default=True,
              help="Loss function: squares; huber or cauchy for data with outliers.")  # fmt: skip
@NOMINAL
@click.option("--size", help="Size of the tire, 245/45R18 or 16x7.5-10: radius, width and rim  [default: as recorded]")
@tables_read
@click.option("--all-rows", "screening", is_flag=True, callback=lambda context, option, given: not given,
              help="Do not exclude rows (warm-up, transitions, outliers).")  # fmt: skip
@click.option("--rows", default="condition", show_default=True,
              help="Weights of rows: condition (equal per operating condition), equal, independent (by effective "
                   "sample size), or load (errors relative to the load).")  # fmt: skip
@click.option("--weight", "weights", type=_weight, metavar="FACTOR:EXPRESSION", multiple=True,
              callback=lambda context, option, given: dict(given),
              help="Multiply the weights of rows by a factor: '2: Fz in 200..240 N'. Repeatable.")  # fmt: skip
@click.option("--fix", "fixed", type=numbers_by_name, metavar="NAME=VALUE,...",
              callback=lambda context, option, given: given or {},
              help="Coefficients that are not fitted, with their values in ISO-W: PCY1=1.3,PHY1=0.")  # fmt: skip
@click.option("--stiffness-weight", type=click.FloatRange(min=0.0), default=10.0, show_default=True,
              help="Weight of the slip stiffness read from the data at each load, in rows; 0: not fitted.")  # fmt: skip
@click.option("--exact-sensors", "sensor_errors", is_flag=True, callback=lambda context, option, given: not given,
              help="Intervals without offsets, drift and cross-talk of the sensors.")  # fmt: skip
@click.option("--temperature", metavar="COLUMN",
              help="Also fit the effect temperature to this recorded temperature, deg C  [default: T, if --effects "
                   "has temperature]")  # fmt: skip
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
