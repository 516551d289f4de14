"""Batches: each result is written when it is finished, and a repeated run computes the missing results only."""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any, Generic, Protocol, Self, TypeVar

import pandas as pd

from ...boundary.bounded_file import write_whole
from ...boundary.errors import DataError, FitError, TirefmuError, writing
from ...boundary.json_schema import json_value
from ...drawing.page import page_text, write_page
from ...measurements.files.reading import READERS
from .execution import Lost
from .execution import results as outcomes_of

#: States of a job without a result: invalid data or options; its process ended, or the program has an error.
FAILED, LOST = "failed", "lost"


class NamedJob(Protocol):
    """A job."""

    @property
    def name(self) -> str:
        """Name of its output files."""


@dataclass(frozen=True)
class BatchResult:
    """The result of a job.

    - `name`: of the job.
    - `status`: `FAILED`, `LOST`, or another word for a result.
    """

    name: str
    status: str
    reasons: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Return the result as JSON values; a number that is not finite is null."""
        return dict(json_value(self))

    @classmethod
    def from_json(cls, plain: Mapping[str, Any]) -> Self:
        """Return the result of `to_json`; raise TypeError for other values."""
        values: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in plain.items()}
        return cls(**values)


Job = TypeVar("Job", bound=NamedJob)
Task = TypeVar("Task")
Result = TypeVar("Result", bound=BatchResult)


@dataclass(frozen=True)
class JobOutcome(Generic[Result]):
    """What a worker returns.

    - `files`: contents of the output files by path in the folder of the batch.
    - `report`: further JSON values for NAME.json.
    """

    result: Result
    files: Mapping[str, bytes] = field(default_factory=dict)
    report: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Kind(Generic[Job, Task, Result]):
    """How the jobs of a batch are computed and stored.

    - `task_of`: returns a job with its data; raises TirefmuError if a file cannot be used.
    - `run`: computes a task in any process: a function of a module.
    - `digest_of`: returns a digest of what determines the result of a job.
    - `result`: the class of results.
    - `earlier`: returns the output files that earlier runs have left for a job, by folder and name.
    """

    task_of: Callable[[Job], Task]
    run: Callable[[Task], JobOutcome[Result]]
    digest_of: Callable[[Job], str]
    result: type[Result]
    earlier: Callable[[Path, str], Sequence[Path]]


def compute(
    kind: Kind[Job, Task, Result], jobs: Sequence[Job], folder: Path, *, scheduler: str | None, workers: int | None,
    resume: bool, progress: Callable[[Result, int, int], None] | None,
    summarize: Callable[[tuple[Result, ...]], None],
) -> tuple[Result, ...]:  # fmt: skip
    """Compute the jobs of a batch.

    `folder`: for the results; it is created. `scheduler`, `workers`: as for `execution.results`. `resume`: keep the
    results that the folder has of the same jobs. Only lost jobs are computed again. `progress`: called with each result
    and the numbers of finished and of all jobs. `summarize`: called with the results in the order of the jobs, also if
    the batch is interrupted. Raises `DataError` if the folder cannot be written.
    """
    made_folder(folder)
    digests = [kind.digest_of(job) for job in jobs]
    results = {
        number: kept for number, job in enumerate(jobs)
        if resume and (kept := _kept(kind, folder, job, digests[number]))
    }  # fmt: skip
    pending = [number for number in range(len(jobs)) if number not in results]
    try:
        for number, outcome in _outcomes(kind, [jobs[number] for number in pending], scheduler, workers):
            _write(kind, folder, digests[pending[number]], outcome)
            results[pending[number]] = outcome.result
            if progress:
                progress(outcome.result, len(results), len(jobs))
    finally:
        ordered = tuple(results[number] for number in sorted(results))
        summarize(ordered)
    return ordered


def made_folder(folder: Path) -> Path:
    """Return a folder for results, which is created; raise `DataError` if it cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DataError(f"{folder}: cannot be created ({error.strerror or error})") from error
    return folder


