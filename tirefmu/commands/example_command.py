"""``tirefmu example``: a recording of a known tire on the virtual bench, to try the program without data."""

from __future__ import annotations

from pathlib import Path

import click

from tirefmu.boundary.escaping import command_text

from ..arguments import FILE, check_output_paths, common, write_json

#: The published tire of each program.
TIRES = {"trento": "trento_hoosier", "unicamp": "unicamp_small_tire"}


@click.command()
@click.option("-o", "--output", type=FILE, default=Path("example.csv"), show_default=True,
              help="CSV or Parquet file to write, in SI units and ISO signs.")  # fmt: skip
@click.option("--program", type=click.Choice(list(TIRES)), default="trento", show_default=True,
              help="Sweeps of the Trento report, or the 297 points of the UNICAMP paper.")  # fmt: skip
@click.option("--tire", type=FILE, help="The tire on the bench (default: that of the report or paper).")
@click.option("--sample-rate", type=click.FloatRange(min=1.0, max=1000.0), default=50.0, show_default=True,
              help="Samples per second of a sweep; a small number gives a small file.")  # fmt: skip
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of the noise.")
@common
def example(
    output: Path, program: str, tire: Path | None, sample_rate: float, seed: int, quiet: bool, json_file: Path | None
) -> int:
    """Write an example recording of the virtual bench.

    A known tire is measured with noise and drift. The program trento is that of the report: sweeps of the slip
    angle at 5 loads and 5 camber angles, then sweeps of the longitudinal slip at 4 loads, 3 camber angles and 3
    slip angles. The program unicamp is that of the paper on small tires: steady points at 9 slip angles, 3 loads
    and 11 longitudinal slips. No value is measured.
    """
    check_output_paths(output, json_file)
    from tirefmu.measurements import VirtualBench, small_tire_program, trento_program, write_table
    from tirefmu.tires import tire_from

    from ..terminal import Terminal

    terminal = Terminal(quiet)
    tested = tire_from(tire or TIRES[program])
    with terminal.working("running the virtual bench"):
        sweeps = program == "trento"
        tests = trento_program(sample_rate=sample_rate, signs="iso") if sweeps else small_tire_program()
        recording = VirtualBench(tested, seed=seed).run(tests).with_signs("iso")
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
