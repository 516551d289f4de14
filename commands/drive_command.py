"""``tirefmu drive``: from the log of a drive to the tires of the car."""

from __future__ import annotations

from pathlib import Path

import click

from ..boundary.errors import TirefmuError, writing
from ..boundary.json_schema import write_toml
from .arguments import FILE, check_input_paths, check_output_paths, command_line, common, texts_by_channel, write_json
from .command import command


@command(
    section="From a recording to a tire", place=8,
    examples=(
        "drive --example car.toml",
        "drive log.csv --vehicle car.toml --tire front.tir --rear rear.tir -o answer",
    ),
)  # fmt: skip
@click.argument("log", type=FILE, required=False)
@click.option("--vehicle", type=FILE, help="Car file (TOML).")
@click.option("--tire", type=FILE, help="Tire of the front axle, and of the rear one without --rear.")
@click.option("--rear", type=FILE, help="Tire of the rear axle.")
@click.option("-o", "--output", type=FILE, help="Folder to write: drive.json, wheels.csv, tires, report.html.")
@click.option("--columns", type=texts_by_channel, metavar="NAME=HEADER,...",
              help="Columns with other names in the log: HEADER, -HEADER (other sign), HEADER [unit].")  # fmt: skip
@click.option("--fmus", is_flag=True, help="Simulate the vehicle on four tire FMUs, and write those of the new tires.")
@click.option("--example", type=FILE, is_flag=False, flag_value=Path("car.toml"),
              help="Write a commented car file (car.toml) and its JSON Schema, and stop.")  # fmt: skip
@common
def drive(
    log: Path | None, vehicle: Path | None, tire: Path | None, rear: Path | None, output: Path | None,
    columns: dict[str, str] | None, fmus: bool, example: Path | None, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Compare the LOG of a drive with the tires of the car.

    The results are forces of the axles, scaling factors with intervals, new tires, and errors of the simulated vehicle
    before and after. Exit code 1: the drive does not justify new tires, and none is written.
    """
    if example:
        return _template(example, quiet)
    if log is None or vehicle is None or tire is None or output is None:
        raise click.UsageError("LOG, --vehicle, --tire and -o are required; --example FILE writes a car file")
    check_output_paths(json_file, folder=output)
    check_input_paths(log, vehicle, tire, rear)
    from ..applications.driving.drive import drive as run
    from ..applications.driving.figures import write_drive
    from ..applications.driving.simulation import changes
    from .terminal import Terminal

    terminal = Terminal(quiet)
    with terminal.working(f"estimating the motion of {log.name}"):
        answer = run(log, vehicle=vehicle, tire=tire, rear=rear, columns=columns, fmus=fmus)
    with terminal.working("writing the answer"):
        written = answer.save(output)
        write_json(output / "drive.json", answer.to_json())
        write_drive(answer, output / "report.html", command=command_line())
    write_json(json_file, answer.to_json())
    terminal.print(*(f"verdict: {line}" if i == 0 else f"  {line}" for i, line in enumerate(answer.verdict.lines)))
    terminal.print(f"rms errors of the simulated vehicle: {changes(answer.before.rms, answer.after.rms)}")
    terminal.not_read(answer.log.ignored)
    if not answer.written:
        terminal.print("no tire is written")
    terminal.print(*(f"{path}" for path in [*written, output / "drive.json", output / "report.html"]))
    return 0 if answer.written else 1


def _template(example: Path, quiet: bool) -> int:
    """Write the example of a car file."""
    check_output_paths(example)
    if example.exists():
        raise TirefmuError(f"{example} exists: its numbers would be lost; give another file")
    from ..applications.driving.inputs.car_entries import car_schema, example_text
    from .terminal import Terminal

    with writing(example):
        write_toml(example, example_text(), car_schema())
    Terminal(quiet).print(f"written: {example}")
    return 0
