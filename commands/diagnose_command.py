"""``tirefmu diagnose``: identify the missing effect, add it to the tire, export both tires and write a report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..boundary.errors import TirefmuError
from ..boundary.escaping import command_text
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
    tables_read,
    write_json,
)
from .command import command

#: Default time limit, s. Convention: a few minutes.
TIME_LIMIT = 300.0


@command(
    section="From a recording to a tire", place=6,
    examples=(
        "diagnose run.csv --tire my.tir -o answer",
        "diagnose run.csv --model mf61 --nominal Fz0=1100,R0=0.2 -o answer",
    ),
)  # fmt: skip
@click.argument("tables", type=FILE, nargs=-1, required=True)
@click.option("--tire", type=FILE, help="Tire as baseline model, instead of --model, --effects and --nominal.")
@MODEL
@click.option("--effects", callback=names, help="Effects of the baseline model in addition to its core, or 'none'.")
@NOMINAL
@tables_read
@click.option("--turn-slip", "turning", is_flag=True,
              help="The bench turns the wheel plane: phit = -(d alpha/dt)/V where phit is not recorded.")  # fmt: skip
@click.option("--candidates", callback=names, help="Test these effects only.")
@click.option("--effect", "user_files", type=FILE, multiple=True, help="Effect file to test too; may be repeated.")
@click.option("--time-limit", type=click.FloatRange(min=0.0, min_open=True), default=TIME_LIMIT, show_default=True,
              help="Seconds after which the best explanation so far is the answer, as after Ctrl-C.")  # fmt: skip
@click.option("--without-form", "form", flag_value=False, default=True,
              help="The improved tire has no correction of the formula's own form.")  # fmt: skip
@click.option("--holdout", "others", type=FILE, multiple=True,
              help="Hold-out recording for the simulation of both tires; may be repeated.")  # fmt: skip
@click.option("--fmu/--no-fmu", "fmus", default=True, show_default=True, help="Export and simulate both tires.")
@click.option("--workers", type=click.IntRange(min=1), help="Of several recordings: processes  [default: processors]")
@click.option("--scheduler", metavar="ADDRESS", help="Of several recordings: Dask scheduler.")
@click.option("--resume", is_flag=True, help="Of several recordings: keep the results of the folder that are valid.")
@click.option("-o", "--output", type=FILE, required=True, help="Folder for diagnosis.json, report.html, tires, FMUs.")
@common
@grouped(spread=Spread)
def diagnose(
    tables: tuple[Path, ...], selection: TableOptions, candidates: tuple[str, ...] | None, user_files: tuple[Path, ...],
    others: tuple[Path, ...], turning: bool, fmus: bool, spread: Spread, resume: bool, output: Path, quiet: bool,
    json_file: Path | None, **baseline: Any,
) -> int:  # fmt: skip
    """Identify the effect that a tire model lacks, and add it.

    The baseline tire and the improved tire are simulated as FMUs, and the errors of both are reported.

    TABLES are one recording, or several recordings and folders of recordings. Several recordings are diagnosed
    separately: each has a folder with its name, and summary.html lists all. If a recording cannot be diagnosed, the
    summary has the reason, and the exit code is 1.
    """
    check_output_paths(json_file, folder=output)
    if others and not fmus:
        raise TirefmuError("--holdout needs the FMUs; remove --no-fmu")
    given = {name: value for name, value in baseline.items() if value is not None}
    check_input_paths(*others, *user_files, given.get("tire"))
    if len(tables) > 1 or tables[0].is_dir():
        if others:
            raise TirefmuError("--holdout is for one recording")
        if turning:
            raise TirefmuError("--turn-slip is for one recording")
        tested = [*map(user_effect, user_files), *(candidates or ())] or None
        if selection.columns or selection.units:
            raise TirefmuError("--columns and --units are for one recording; of several, name units in the headers")
        reading = {"signs": selection.signs, "where": selection.where}
        options = {**given, **reading, **vars(spread), "candidates": tested, "fmus": fmus, "resume": resume}
        return _diagnose_many(tables, output, options, quiet, json_file)
    if any(vars(spread).values()) or resume:
        raise TirefmuError("--workers, --scheduler and --resume are for several recordings")
    (table,) = tables
    check_input_paths(table)
    from ..applications.batch.diagnose_many import write_answer
    from ..diagnosis import diagnose as run
    from ..diagnosis.diagnose import STEPS
    from ..fitting.solvers.interruption import Interruption
    from ..measurements import CHANNELS, check_columns, data_findings, recordings_from
    from ..measurements.turn_slip import with_turn_slip
    from ..tires import tire_from
    from .terminal import Terminal

    terminal = Terminal(quiet)
    recording, *further = recordings_from([table, *others], **vars(selection))
    if turning:
        recording, *further = (with_turn_slip(part) for part in (recording, *further))
    terminal.selection(recording, *further)
    check_columns(recording)  # before the findings, which would print the same sentence
    for part in (recording, *further):
        part.measured()  # raises for a table without a measured output
    shown = ("incomplete rows", "warm-up", "clock")
    terminal.findings(finding for finding in data_findings([recording]) if finding.serious or finding.kind in shown)
    if "tire" in given:
        given["tire"] = tire_from(given["tire"])
    tested = [*map(user_effect, user_files), *(candidates or ())] or None
    with terminal.stages() as stages:

        def progress(sentence: str) -> None:
            (stages.begin if sentence in STEPS else stages.event)(sentence)

        result = run(recording, **given, candidates=tested, progress=progress)
        with Interruption():  # an answer that was computed is written
            summary = write_answer(
                result, recording, output, fmus=fmus, others=further, command=command_line(), begin=stages.begin
            )
    ok = bool(summary["simulated"].get("ok", True))
    write_json(json_file, {"ok": ok, **summary})
    terminal.print(f"verdict: {result.headline}", *(f"  - {sentence}" for sentence in result.sentences))
    for line in _error_lines(summary):
        terminal.print(line)
    if ignored := [name for name in result.recording["ignored_columns"] if name in CHANNELS]:
        terminal.print(f"note: ignored, no tested model has them: {', '.join(ignored)}")
    keys = ("tire", "base_tire", *(("fmu", "base_fmu") if fmus else ()))
    written_names = [*(summary[key] for key in keys), *(f"{effect.name}.toml" for effect in result.proposed)]
    terminal.print(f"files: {output / 'report.html'}, diagnosis.json, {', '.join(written_names)}")
    terminal.print(f"next: {_next_command(output, table, selection, fmus)}")
    return 0 if ok else 1


def _next_command(output: Path, table: Path, selection: TableOptions, fmus: bool) -> str:
    """Return the command that checks the FMU of the improved tire, or first exports it."""
    tire, fmu = output / "improved.tir", output / "improved.fmu"
    check, export = ("check", fmu, table, *selection.arguments), ("export", tire, "-o", fmu)
    return command_text(*(str(argument) for argument in (check if fmus else export)))


def _diagnose_many(
    tables: tuple[Path, ...], output: Path, options: dict[str, Any], quiet: bool, json_file: Path | None
) -> int:
    """Diagnose several recordings and return the exit code."""
    from ..applications.batch.diagnose_many import DiagnosisResult, diagnose_many
    from .terminal import Terminal

    terminal = Terminal(quiet)

    def progress(result: DiagnosisResult, finished: int, recordings: int) -> None:
        text = result.verdict if result.complete else "; ".join((result.status, *result.reasons))
        terminal.print(f"{result.name}: {text}")
        counted(finished, recordings)

    with terminal.counting("diagnosing", singly=True) as counted:
        results = diagnose_many(tables, output, progress=progress, **options)
    complete = all(result.complete for result in results)
    write_json(json_file, {"ok": complete, "results": [result.to_json() for result in results]})
    terminal.print(f"{sum(result.complete for result in results)} of {len(results)} recordings diagnosed")
    terminal.print(f"reports, tires and summary.html: {output}")
    return 0 if complete else 1


def _error_lines(summary: dict[str, Any]) -> list[str]:
    """Return lines with the error on the hold-out set and the accuracy of the FMUs."""
    from ..diagnosis.verdict.summary import before_and_after

    lines = [
        f"{channel} on the hold-out set: {before_and_after(channel, gap)}, noise floor {gap['floor']:.4g}"
        for channel, gap in summary["gap"]["holdout"].items() if gap["before"] is not None
    ]  # fmt: skip
    if summary["simulated"]:
        worst = max(summary["simulated"][when]["difference_from_direct_evaluation"] for when in ("before", "after"))
        lines.append(f"FMU outputs match direct evaluation (--hold) within {worst:.1e}")
    return lines


def user_effect(path: Path) -> Any:
    """Return the effect of an effect file."""
    from ..boundary.bounded_file import text_file
    from ..symbolic.added import read_effect

    return read_effect(text_file(path, TirefmuError), str(path))
