"""Fits of many tires: every result is written as it finishes, a tire that fails is a row with its reason."""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any

import pandas as pd

from tirefmu.fitting import fit
from tirefmu.measurements import Recording, recordings_from
from tirefmu.symbolic.errors import DataError, FitError, TirefmuError, path_from
from tirefmu.tires import tire_from
from tirefmu.tires.drawing.page import page_text, write_page
from tirefmu.tires.drawing.style import write_whole
from tirefmu.tires.tire import Tire

from .execution import Lost
from .jobs import FitJob, read_jobs, unique
from .records import FAILED, LOST, JobResult, result_of_fit, table_of
from .workers import results as outcomes

#: Called with a result and the numbers of finished and of all jobs.
Progress = Callable[[JobResult, int, int], None]


@dataclass(frozen=True)
class Batch:
    """The results of a batch.

    Attributes
    ----------
    results : tuple of JobResult
        In the order of the jobs.
    folder : Path
        ``NAME.tir`` and ``NAME.json`` of each job, ``summary.csv`` (and ``summary.parquet`` with pyarrow), and
        ``summary.html``.
    """

    results: tuple[JobResult, ...]
    folder: Path

    @property
    def table(self) -> pd.DataFrame:
        """A row for each job."""
        return table_of(self.results)


@dataclass(frozen=True)
class Task:
    """A job with its data: what a worker needs."""

    job: FitJob
    recordings: tuple[Recording, ...]
    start: Tire | str | None


@dataclass(frozen=True)
class Fitted:
    """What a worker returns: the result, the tire, and the fit as JSON values."""

    result: JobResult
    tire: Tire | None = None
    report: dict[str, Any] | None = None


def fit_many(
    jobs: str | Path | Sequence[FitJob],
    folder: str | Path,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    resume: bool = False,
    progress: Progress | None = None,
    **options: Any,
) -> Batch:
    """Fit many tires.

    Parameters
    ----------
    jobs : path, or sequence of FitJob
        As for `read_jobs`.
    folder : path
        For the results; it is created.
    scheduler : str, optional
        Address of a Dask scheduler. Default: processes of this machine.
    workers : int, optional
        Number of local processes. Default: one for each processor.
    resume : bool
        Keep the results that the folder has of jobs with the same data, options and version. Only lost jobs are
        computed again.
    progress : callable, optional
        Called with each result and the numbers of finished and of all jobs.
    **options
        Options of all jobs of a folder of recordings.

    Returns
    -------
    Batch
        The tires are the same for every number and kind of workers.

    Raises
    ------
    FitError, UnknownName
        As for `read_jobs`; if there are options for a list of jobs; if the cluster cannot be used.
    DataError
        If the folder cannot be written.

    Notes
    -----
    Local workers are new Python processes. A script that calls this function needs ``if __name__ == "__main__":``.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     batch = fit_many([FitJob("front", (Path("missing.csv"),))], folder)
    >>> batch.results[0].status, batch.results[0].reasons
    ('failed', ('missing.csv: no such file',))
    """
    folder = path_from(folder)
    if isinstance(jobs, (str, Path)):
        listed = read_jobs(jobs, options)
    elif options:
        raise FitError(f"options of jobs are in FitJob.options: {', '.join(options)}")
    else:
        listed = unique(tuple(jobs), "jobs")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DataError(f"{folder}: cannot be created ({error.strerror or error})") from error
    digests = [digest_of(job) for job in listed]
    results = {
        number: kept for number, job in enumerate(listed)
        if resume and (kept := _kept(folder, job, digests[number]))
    }  # fmt: skip
    pending = [number for number in range(len(listed)) if number not in results]

    def finish(number: int, fitted: Fitted) -> None:
        _write(folder, digests[number], fitted)
        results[number] = fitted.result
        if progress:
            progress(fitted.result, len(results), len(listed))

    try:
        for number, fitted in _fitted([listed[number] for number in pending], scheduler, workers):
            finish(pending[number], fitted)
    finally:
        batch = Batch(tuple(results[number] for number in sorted(results)), folder)
        _write_summary(batch)
    return batch


