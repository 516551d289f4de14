"""``tirefmu study``: an FMU is simulated with many values of its parameters."""

from __future__ import annotations

from pathlib import Path

import click

from tirefmu.symbolic.errors import TirefmuError

from ..arguments import FILE, check_input_paths, check_output_paths, common, write_json


@click.command()
@click.argument("fmu", type=FILE)
@click.argument("study_file", metavar="STUDY", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="Folder for study.parquet and series.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler  [default: this machine]")
@click.option("--workers", type=click.IntRange(min=1), help="Processes of this machine  [default: its processors]")
@common
def study(
    fmu: Path, study_file: Path, output: Path, scheduler: str | None, workers: int | None, quiet: bool,
    json_file: Path | None,
) -> int:  # fmt: skip
    """Simulate FMU over the manoeuvres and parameters of STUDY, a TOML file (docs/many_tires.md).

    The table of results has a row for each run: parameters, and statistics of each output. Exit code 1 if a run failed.
    """
    check_output_paths(json_file, folder=output)
    check_input_paths(fmu, study_file)
    if scheduler and workers:
        raise TirefmuError("--workers is for this machine, --scheduler for a cluster")
    from tirefmu.batch.study import study as run

    from ..terminal import Terminal

    terminal = Terminal(quiet)
    with terminal.working("simulating"):
        table = run(
            fmu, study_file, output, scheduler=scheduler, workers=workers,
            progress=lambda finished, total: terminal.print(f"{finished} of {total} runs"),
        )  # fmt: skip
    failed = table[table["reason"] != ""]
    write_json(json_file, {"ok": failed.empty, "runs": len(table), "failed": len(failed)})
    terminal.print(f"{len(table)} runs, {len(failed)} failed: {output}")
    for reason in failed["reason"].unique()[:3]:
        terminal.print(f"failed: {reason}")
    return 0 if failed.empty else 1
