"""The bench: ``tirefmu plan``, a test program, and ``tirefmu example``, a recording on the virtual bench."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..boundary.errors import TirefmuError
from ..boundary.escaping import command_text
from .arguments import FILE, check_input_paths, check_output_paths, command_line, common, grouped, names, write_json
from .command import command

if TYPE_CHECKING:
    from ..applications.planning.plan import PlanResult
    from .terminal import Terminal

#: The published tire of each program.
TIRES = {"trento": "trento_hoosier", "unicamp": "unicamp_small_tire"}


@dataclass(frozen=True)
class Aim:
    """What a program is for: at most one of three, by `plan`'s options."""

    aims: tuple[str, ...] | None
    between: tuple[str, str] | None
    after: Path | None

    def __post_init__(self) -> None:
        if sum(bool(value) for value in vars(self).values()) > 1:
            raise TirefmuError("--for, --between and --after exclude each other")
        if self.between is not None and len(self.between) != 2:
            raise TirefmuError("--between needs two effects, such as slip_history,heat_friction")


@command(
    section="From a recording to a tire", place=7,
    examples=(
        "plan --example",
        "plan similar.tir --bench bench.toml --minutes 20 -o program",
        "plan similar.tir --bench bench.toml --for friction --compare today.csv -o program",
        "plan my.tir --bench bench.toml --between slip_history,heat_friction -o program",
        "plan --bench bench.toml --after answer -o program",
    ),
)  # fmt: skip
@click.argument("tire", type=FILE, required=False)
@click.option("--bench", type=FILE, help="What the bench can do: a TOML file such as that of --example.")
@click.option("-o", "--output", type=FILE, help="Folder to write.")
@click.option("--for", "aims", callback=names, metavar="AIM,...",
              help="all, forces, friction, stiffness, or coefficients such as PKY1,PDY1  [default: all]")  # fmt: skip
@click.option("--between", callback=names, metavar="EFFECT,EFFECT", help="Tell two effects apart.")
@click.option("--after", type=FILE, metavar="ANSWER",
              help="Tell apart the effects that a diagnosis left confounded. ANSWER is the folder of its result; "
                   "without TIRE its baseline model is used.")  # fmt: skip
