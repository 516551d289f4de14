"""``tirefmu fit-many`` and ``tirefmu study``: many fits, or many simulations, on this machine or on a Dask cluster."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..boundary.errors import TirefmuError
from .arguments import (  # fmt: skip
    CONVENTIONS,
    FILE,
    MODEL,
    WHERE,
    Spread,
    check_input_paths,
    check_output_paths,
    common,
    grouped,
    names,
    numbers_by_name,
    write_json,
)
from .command import command

if TYPE_CHECKING:
    from ..applications.batch.records import JobResult


@command(
    "fit-many", section="All steps, many tires", place=4,
    examples=(
        "fit-many jobs.toml -o tires --resume",
        "fit-many recordings --model mf61 --nominal Fz0=1000,R0=0.25 -o tires",
    ),
)  # fmt: skip
@click.argument("jobs", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="Folder for tires, reports and summary.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler, such as tcp://10.0.0.5:8786  [default: this "
                                                     "machine]")  # fmt: skip
@click.option("--workers", type=click.IntRange(min=1), help="Processes of this machine  [default: its processors]")
@click.option("--resume", is_flag=True, help="Keep the results of the folder that are still valid.")
@MODEL
@click.option("--start", help="Of a folder: tire with initial values, or 'features'.")
@click.option("--effects", callback=names, help="Of a folder: exactly these effects, or 'none'.")
@click.option("--without", callback=names, help="Of a folder: all effects except these.")
@click.option("--recipe", help="Of a folder: recipe or TOML file.")
@click.option("--nominal", type=numbers_by_name, metavar="NAME=VALUE,...",
              help="Of a folder: Fz0 (N), R0 (m), p0 (Pa), V0 (m/s).")  # fmt: skip
@click.option("--signs", type=CONVENTIONS, help="Of a folder: convention of the tables.")
@WHERE
@common
@grouped(spread=Spread)
def fit_many(
    jobs: Path, output: Path, spread: Spread, resume: bool, quiet: bool, json_file: Path | None,
    **options: Any,
) -> int:  # fmt: skip
    """Fit many tires on all processors or a cluster.

    JOBS is a TOML file, or a folder in which each recording is a tire. A file has [[jobs]] with name, tables and
    options, and [defaults] with options of all jobs. Options are those of tirefmu fit: model, start, effects, without,
    recipe, nominal, signs, where, rows, loss, method, iterations, seed, screening, constraints, without_constraints.

    Each tire and its report are written when the fit ends. A tire that cannot be fitted is a row of the summary with
    its reason. Exit code 1 if a tire is not usable. Ctrl-C keeps what is written; --resume continues.
    """
    check_output_paths(json_file, folder=output)
    if not jobs.exists():
        raise TirefmuError(f"{jobs}: no such file or folder")
    from ..applications.batch.fit_many import fit_many as run
    from .terminal import Terminal

    terminal = Terminal(quiet)

    def progress(result: JobResult, finished: int, jobs: int) -> None:
        reason = f": {result.reasons[0]}" if result.reasons else ""
        terminal.print(f"{result.name}: {result.status}{reason}")
        counted(finished, jobs)

    given: dict[str, Any] = {
        key: list(value) if isinstance(value, tuple) else value for key, value in options.items() if value is not None
    }
    with terminal.counting("fitting", singly=True) as counted:
        batch = run(jobs, output, **vars(spread), resume=resume, progress=progress, **given)
    unusable = [result.name for result in batch.results if not result.usable]
    write_json(json_file, {"ok": not unusable, "results": [result.to_json() for result in batch.results]})
    terminal.print(f"{len(batch.results) - len(unusable)} of {len(batch.results)} tires are usable")
    terminal.print(f"tires, reports and summary.html: {output}")
    return 1 if unusable else 0


@command(
    section="All steps, many tires", place=5,
    examples=(
        "study my.fmu study.toml -o results",
    ),
)  # fmt: skip
@click.argument("fmu", type=FILE)
@click.argument("study_file", metavar="STUDY", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="Folder for study.parquet and series.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler  [default: this machine]")
@click.option("--workers", type=click.IntRange(min=1), help="Processes of this machine  [default: its processors]")
@common
@grouped(spread=Spread)
def study(fmu: Path, study_file: Path, output: Path, spread: Spread, quiet: bool, json_file: Path | None) -> int:
    """Simulate FMU over manoeuvres and parameters.

    STUDY is a TOML file (docs/many_tires.md). The table of results has a row for each run: parameters, and statistics
    of each output. Exit code 1 if a run failed.
    """
    check_output_paths(json_file, folder=output)
    check_input_paths(fmu, study_file)
    from ..applications.batch.study import study as run
    from .terminal import Terminal

    terminal = Terminal(quiet)
    with terminal.counting("simulating") as counted:
        table = run(fmu, study_file, output, **vars(spread), progress=counted)
    failed = table[table["reason"] != ""]
    write_json(json_file, {"ok": failed.empty, "runs": len(table), "failed": len(failed)})
    terminal.print(f"{len(table)} runs, {len(failed)} failed: {output}")
    for reason in failed["reason"].unique()[:3]:
        terminal.print(f"failed: {reason}")
    return 0 if failed.empty else 1
