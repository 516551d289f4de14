"""The run of a project: each step whose results are not up to date, then one page over all results."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

from tirefmu.boundary.errors import TirefmuError
from tirefmu.tires.drawing.page import page_text, write_page

from ..terminal import Terminal
from .limited import TimeLimitReached
from .project_file import Project
from .records import NAME, Records, files_of
from .steps import Step, needed, reads_results, steps_of
from .summaries import Headline, headline_of, summary_of

#: Name of the page over all results, in their folder.
INDEX = "index.html"
#: Runs a step and returns its exit code.
Command = Callable[[Step], int]


@dataclass(frozen=True)
class Outcome:
    """A step of a run.

    - `status`: 0: success; 1: completed, but a check failed.
    - `repeated`: false if the results were up to date.
    - `headline`: what the step found, in one line.
    - `summary`: the details, a line each.
    """

    step: Step
    status: int
    repeated: bool
    headline: Headline
    summary: tuple[str, ...]


def run_project(
    project: Project, command: Command, terminal: Terminal, *, force: bool = False, outside: bool = False,
    only: Collection[str] = (),
) -> list[Outcome]:  # fmt: skip
    """Run the steps of a project and write the page ``index.html`` after each.

    `command`: runs the command of a step and returns its exit code; raises `TimeLimitReached` if it had to be ended.
    `terminal`: shows the outcome of each step, a line or a few. `force`: repeat also the steps whose results are up to
    date. `outside`: results may be outside the folder of the project. `only`: run only the steps of these commands and
    those whose results they read; of the others, the outcomes that are up to date are included. Raises `TirefmuError`
    if a table does not exist, a result would be outside the folder of the project, a folder or file cannot be written,
    or a step has invalid input; steps before it are recorded. Raises `KeyboardInterrupt` if a step was interrupted; it
    is repeated by the next run.
    """
    for table in (*project.tables, *project.diagnosed):
        if not table.is_file():
            raise TirefmuError(f"{project.path}: no such table: {table}")
    steps = steps_of(project)
    if not outside:
        _check_inside(project, steps)
    try:
        project.folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TirefmuError(f"{project.folder}: cannot be created ({error.strerror or error})") from error
    records = Records.of(project.folder)
    outcomes: list[Outcome] = []
    chosen = needed(steps, only) if only else steps
    skipped: dict[str, Step] = {}
    for number, step in enumerate(steps, 1):
        stale = reads_results(step, skipped.values()) or records.status(step) is None
        if step not in chosen and stale:
            skipped[step.name] = step
            continue
        terminal.begin(f"{number}/{len(steps)} {step.name}")
        outcome = _run(step, records, command, terminal, force and step in chosen)
        outcomes.append(outcome)
        state = outcome.headline.text + ("" if outcome.repeated else " (up to date)")
        terminal.heading(f"{number}/{len(steps)} {step.name}:", state)
        terminal.print(*(f"  {line}" for line in outcome.summary))
        _write_index(
            project, outcomes, [each.name for i, each in enumerate(steps) if i >= number or each.name in skipped]
        )
    return outcomes


def _check_inside(project: Project, steps: Sequence[Step]) -> None:
    """Raise if a path of the project file, or a link, leads results out of the folder of the project."""
    outputs = [path for step in steps for output in step.outputs for path in (output, *output.rglob("*"))]
    root = Path(os.path.realpath(project.path.parent))
    for path in (project.folder, project.folder / NAME, project.folder / INDEX, *outputs):
        if not Path(os.path.realpath(path)).is_relative_to(root):
            raise TirefmuError(f"{project.path}: {path} is outside the folder of the project: --outside permits it")


def _run(step: Step, records: Records, command: Command, terminal: Terminal, force: bool) -> Outcome:
    status = None if force else records.status(step)
    repeated = status is None
    if status is None:
        records.forget(step)
        try:
            status = command(step)
        except TimeLimitReached as reached:
            return _unfinished(step, str(reached))
        except TirefmuError as error:
            raise TirefmuError(f"step {step.name}: {error}") from error
        if _result(step).get("interrupted"):
            raise KeyboardInterrupt  # a fit ends with the best values so far, which is no complete step
        records.add(step, status)
    result = _result(step)
    headline = headline_of(step.command, result, status)
    return Outcome(step, status, repeated, headline, tuple(summary_of(step.command, result)))


def _unfinished(step: Step, last: str) -> Outcome:
    """Return the outcome of a step that was ended; it is not recorded, and the next run repeats it."""
    headline = Headline(f"no answer within the time limit of {step.time_limit:g} s", "limited")
    summary = (f"last progress: {last or 'none'}", f"longer: time_limit in [{step.command}] of the project file")
    return Outcome(replace(step, outputs=(), page=None), 1, True, headline, summary)


def _result(step: Step) -> dict[str, Any]:
    try:
        content = json.loads(step.result.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise TirefmuError(f"{step.result}: cannot be read ({error})") from error
    return content if isinstance(content, dict) else {}


def _write_index(project: Project, outcomes: Sequence[Outcome], missing: Sequence[str]) -> None:
    path = project.folder / INDEX
    folder = project.folder

    def links(outcome: Outcome) -> list[tuple[str, str]]:
        first = [outcome.step.page] if outcome.step.page else []
        written = [file for output in outcome.step.outputs for file in files_of(output)]
        files = [each.relative_to(folder).as_posix() for each in dict.fromkeys([*first, *written])]
        return [("open the page" if i < len(first) else file, "./" + quote(file)) for i, file in enumerate(files)]

    text = page_text("tirefmu.project", {"links": links}, title=project.path.resolve().parent.name, outcomes=outcomes,
                     missing=missing)  # fmt: skip
    try:
        write_page(text, path)
    except OSError as error:
        raise TirefmuError(f"{path}: cannot be written ({error.strerror or error})") from error
