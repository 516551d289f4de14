"""``missing-effects``: recordings with missing effects, answers of methods, and their score."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tirefmu.boundary.errors import TirefmuError, UnknownName
from tirefmu.commands.arguments import FILE, check_output_paths, common, names, write_json
from tirefmu.commands.cli import run

if TYPE_CHECKING:
    from tirefmu.commands.terminal import Terminal

    from .generator.cases import Made


@click.command("missing-effects")
@click.option("-o", "--output", type=FILE, help="Folder of the recordings; with recordings and without --seed, these.")
@click.option("--seed", type=click.IntRange(min=0), help="Of the recordings  [default: 1; 1 to 5 are published]")
@click.option("--only", callback=names, metavar="CASE,...", help="Of an entry or a score: these recordings.")
@click.option("--entry", help="Run an entry of --list; its answers are in FOLDER/answers/NAME.")
@click.option("--score", type=FILE, metavar="ANSWERS", help="Score a folder of answers to the recordings of --seed.")
@click.option("--list", "listed", is_flag=True, help="List the entries.")
@common
def benchmark(
    output: Path | None, seed: int | None, only: tuple[str, ...] | None, entry: str | None, score: Path | None,
    listed: bool, quiet: bool, json_file: Path | None,
) -> int:  # fmt: skip
    """Benchmark methods that name the missing effect.

    A seed gives 24 recordings of tires and 6 of other systems, some of which lack nothing. A method answers with names,
    probabilities and the forces on other maneuvers (answer.schema.json). To be measured blind, take recordings
    whose seed another person chose; benchmark.json has a digest of the seed.
    """
    from tirefmu.commands.terminal import Terminal

    terminal = Terminal(quiet)
    check_output_paths(json_file, folder=output)
    if sum((listed, score is not None, output is not None)) != 1:
        raise TirefmuError("missing-effects needs one of -o FOLDER, --score ANSWERS and --list")
    if entry is not None and output is None:
        raise TirefmuError("--entry needs -o FOLDER")
    if score is not None and (seed is None or not score.is_dir()):
        raise TirefmuError(f"{score}: no such folder" if seed is not None else "--score needs --seed")
    if listed:
        summary: dict[str, Any] = _listed(terminal)
    elif score is not None and seed is not None:
        summary = {"seed": seed, "scores": _scored(terminal, score, seed, only)}
    elif output is not None:
        from .entries import ENTRIES

        if entry is not None and entry not in ENTRIES:
            raise UnknownName("entry", entry, ENTRIES)
        summary = _written(terminal, output, seed)
        if entry is not None:
            summary |= _answered(terminal, output, entry, only, summary["seed"])
    write_json(json_file, {"ok": True, **summary})
    return 0


def _listed(terminal: Terminal) -> dict[str, Any]:
    from .entries import ENTRIES, NEED_EXTRA

    rows = [[name, "regressions" if name in NEED_EXTRA else "", text] for name, text in ENTRIES.items()]
    terminal.table("", (["entry", "extra", "method"], rows))
    return {"entries": dict(ENTRIES)}


def _written(terminal: Terminal, folder: Path, seed: int | None) -> dict[str, Any]:
    """Write the recordings of a seed, or find those of the folder; the seed is None if it is not published."""
    from .answers import read_about
    from .generator.files import PUBLISHED_SEEDS, commitment, write_recordings

    if seed is None and (folder / "benchmark.json").exists():
        about = read_about(folder)
        seed = next((published for published in PUBLISHED_SEEDS if commitment(published) == about["commitment"]), None)
        return {"seed": seed, "digest": about["digest"]}
    seed = 1 if seed is None else seed
    with terminal.working(f"making the recordings of seed {seed}"):
        digest = write_recordings(seed, folder)
    terminal.print(f"recordings of seed {seed}: {folder}", f"digest: {digest}")
    return {"seed": seed, "digest": digest}


def _answered(
    terminal: Terminal, folder: Path, entry: str, only: tuple[str, ...] | None, seed: int | None
) -> dict[str, Any]:
    """Run an entry, write its answers, and score them if the seed is known."""
    from .answers import read_cases, write_answer
    from .entries import answer_of

    cases = read_cases(folder)
    answers, chosen = folder / "answers" / entry, _chosen(only, list(cases))
    with terminal.counting("recordings") as report:
        for done, name in enumerate(chosen, 1):
            write_answer(answers, entry, name, answer_of(entry, cases[name]))
            report(done, len(chosen))
    terminal.print(f"answers: {answers}")
    return {"scores": _scored(terminal, answers, seed, only)} if seed is not None else {}


def _scored(terminal: Terminal, answers: Path, seed: int, only: tuple[str, ...] | None) -> dict[str, Any]:
    """Print and return the score of answers to the recordings of a seed."""
    from .generator.cases import made
    from .score import HEAD, read_outcomes, row, scores

    with terminal.working(f"making the truth of seed {seed}"):
        cases: dict[str, Made] = {case.name: case for case in made(seed)}
    table = scores(read_outcomes([cases[name] for name in _chosen(only, list(cases))], answers))
    terminal.table("", (["recordings", *HEAD], [[tier, *row(summary)] for tier, summary in table.items()]))
    return table


def _chosen(only: tuple[str, ...] | None, cases: list[str]) -> list[str]:
    for name in only or ():
        if name not in cases:
            raise UnknownName("recording", name, cases)
    return list(only or cases)


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit code, as those of ``tirefmu``."""
    return run(benchmark, "missing-effects", arguments)