@click.option(
    "--minutes",
    type=click.FloatRange(min=0.0, min_open=True),
    help="Bench time with warm-up and pauses, min  [default: 20; with --between and --after 2, with a warm tire]",
)
@click.option(
    "--compare", type=FILE, metavar="TABLE", help="Compare with this program: a recording, or a table of t and inputs."
)
@click.option("--example", is_flag=True, help="Print a commented bench file.")
@common
@grouped(aim=Aim)
def plan(
    tire: Path | None, bench: Path | None, output: Path | None, aim: Aim, minutes: float | None,
    compare: Path | None, example: bool, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Plan a test program for TIRE.

    The plan has sweeps with their order, rates, starting sides, pauses and repeats, and the predicted intervals of a
    fit. TIRE is what is known before the test: a .tir file, a published tire, or a folder of .tir files of similar
    tires.
    """
    from ..applications.planning.bench_file import example_text, read_bench

    if example:
        sys.stdout.write(example_text())
        return 0
    check_output_paths(json_file, folder=output)
    check_input_paths(tire, bench, compare)
    pairs = [aim.between] if aim.between else []
    if aim.after is not None:
        from ..applications.planning.separation import pairs_of

        base, pairs = pairs_of(aim.after)
        tire = base if tire is None else tire
    if tire is None or bench is None or output is None:
        raise TirefmuError("plan needs TIRE, --bench and -o (--example prints a bench file)")
    if pairs and compare:
        raise TirefmuError("--compare is for intervals, not for --between and --after")
    limits = read_bench(bench)
    from ..applications.planning.plan import plan as run
    from ..applications.planning.report import write_plan
    from ..measurements import recording_from
    from ..tires.tire_argument import tires_from
    from .terminal import Terminal

    terminal = Terminal(quiet)
    today = recording_from(compare) if compare else None
    with terminal.stages([]) as stages:

        def report(what: str, share: float) -> None:
            if not share:
                stages.begin(what)
            stages.report(f"{100.0 * share:.0f} % of the bench time" if share else "")

        if pairs:
            from ..applications.planning.separation import plan_between

            result = plan_between(tire, limits, pairs, minutes=minutes or 2.0, progress=report)
        else:
            tires = tires_from(tire)
            result = run(
                tires[0] if len(tires) == 1 else tires, limits, aims=aim.aims or ("all",), minutes=minutes or 20.0,
                today=today, progress=report,
            )  # fmt: skip
    options = ("--tire", tire, "--program", output / "program.csv", "--bench", bench, "-o", "measured.csv")
    next_command = "" if tire.is_dir() else command_text("example", *options)
    written = write_plan(result, output, command=command_line(), next_command=next_command)
    write_json(json_file, {**result.to_json(), "files": [str(path) for path in written]})
    _print(terminal, result, written)
    if next_command:
        terminal.print(f"on the virtual bench: {next_command}")
    return 0


def _print(terminal: Terminal, result: PlanResult, written: Sequence[Path]) -> None:
    """Print the size of a program, its table, and what it does not determine."""
    from ..applications.planning.report import comparison, tables

    terminal.print(f"program: {len(result.program.steps)} steps, {result.program.seconds / 60.0:.1f} min: {written[0]}")
    terminal.table("", next(iter(tables(result).values())))
    for line in (comparison(result), *(f"not determined: {n}: {why}" for n, why in result.undetermined.items())):
        if line:
            terminal.print(line)
    terminal.print(f"report: {written[-1]}")


@command(
    section="To try it", place=2,
    examples=(
        "example -o run.csv",
        "example -o small.csv --sample-rate 10 --tire my.tir",
        "example --program unicamp -o points.csv",
        "example --tire my.tir --program program/program.csv --bench bench.toml -o measured.csv",
    ),
)  # fmt: skip
@click.option("-o", "--output", type=FILE, default=Path("example.csv"), show_default=True,
              help="CSV or Parquet file to write, in SI units and ISO signs.")  # fmt: skip
@click.option("--program", default="trento", show_default=True,
              help="trento: sweeps of the Trento report; unicamp: the 297 points of the UNICAMP paper; or a table of "
                   "inputs over time, such as program.csv of the command plan.")  # fmt: skip
@click.option("--tire", type=FILE, help="The tire on the bench (default: that of the report or paper).")
@click.option("--bench", type=FILE, help="Bench file of the command plan, for the noise (default: an FSAE TTC bench).")
@click.option("--sample-rate", type=click.FloatRange(min=1.0, max=1000.0), default=50.0, show_default=True,
              help="Samples per second of a sweep; a small number gives a small file.")  # fmt: skip
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of the noise.")
@common
def example(
    output: Path, program: str, tire: Path | None, bench: Path | None, sample_rate: float, seed: int, quiet: bool,
    json_file: Path | None,
) -> int:  # fmt: skip
    """Write an example recording of the virtual bench.

    A known tire is measured with noise and drift. The program trento is that of the report: sweeps of the slip
    angle at 5 loads and 5 camber angles, then sweeps of the longitudinal slip at 4 loads, 3 camber angles and 3
    slip angles. The program unicamp is that of the paper on small tires: steady points at 9 slip angles, 3 loads
    and 11 longitudinal slips. Effects of --tire with memory act over the time of the program. No value is measured.
    """
    check_output_paths(output, json_file)
    if program not in TIRES and tire is None:
        raise TirefmuError(f"--program {program} needs --tire; the programs {' and '.join(TIRES)} have a tire")
    check_input_paths(tire, bench, None if program in TIRES else Path(program))
    from ..applications.planning.bench_file import read_bench
    from ..applications.planning.program import program_from
    from ..measurements import Noise, VirtualBench, small_tire_program, trento_program, write_table
    from ..tires import tire_from
    from .terminal import Terminal

    terminal = Terminal(quiet)
    tested = tire_from(tire if tire is not None else TIRES[program])
    with terminal.working("running the virtual bench"):
        if program == "trento":
            tests = trento_program(sample_rate=sample_rate, signs="iso")
        else:
            tests = small_tire_program() if program == "unicamp" else program_from(program)
        noise = read_bench(bench).noise if bench else Noise()
        recording = VirtualBench(tested, noise, seed=seed).run(tests).with_signs("iso")
        write_table(recording.table, output)
    table = recording.table
    load = float(f"{table['Fz'].abs().median():.1g}")  # in the middle of the tested loads, as the documents recommend
    nominal = {"Fz0": load, "R0": tested.values["UNLOADED_RADIUS"]}
    summary = {"rows": len(table), "channels": list(table.columns), "model": tested.model, "nominal": nominal}
    write_json(json_file, {"ok": True, **summary})
    values = ",".join(f"{name}={value:g}" for name, value in nominal.items())
    fitted = ("--model", tested.model, "--nominal", values, "-o", "my.tir", "--report", "fit.html")
    terminal.print(f"recording: {output} ({len(table)} rows, virtual)")
    terminal.print(f"next: {command_text('fit', output, *fitted)}")
    return 0
