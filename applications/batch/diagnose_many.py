"""Diagnoses of many recordings: a folder of results for each, and a summary."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pandas as pd

from ...boundary.errors import TirefmuError, path_from
from ...boundary.escaping import file_name
from ...boundary.named_options import named
from ...diagnosis import Diagnosis, diagnose, export_and_simulate, write_report
from ...measurements import Recording, recording_from
from ...tires import Tire, tire_from
from .jobs import unique
from .resumable import FAILED, BatchResult, JobOutcome, Kind, compute, digest_of, recordings_in, write_summary

#: States of a diagnosis: complete; complete, but an FMU does not match direct evaluation.
DIAGNOSED, DIFFERS = "diagnosed", "FMU differs"
#: What follows a diagnosis.
FMUS, REPORT = "building both FMUs and simulating them", "writing the report"


@dataclass(frozen=True)
class DiagnosisResult(BatchResult):
    """The result of one diagnosis of a batch.

    - `status`: "diagnosed", "FMU differs" (from direct evaluation), "failed" for invalid data or options, or "lost".
    - `verdict`, `rating`: as in the diagnosis: a sentence, and "green", "amber" or "red".
    - `found`: the identified effects.
    - `errors`: by channel, on the hold-out set: error ``before`` and ``after``, and noise ``floor``.
    """

    verdict: str = ""
    rating: str = ""
    found: tuple[str, ...] = ()
    delivered: bool = False
    rows: int = 0
    seconds: float = 0.0
    errors: Mapping[str, Mapping[str, float | None]] = field(default_factory=dict)

    @property
    def complete(self) -> bool:
        """Whether the recording was diagnosed and the FMUs match."""
        return self.status == DIAGNOSED


#: Called with a result and the numbers of finished and of all recordings.
Progress = Callable[[DiagnosisResult, int, int], None]


@dataclass(frozen=True)
class DiagnosisJob:
    """One diagnosis: the recording, the options of `tirefmu.diagnose`, and whether FMUs are exported and simulated."""

    name: str
    table: Path
    signs: str | None
    where: str | None
    tire: Tire | None
    options: Mapping[str, Any]
    fmus: bool


@dataclass(frozen=True)
class DiagnosisTask:
    """A job with its data: what a worker needs."""

    job: DiagnosisJob
    recording: Recording


@named(diagnose)
def diagnose_many(
    tables: str | Path | Sequence[str | Path],
    folder: str | Path,
    *,
    signs: str | None = None,
    where: str | None = None,
    fmus: bool = True,
    scheduler: str | None = None,
    workers: int | None = None,
    resume: bool = False,
    progress: Progress | None = None,
    **options: Any,
) -> tuple[DiagnosisResult, ...]:
    """Diagnose many recordings.

    Parameters
    ----------
    tables : path, or sequence of paths
        Recordings, or folders of recordings.
    folder : path
        For the results; it is created.
    signs, where : str, optional
        As for `tirefmu.measurements.recordings_from`.
    fmus : bool
        Whether to export and simulate both tires.
    scheduler : str, optional
        Address of a Dask scheduler. Default: processes of this machine.
    workers : int, optional
        Number of local processes. Default: one for each processor.
    resume : bool
        Keep the results that the folder has of recordings with the same data, options and version.
    progress : callable, optional
        Called with each result and the numbers of finished and of all recordings.
    **options
        Of `tirefmu.diagnose`, for all recordings: tire, model, effects, nominal, candidates.

    Returns
    -------
    tuple of DiagnosisResult
        Of each recording. The folder has ``NAME/`` with what ``tirefmu diagnose`` writes, ``NAME.json``,
        ``summary.csv`` (and ``summary.parquet`` with pyarrow), and ``summary.html``.

    Raises
    ------
    FitError
        If there is no recording, two have the same name, or the cluster cannot be used.
    DataError
        If the folder cannot be written.
    UnknownOption
        If `options` has a name that is no option of `tirefmu.diagnose`.

    Notes
    -----
    Local workers are new Python processes. A script that calls this function needs ``if __name__ == "__main__":``.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     (result,) = diagnose_many("missing.csv", folder, tire="trento_hoosier")
    >>> result.status, result.reasons
    ('failed', ('missing.csv: no such file',))
    """
    folder = path_from(folder)
    given = [tables] if isinstance(tables, (str, Path)) else list(tables)
    paths = [path_from(path) for path in given]
    files = [file for path in paths for file in (recordings_in(path) if path.is_dir() else [path])]
    chosen = {key: value for key, value in options.items() if value is not None}
    chosen |= {key: tuple(chosen[key]) for key in ("effects", "candidates") if key in chosen}
    baseline = tire_from(chosen.pop("tire")) if "tire" in chosen else None
    jobs = [DiagnosisJob(file_name(file.stem), file, signs, where, baseline, chosen, fmus) for file in files]
    return compute(
        DIAGNOSES, unique(jobs, "recordings"), folder, scheduler=scheduler, workers=workers, resume=resume,
        progress=progress, summarize=lambda results: _write_summary(results, folder),
    )  # fmt: skip


def task_of(job: DiagnosisJob) -> DiagnosisTask:
    """Return a job with its data; raise TirefmuError if the file cannot be used."""
    return DiagnosisTask(job, recording_from(job.table, signs=job.signs, where=job.where))


def run(task: DiagnosisTask) -> JobOutcome[DiagnosisResult]:
    """Diagnose the recording of a task, in any process."""
    job, recording = task.job, task.recording
    with TemporaryDirectory(prefix="tirefmu-") as scratch:
        folder = Path(scratch, job.name)
        try:
            result = diagnose(recording, tire=job.tire, **job.options)
            content = write_answer(result, recording, folder, fmus=job.fmus)
        except TirefmuError as error:
            return JobOutcome(DiagnosisResult(job.name, FAILED, (str(error),)))
        files = {f"{job.name}/{path.name}": path.read_bytes() for path in sorted(folder.iterdir())}
    errors = {channel: {key: gap[key] for key in ("before", "after", "floor")}
              for channel, gap in content["gap"]["holdout"].items()}  # fmt: skip
    status = DIAGNOSED if content["simulated"].get("ok", True) else DIFFERS
    row = DiagnosisResult(
        job.name, status, tuple(content["not_delivered_because"]),
        result.verdict, result.rating, tuple(finding.effect for finding in result.found), result.delivered,
        len(recording), result.seconds, errors,
    )  # fmt: skip
    return JobOutcome(row, files)


def write_answer(
    result: Diagnosis, recording: Recording, folder: Path, *, fmus: bool = True, others: Sequence[Recording] = (),
    command: str = "", begin: Callable[[str], None] = lambda part: None,
) -> dict[str, Any]:  # fmt: skip
    """Write ``diagnosis.json``, the tires, FMUs and the report of a diagnosis; return the content of the first.

    `folder`: created if it does not exist. `fmus`: whether both tires are exported and simulated, also over `others`.
    `command`: the command line. `begin`: called with `FMUS` and `REPORT` before each part.
    """
    path = result.save(folder)
    written, simulated = {"tire": "improved.tir", "base_tire": "base.tir"}, dict[str, Any]()
    if fmus:
        begin(FMUS)
        simulated = export_and_simulate(result, recording, folder, others)
        written |= {"fmu": "improved.fmu", "base_fmu": "base.fmu"}
    begin(REPORT)
    content = {**result.to_json(**written), "simulated": simulated}
    path.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    write_report(result, recording, folder / "report.html", simulated, command=command)
    return content


def _digest_of(job: DiagnosisJob) -> str:
    """Return a digest of what determines the result of a job."""
    tire = job.tire and (job.tire.model, sorted(job.tire.values.items()), sorted(job.tire.has), job.tire.added)
    paths: list[str | Path] = [job.table, *([job.where] if job.where else [])]
    return digest_of((job.signs, job.where, job.fmus, tire, sorted(job.options.items())), paths)


def table_of(results: Sequence[DiagnosisResult]) -> pd.DataFrame:
    """Return a row for each recording: status, verdict, effects, and errors by channel.

    >>> table_of([DiagnosisResult("run7", "failed", ("run7.csv: no rows",))])["reasons"].tolist()
    ['run7.csv: no rows']
    """
    rows = []
    for result in results:
        row: dict[str, Any] = {
            **result.to_json(),
            "reasons": "; ".join(result.reasons),
            "found": ", ".join(result.found),
        }
        for channel, error in row.pop("errors").items():
            row |= {f"{channel}_{key}": value for key, value in error.items()}
        rows.append(row)
    return pd.DataFrame(rows)


def _earlier(folder: Path, name: str) -> list[Path]:
    """Return the files of an earlier run; what others have put there remains."""
    kinds = ("*.tir", "*.fmu", "*.toml", "*.schema.json", "diagnosis.json", "report.html")
    return [path for kind in kinds for path in (folder / name).glob(kind)]


def _write_summary(results: Sequence[DiagnosisResult], folder: Path) -> None:
    channels = list(dict.fromkeys(channel for result in results for channel in result.errors))
    write_summary(table_of(results), folder, "diagnoses.html", results=results, channels=channels)


#: How diagnoses are computed and stored.
DIAGNOSES: Kind[DiagnosisJob, DiagnosisTask, DiagnosisResult] = Kind(
    task_of, run, _digest_of, DiagnosisResult, _earlier
)
