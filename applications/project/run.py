"""The run of a project: each step whose results are not up to date, then one page over all results.

`run_limited` runs a command in a process of its own, which ends at a time limit.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Event, Timer
from time import monotonic
from typing import Any, Protocol
from urllib.parse import quote

from ...boundary.errors import TirefmuError, writing
from ...drawing.page import page_text, write_page
from ...numerics.forecast import left_text
from .project_file import Project
from .records import NAME, Records, files_of
from .steps import Step, needed, reads_results, steps_of
from .summaries import Summary, summary_of

#: Name of the page over all results, in their folder.
INDEX = "index.html"
#: The first picture of a page: that of its first figure, which the page shows in print.
PICTURE = re.compile(r'src="(data:image/png;base64,[A-Za-z0-9+/=]+)"')
#: Runs a step and returns its exit code.
Command = Callable[[Step], int]


class Display(Protocol):
    """What shows the progress of a run: the terminal of the command line."""

    def begin(self, line: str) -> None:
        """Show what is running."""

    def heading(self, title: str, text: str) -> None:
        """Show a title and a text behind it."""

    def print(self, *lines: str) -> None:
        """Show lines."""


@dataclass(frozen=True)
class StepOutcome:
    """A step of a run.

    - `status`: 0: success; 1: completed, but a check failed.
    - `repeated`: false if the results were up to date.
    - `summary`: what the step found.
    - `picture`: the first picture of its page, as the address of an image; empty if there is none.
    """

    step: Step
    status: int
    repeated: bool
    summary: Summary
    picture: str = ""


def run_project(
    project: Project, command: Command, display: Display, *, force: bool = False, outside: bool = False,
    only: Collection[str] = (),
) -> list[StepOutcome]:  # fmt: skip
    """Run the steps of a project and write the page ``index.html`` before the first and after each.

    `command`: runs the command of a step and returns its exit code; raises `TimeLimitReached` if it had to be ended.
    `display`: shows the outcome of each step, a line or a few. `force`: repeat also the steps whose results are up to
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
    outcomes: list[StepOutcome] = []
    chosen = needed(steps, only) if only else steps
    skipped: dict[str, Step] = {}
    ahead = _seconds_ahead(chosen, records, force)
    _write_index(project, outcomes, [step.name for step in steps])
    for number, step in enumerate(steps, 1):
        if step not in chosen and (reads_results(step, skipped.values()) or records.status(step) is None):
            skipped[step.name] = step
            continue
        left = left_text(_sum(ahead[later.name] for later in steps[number - 1 :] if later.name in ahead))
        display.begin(f"{number}/{len(steps)} {step.name}" + (f" (all steps: {left})" if left else ""))
        outcome = _run(step, records, command, display, force and step in chosen)
        outcomes.append(outcome)
        state = outcome.summary.text + ("" if outcome.repeated else " (up to date)")
        display.heading(f"{number}/{len(steps)} {step.name}:", state)
        display.print(*(f"  {line}" for line in outcome.summary.lines))
        _write_index(
            project, outcomes, [step.name for i, step in enumerate(steps) if i >= number or step.name in skipped]
        )
    return outcomes


def _check_inside(project: Project, steps: Sequence[Step]) -> None:
    """Raise if a path of the project file, or a link, leads results out of the folder of the project."""
    outputs = [path for step in steps for output in step.outputs for path in (output, *output.rglob("*"))]
    root = Path(os.path.realpath(project.path.parent))
    for path in (project.folder, project.folder / NAME, project.folder / INDEX, *outputs):
        if not Path(os.path.realpath(path)).is_relative_to(root):
            raise TirefmuError(f"{project.path}: {path} is outside the folder of the project: --outside permits it")


