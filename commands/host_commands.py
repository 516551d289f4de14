"""``tirefmu convert`` and ``tirefmu lint``: property files for other programs."""

from __future__ import annotations

from pathlib import Path

import click

from ..applications.exports.dialects import HOSTS
from .arguments import FILE, check_input_paths, check_output_paths, common, write_json
from .command import command

PROGRAMS = ", ".join(HOSTS)


@command(
    section="Other programs", place=2,
    examples=(
        "convert my.tir --for adams -o adams.tir",
    ),
)  # fmt: skip
@click.argument("tire", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="Property file (.tir) to write.")
@click.option("--for", "host", required=True, help=f"Program that reads the file: {PROGRAMS}.")
@click.option("--model", help="Model of the file; coefficients of another model than the tire's are fitted to its "
                              "forces  [default: that of the tire if the program has it]")  # fmt: skip
@common
def convert(tire: Path, output: Path, host: str, model: str | None, quiet: bool, json_file: Path | None) -> int:
    """Write TIRE as a property file that another program accepts.

    Exit code 1 if the program would refuse the file. Effects that the program does not evaluate are reported.
    """
    check_output_paths(output, json_file)
    check_input_paths(tire)
    from ..applications.exports.convert import convert as run
    from .terminal import Terminal

    terminal = Terminal(quiet)
    with terminal.working(f"converting for {host}"):
        result = run(tire, output, host, model)
    ok = not any(finding.severity == "error" for finding in result.findings)
    summary = {"ok": ok, "model": result.model, "refitted": result.refitted, "errors": dict(result.errors)}
    write_json(json_file, {**summary, "findings": [vars(finding) for finding in result.findings]})
    terminal.print(f"{result.model} for {host}: {output}")
    if result.errors:
        errors = ", ".join(f"{name} {error:.2%}" for name, error in result.errors.items())
        fitted = "coefficients fitted to the tire's forces" if result.refitted else "coefficients of the tire"
        terminal.print(f"{fitted}; RMS error over its range, in steady state: {errors}")
    for finding in result.findings:
        terminal.print(f"{finding.severity}: {finding.text}")
    return 0 if ok else 1


@command(
    section="Other programs", place=3,
    examples=(
        "lint my.tir",
        "lint my.tir --for carsim",
    ),
)  # fmt: skip
@click.argument("file", type=FILE)
@click.option("--for", "host", help=f"Program that reads the file: {PROGRAMS}  [default: the file itself is checked]")
@common
def lint(file: Path, host: str | None, quiet: bool, json_file: Path | None) -> int:
    """Check whether a .tir file is sound, or fits a program.

    Without --for, values that no tire has are errors, and the programs that accept the file are listed. With --for,
    effects that the program does not evaluate are reported, too. Exit code 1 if there is an error.
    """
    check_output_paths(json_file)
    check_input_paths(file)
    from ..applications.exports.lint import lint as run
    from .terminal import Terminal

    terminal = Terminal(quiet)
    findings = run(file, host)
    ok = not any(finding.severity == "error" for finding in findings)
    write_json(json_file, {"ok": ok, "host": host, "findings": [vars(finding) for finding in findings]})
    for finding in findings:
        where = f"{file}:{finding.line}" if finding.line else str(file)
        terminal.print(f"{where}: {finding.severity}: {finding.text}")
    good, bad = ("the file is sound", "the file is not sound") if host is None else (
        "no errors", "the program would refuse or misread the file"
    )  # fmt: skip
    terminal.print(good if ok else bad)
    return 0 if ok else 1