def _fitted(jobs: Sequence[FitJob], scheduler: str | None, workers: int | None) -> Iterator[tuple[int, Fitted]]:
    """Yield number and result of each job; data that cannot be read are a result."""
    numbers: list[int] = []
    unreadable: list[tuple[int, Fitted]] = []

    def tasks() -> Iterator[Task]:
        for number, job in enumerate(jobs):
            try:
                task = task_of(job)
            except TirefmuError as error:
                unreadable.append((number, Fitted(JobResult(job.name, FAILED, (str(error),)))))
                continue
            numbers.append(number)
            yield task

    for place, outcome in outcomes(run, tasks(), scheduler, workers):
        if isinstance(outcome, Lost):
            outcome = Fitted(JobResult(jobs[numbers[place]].name, LOST, (outcome.reason,)))
        yield numbers[place], outcome
        yield from (unreadable.pop(0) for _ in range(len(unreadable)))
    yield from unreadable


def task_of(job: FitJob) -> Task:
    """Return a job with its data.

    Raises
    ------
    TirefmuError
        If a file cannot be used.
    """
    start = job.options.get("start")
    given = start if start in (None, "features") else tire_from(start)
    return Task(job, tuple(recordings_from(job.tables, signs=job.signs, where=job.where)), given)


def run(task: Task) -> Fitted:
    """Fit the tire of a task, in any process."""
    job = task.job
    options = {**job.options, "start": task.start}
    try:
        found = fit(task.recordings, options.pop("model", None), **options)
    except TirefmuError as error:
        return Fitted(JobResult(job.name, FAILED, (str(error),)))
    if found.interrupted:
        return Fitted(JobResult(job.name, LOST, (f"interrupted: {found.interrupted}",)))
    tire = replace(found.tire, name=found.tire.name or job.name)
    return Fitted(result_of_fit(job.name, found), tire, found.to_json())


def digest_of(job: FitJob) -> str:
    """Return a digest of what determines the result of a job: version, options, and the contents of its files."""
    digest = hashlib.sha256(repr((version("tirefmu"), job.signs, job.where, sorted(job.options.items()))).encode())
    others = [Path(job.options[key]) for key in ("start", "recipe") if key in job.options]
    others += [Path(job.where)] if job.where else []
    for path in (*job.tables, *others):
        with contextlib.suppress(OSError, ValueError):  # a name, an expression, or an error that the fit reports
            digest.update(repr(path.name).encode() + path.read_bytes())
    return digest.hexdigest()


def _kept(folder: Path, job: FitJob, digest: str) -> JobResult | None:
    """Return the result of the same job that a folder has, or None."""
    try:
        plain = json.loads((folder / f"{job.name}.json").read_text(encoding="utf-8"))
        result = JobResult.from_json(plain["result"])
        complete = plain["digest"] == digest and result.name == job.name and result.status != LOST
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
    exists = result.status == FAILED or (folder / f"{job.name}.tir").is_file()
    return result if complete and exists else None


def _write(folder: Path, digest: str, fitted: Fitted) -> None:
    """Write tire and report of a job; the report last, as it says that both are complete."""
    tire, report = (folder / f"{fitted.result.name}{suffix}" for suffix in (".tir", ".json"))
    plain = {"digest": digest, "result": fitted.result.to_json(), "fit": fitted.report}
    try:
        report.unlink(missing_ok=True)
        if fitted.tire:
            fitted.tire.save(tire)
        else:
            tire.unlink(missing_ok=True)
        write_whole(report, json.dumps(plain, indent=1).encode("utf-8"))
    except OSError as error:
        raise DataError(f"{folder}: cannot be written ({error.strerror or error})") from error


def _write_summary(batch: Batch) -> None:
    table = batch.table
    try:
        write_whole(batch.folder / "summary.csv", table.to_csv(index=False).encode("utf-8"))
        if find_spec("pyarrow"):
            buffer = BytesIO()
            table.to_parquet(buffer)
            write_whole(batch.folder / "summary.parquet", buffer.getvalue())
        write_page(_page(batch), batch.folder / "summary.html")
    except OSError as error:
        raise DataError(f"{batch.folder}: cannot be written ({error.strerror or error})") from error


def _page(batch: Batch) -> str:
    counts = Counter(one.status for one in batch.results)
    channels = dict.fromkeys(channel for one in batch.results for channel in one.channels)
    return page_text(
        "tirefmu.batch", {"number": _number}, results=batch.results, channels=list(channels), counts=counts,
        words=list(dict.fromkeys(one.status for one in sorted(batch.results, key=_worst_first))),
    )  # fmt: skip


def _worst_first(result: JobResult) -> tuple[bool, str]:
    return result.usable, result.status


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"