def _run(step: Step, records: Records, command: Command, display: Display, force: bool) -> StepOutcome:
    status = None if force else records.status(step)
    repeated = status is None
    if status is None:
        records.forget(step)
        try:
            began = monotonic()
            status = command(step)
            seconds = monotonic() - began
        except TimeLimitReached as reached:
            return _unfinished(step, str(reached))
        except TirefmuError as error:
            raise TirefmuError(f"step {step.name}: {error}") from error
        if _result(step).get("interrupted"):
            raise KeyboardInterrupt  # a fit ends with the best values so far, which is no complete step
        records.add(step, status, round(seconds, 1))
    result = _result(step)
    return StepOutcome(step, status, repeated, summary_of(step.command, result, status), _picture(step))


def _seconds_ahead(steps: Sequence[Step], records: Records, force: bool) -> dict[str, float | None]:
    """Return the time that each step took the last time, for the steps that are likely to be repeated."""
    repeated: list[Step] = []
    for step in steps:
        if force or records.status(step) is None or reads_results(step, repeated):
            repeated.append(step)
    return {step.name: records.seconds(step) for step in repeated}


def _sum(seconds: Iterable[float | None]) -> float | None:
    """Return the sum of times; None if one of them is unknown."""
    times = list(seconds)
    return None if None in times else sum(time for time in times if time is not None)


def _picture(step: Step) -> str:
    page = step.page.read_text(encoding="utf-8", errors="replace") if step.page and step.page.is_file() else ""
    first = PICTURE.search(page)
    return first[1] if first else ""


def _unfinished(step: Step, last: str) -> StepOutcome:
    """Return the outcome of a step that was ended; it is not recorded, and the next run repeats it."""
    text = f"no answer within the time limit of {step.time_limit:g} s"
    lines = (f"last progress: {last or 'none'}", f"longer: time_limit in [{step.command}] of the project file")
    return StepOutcome(replace(step, outputs=(), page=None), 1, True, Summary(text, "limited", lines))


def _result(step: Step) -> dict[str, Any]:
    try:
        content = json.loads(step.result.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise TirefmuError(f"{step.result}: cannot be read ({error})") from error
    return content if isinstance(content, dict) else {}


def _write_index(project: Project, outcomes: Sequence[StepOutcome], missing: Sequence[str]) -> None:
    path = project.folder / INDEX
    folder = project.folder

    def links(outcome: StepOutcome) -> list[tuple[str, str]]:
        first = [outcome.step.page] if outcome.step.page else []
        written = [file for output in outcome.step.outputs for file in files_of(output)]
        files = [file.relative_to(folder).as_posix() for file in dict.fromkeys([*first, *written])]
        return [("open the page" if i < len(first) else file, "./" + quote(file)) for i, file in enumerate(files)]

    text = page_text(
        "tirefmu.applications.project", {"links": links}, title=project.path.resolve().parent.name, outcomes=outcomes,
                     missing=missing)  # fmt: skip
    with writing(path):
        write_page(text, path)


#: What an error of the command line begins with.
ERROR = "tirefmu: error: "


class TimeLimitReached(Exception):
    """The process was ended. It carries the last line of its progress."""


def run_limited(command: str, arguments: Sequence[str], seconds: float, report: Callable[[str], None]) -> int:
    """Run a command of the command line, and end it at a time limit, whatever it computes then.

    `report`: called with each line of its progress. Returns: its exit code, 0 or 1. Raises `TimeLimitReached` if it was
    ended. Raises `TirefmuError`: with its message, if it ended with an error.
    """
    line = [sys.executable, "-P", "-m", "tirefmu", command, *arguments]  # -P: no module of the current folder
    process = subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace")
    reached, last = Event(), ""

    def end() -> None:
        reached.set()
        process.kill()

    timer = Timer(seconds, end)
    timer.start()
    with process:
        try:
            for text in process.stderr or ():
                last = text.rstrip()
                if not last.startswith(ERROR):
                    report(last)
            status = process.wait()
        finally:
            timer.cancel()
            process.kill()
    if reached.is_set():
        raise TimeLimitReached(last)
    if status not in (0, 1):
        raise TirefmuError(last.removeprefix(ERROR) or f"ended with exit code {status}")
    return status
