"""The bench: ``tirefmu plan``, a test program, and ``tirefmu example``, a recording on the virtual bench."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from tirefmu.boundary.errors import TirefmuError
from tirefmu.boundary.escaping import command_text

from ..arguments import FILE, check_input_paths, check_output_paths, command_line, common, names, write_json

#: The published tire of each program.
TIRES = {"trento": "trento_hoosier", "unicamp": "unicamp_small_tire"}


@click.command()
@click.argument("tire", type=FILE, required=False)
@click.option("--bench", type=FILE, help="What the bench can do: a TOML file such as that of --example.")
@click.option("-o", "--output", type=FILE, help="Folder to write.")
@click.option("--for", "aims", callback=names, metavar="AIM,...",
              help="all, forces, friction, stiffness, or coefficients such as PKY1,PDY1  [default: all]")  # fmt: skip
@click.option("--minutes", type=click.FloatRange(min=0.0, min_open=True), default=20.0, show_default=True,
              help="Bench time with warm-up and pauses.")  # fmt: skip
@click.option("--compare", type=FILE, metavar="TABLE", help="Today's program, inputs over time, to compare with.")
@click.option("--example", is_flag=True, help="Print a commented bench file.")
@common
def plan(
    tire: Path | None, bench: Path | None, output: Path | None, aims: tuple[str, ...] | None, minutes: float,
    compare: Path | None, example: bool, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Plan a test program for TIRE.

    Sweeps with their order, rates, starting sides, pauses and repeats, and the intervals that they will give. TIRE is
    what is known before the test: a .tir file, a published tire, or a folder of .tir files of similar tires.
    """
    from tirefmu.planning.bench_file import example_text, read_bench

    if example:
        sys.stdout.write(example_text())
        return 0
    if tire is None or bench is None or output is None:
        raise TirefmuError("plan needs TIRE, --bench and -o (--example prints a bench file)")
    check_output_paths(json_file, folder=output)
    check_input_paths(*(path for path in (tire, bench, compare) if path is not None))
    limits = read_bench(bench)
    from tirefmu.measurements import recording_from
    from tirefmu.planning.plan import plan as run
    from tirefmu.planning.report import interval_rows, write_plan
    from tirefmu.tires.tire_argument import tires_from

    from ..terminal import Terminal

    terminal = Terminal(quiet)
    today = recording_from(compare) if compare else None
    with terminal.stages([]) as stages:
        latest = ""

        def report(what: str, share: float) -> None:
            nonlocal latest
            if what != latest:
                stages.begin(what)
                latest = what
            stages.report(f"{100.0 * share:.0f} % of the bench time" if share else "")

        result = run(tires_from(tire), limits, aims=aims or ("all",), minutes=minutes, today=today, progress=report)
    options = ("--tire", tire, "--program", output / "program.csv", "--bench", bench, "-o", "measured.csv")
    next_command = command_text("example", *options) if tire.suffix or not tire.is_dir() else ""
    written = write_plan(result, output, command=command_line(), next_command=next_command)
    write_json(json_file, {**result.to_json(), "files": [str(path) for path in written]})
    terminal.print(f"program: {len(result.program.steps)} steps, {result.program.seconds / 60.0:.1f} min: {written[0]}")
    terminal.table("", interval_rows(result))
    if result.today is not None:
        equal, whole = result.equal_after(), result.today.seconds / 60.0
        text = f"equal intervals after {equal / 60.0:.1f} min" if equal else "at least one interval is wider"
        terminal.print(f"{text}, compared with {whole:.1f} min of {result.today.name}")
    for name, reason in result.undetermined.items():
        terminal.print(f"not determined: {name}: {reason}")
    terminal.print(f"report: {written[-1]}")
    if next_command:
        terminal.print(f"on the virtual bench: {next_command}")
    return 0


@click.command()
@click.option("-o", "--output", type=FILE, default=Path("example.csv"), show_default=True,
              help="CSV or Parquet file to write, in SI units and ISO signs.")  # fmt: skip
@click.option("--program", default="trento", show_default=True,
              help="trento: sweeps of the Trento report; unicamp: the 297 points of the UNICAMP paper; or a table of "
                   "inputs over time, such as the program.csv of tirefmu plan.")  # fmt: skip
@click.option("--tire", type=FILE, help="The tire on the bench (default: that of the report or paper).")
@click.option("--bench", type=FILE, help="Bench file of tirefmu plan, for the noise (default: an FSAE TTC bench).")
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
    check_input_paths(*(path for path in (tire, bench, None if program in TIRES else Path(program)) if path))
    from tirefmu.measurements import Noise, VirtualBench, small_tire_program, trento_program, write_table
    from tirefmu.planning.bench_file import read_bench
    from tirefmu.planning.program import program_from
    from tirefmu.tires import tire_from

    from ..terminal import Terminal

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
    nominal = {"Fz0": tested.values["FNOMIN"], "R0": tested.values["UNLOADED_RADIUS"]}
    summary = {"rows": len(table), "channels": list(table.columns), "model": tested.model, "nominal": nominal}
    write_json(json_file, {"ok": True, **summary})
    values = ",".join(f"{name}={value:g}" for name, value in nominal.items())
    fitted = ("--model", tested.model, "--nominal", values, "-o", "my.tir", "--report", "fit.html")
    terminal.print(f"recording: {output} ({len(table)} rows, virtual)")
    terminal.print(f"next: {command_text('fit', output, *fitted)}")
    return 0