def digest_of(parts: object, paths: Iterable[str | Path]) -> str:
    """Return a digest of version, options and the contents of files.

    `paths`: a name, an expression, or a file that cannot be read (an error that the job reports) counts by its text.
    """
    digest = hashlib.sha256(repr((version("tirefmu"), parts)).encode())
    for path in map(Path, paths):
        with contextlib.suppress(OSError, ValueError):
            digest.update(repr(path.name).encode() + path.read_bytes())
    return digest.hexdigest()


def recordings_in(folder: Path) -> list[Path]:
    """Return the recordings in a folder; raise `FitError` if there is none."""
    paths = sorted(path for path in folder.iterdir() if path.suffix.lower() in READERS and path.is_file())
    if not paths:
        raise FitError(f"{folder}: no recording ({', '.join(READERS)})")
    return paths


def write_summary(table: pd.DataFrame, folder: Path, template: str, **content: Any) -> None:
    """Write the results of a batch: a table as CSV, with pyarrow as Parquet, and a page.

    `template`: of the page. `content`: its variables.
    """
    numbers = {"number": lambda value: "" if value is None else f"{value:.4g}"}
    for suffix in (".csv", ".parquet") if find_spec("pyarrow") else (".csv",):
        write_table(table, folder / f"summary{suffix}")
    with writing(folder, DataError):
        write_page(
            page_text("tirefmu.applications.batch", numbers, template=template, **content), folder / "summary.html"
        )


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV or Parquet, by the ending of the path."""
    buffer = BytesIO()
    if path.suffix == ".parquet":
        table.to_parquet(buffer)
    else:
        table.to_csv(buffer, index=False)
    with writing(path, DataError):
        write_whole(path, buffer.getvalue())


def _outcomes(
    kind: Kind[Job, Task, Result], jobs: Sequence[Job], scheduler: str | None, workers: int | None
) -> Iterator[tuple[int, JobOutcome[Result]]]:
    """Yield number and outcome of each job; data that cannot be read are an outcome."""
    numbers: list[int] = []
    unreadable: list[tuple[int, JobOutcome[Result]]] = []

    def tasks() -> Iterator[Task]:
        for number, job in enumerate(jobs):
            try:
                task = kind.task_of(job)
            except TirefmuError as error:
                unreadable.append((number, JobOutcome(kind.result(job.name, FAILED, (str(error),)))))
                continue
            numbers.append(number)
            yield task

    for place, outcome in outcomes_of(kind.run, tasks(), scheduler, workers):
        if isinstance(outcome, Lost):
            outcome = JobOutcome(kind.result(jobs[numbers[place]].name, LOST, (outcome.reason,)))
        yield numbers[place], outcome
        yield from (unreadable.pop(0) for _ in range(len(unreadable)))
    yield from unreadable


def _kept(kind: Kind[Job, Task, Result], folder: Path, job: Job, digest: str) -> Result | None:
    """Return the result of the same job that a folder has, or None."""
    try:
        plain = json.loads((folder / f"{job.name}.json").read_text(encoding="utf-8"))
        result = kind.result.from_json(plain["result"])
        same = plain["digest"] == digest and result.name == job.name and result.status != LOST
        complete = same and all((folder / name).is_file() for name in plain["files"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
    return result if complete else None


def _write(kind: Kind[Job, Task, Result], folder: Path, digest: str, outcome: JobOutcome[Result]) -> None:
    """Write the files of a job; NAME.json last, as it states that all are complete."""
    name = outcome.result.name
    plain = {"digest": digest, "result": outcome.result.to_json(), "files": sorted(outcome.files), **outcome.report}
    with writing(folder, DataError):
        (folder / f"{name}.json").unlink(missing_ok=True)
        for earlier in kind.earlier(folder, name):
            earlier.unlink(missing_ok=True)
        for path, content in outcome.files.items():
            (folder / path).parent.mkdir(exist_ok=True)
            write_whole(folder / path, content)
        write_whole(folder / f"{name}.json", json.dumps(plain, indent=1).encode("utf-8"))
