"""Fits of many tires: every result is written as it finishes, a tire that fails is a row with its reason."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pandas as pd

from ...boundary.errors import FitError, TirefmuError, path_from
from ...boundary.named_options import named
from ...fitting import fit
from ...measurements import Recording, recordings_from
from ...tires import tire_from
from ...tires.tire import Tire
from .jobs import OPTIONS, READING, FitJob, read_jobs, unique
from .records import JobResult, result_of_fit, table_of
from .resumable import FAILED, LOST, JobOutcome, Kind, compute, digest_of, write_summary

#: Called with a result and the numbers of finished and of all jobs.
Progress = Callable[[JobResult, int, int], None]


@dataclass(frozen=True)
class Batch:
    """The results of a batch.

    - `results`: in the order of the jobs.
    - `folder`: ``NAME.tir`` and ``NAME.json`` of each job, ``summary.csv`` (and ``summary.parquet`` with pyarrow), and
      ``summary.html``.
    """

    results: tuple[JobResult, ...]
    folder: Path

    @property
    def table(self) -> pd.DataFrame:
        """A row for each job."""
        return table_of(self.results)

    def write_summary(self) -> None:
        """Write the table and the page."""
        worst_first = sorted(self.results, key=lambda result: (result.usable, result.status))
        write_summary(
            self.table, self.folder, "report.html", results=self.results,
            counts=Counter(result.status for result in worst_first),
            channels=list(dict.fromkeys(channel for result in self.results for channel in result.channels)),
        )  # fmt: skip


@dataclass(frozen=True)
class FitTask:
    """A job with its data: what a worker needs."""

    job: FitJob
    recordings: tuple[Recording, ...]
    start: Tire | str | None


@named(OPTIONS, READING)
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
    results = compute(
        FITS, listed, folder, scheduler=scheduler, workers=workers, resume=resume, progress=progress,
        summarize=lambda results: Batch(results, folder).write_summary(),
    )  # fmt: skip
    return Batch(results, folder)


def task_of(job: FitJob) -> FitTask:
    """Return a job with its data.

    Raises `TirefmuError` if a file cannot be used.
    """
    start = job.options.get("start")
    given = start if start in (None, "features") else tire_from(start)
    return FitTask(job, tuple(recordings_from(job.tables, signs=job.signs, where=job.where)), given)


def run(task: FitTask) -> JobOutcome[JobResult]:
    """Fit the tire of a task, in any process."""
    job = task.job
    options = {**job.options, "start": task.start}
    try:
        fitted = fit(task.recordings, options.pop("model", None), **options)
    except TirefmuError as error:
        return JobOutcome(JobResult(job.name, FAILED, (str(error),)))
    if fitted.run.interrupted:
        return JobOutcome(JobResult(job.name, LOST, (f"interrupted: {fitted.run.interrupted}",)))
    tire = replace(fitted.tire, name=fitted.tire.name or job.name)
    with TemporaryDirectory(prefix="tirefmu-") as scratch:
        path = Path(scratch, f"{job.name}.tir")
        tire.save(path)
        files = {path.name: path.read_bytes()}
    return JobOutcome(result_of_fit(job.name, fitted), files, {"fit": fitted.to_json()})


def _digest_of(job: FitJob) -> str:
    """Return a digest of what determines the result of a job."""
    named = [job.options[key] for key in ("start", "recipe") if key in job.options]
    paths = [*job.tables, *named, *([job.where] if job.where else [])]
    return digest_of((job.signs, job.where, sorted(job.options.items())), paths)


#: How fits are computed and stored.
FITS: Kind[FitJob, FitTask, JobResult] = Kind(
    task_of, run, _digest_of, JobResult, lambda folder, name: [folder / f"{name}.tir"]
)
