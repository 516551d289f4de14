"""The list of fits of a batch: a TOML file of jobs, or a folder of recordings with one job each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tirefmu.boundary.bounded_file import toml_file
from tirefmu.boundary.errors import FitError, path_from
from tirefmu.boundary.escaping import file_name, quoted
from tirefmu.boundary.json_schema import document, object_schema
from tirefmu.measurements.files.reading import READERS

from .resumable import Job
from .toml_file import check_keys

#: Options of a job: the arguments of `tirefmu.fit` with their types.
OPTIONS: Mapping[str, Any] = {
    "model": str, "start": str, "effects": list[str], "without": list[str], "recipe": str, "loss": str, "method": str,
    "iterations": int, "seed": int, "nominal": dict[str, float], "screening": bool, "rows": str,
    "constraints": list[str], "without_constraints": list[str],
}  # fmt: skip
#: Options that determine how the tables are read.
READING: Mapping[str, Any] = {"signs": str, "where": str}
#: Keys of a job, and of the file.
JOB: Mapping[str, Any] = {"name": str, "tables": list[str], **OPTIONS, **READING}
FILE: Mapping[str, Any] = {"defaults": dict[str, Any], "jobs": list[Any]}


@dataclass(frozen=True)
class FitJob:
    """One fit of a batch.

    - `name`: name of its output files.
    - `tables`: the recordings of the tire.
    - `signs`, `where`: as for `tirefmu.measurements.recordings_from`.
    - `options`: arguments of `tirefmu.fit`. ``start`` is a path or a name.
    """

    name: str
    tables: tuple[Path, ...]
    signs: str | None = None
    where: str | None = None
    options: Mapping[str, Any] = field(default_factory=dict)


def read_jobs(path: str | Path, options: Mapping[str, Any] | None = None) -> tuple[FitJob, ...]:
    r"""Return the jobs of a file, or of a folder.

    `path`: a TOML file with ``[[jobs]]``, each with ``name``, ``tables`` and options, and ``[defaults]`` with options
    of all jobs. Paths are relative to the file. Or a folder: each recording in it is a job with its name. `options`:
    options of all jobs of a folder. Raises `FitError` if the file cannot be read, has no job, an invalid value, or two
    jobs of the same name. Raises `UnknownName` if a key does not exist.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "jobs.toml")
    ...     _ = file.write_text('[defaults]\nmodel = "mf96"\n[[jobs]]\nname = "front"\ntables = ["run7.csv"]\n')
    ...     (job,) = read_jobs(file)
    >>> job.name, job.tables[0].name, job.options
    ('front', 'run7.csv', {'model': 'mf96'})
    """
    path = path_from(path)
    if path.is_dir():
        given = {key: list(value) if isinstance(value, tuple) else value for key, value in (options or {}).items()}
        check_keys(given, {**OPTIONS, **READING}, "options")
        return unique(_jobs_of_folder(path, given), path)
    if options:
        raise FitError(f"{path}: [defaults] in the file sets {', '.join(options)}")
    content = toml_file(path, FitError)
    check_keys(content, FILE, str(path))
    defaults = content.get("defaults", {})
    check_keys(defaults, {**OPTIONS, **READING}, f"{path}, defaults")
    items = content.get("jobs", [])
    if not items:
        raise FitError(f"{path}: no [[jobs]]")
    return unique([_job(item, defaults, path, number) for number, item in enumerate(items, start=1)], path)


def jobs_schema() -> dict[str, Any]:
    """Return the JSON Schema of a list of jobs."""
    jobs = {"type": "array", "minItems": 1, "items": object_schema(JOB, ["name", "tables"])}
    content = {**FILE, "defaults": object_schema({**OPTIONS, **READING}), "jobs": jobs}
    return document("jobs", "1.0", "Jobs of many fits", object_schema(content, ["jobs"]))


def _jobs_of_folder(folder: Path, options: Mapping[str, Any]) -> list[FitJob]:
    """Return a job for each recording in a folder."""
    tables = sorted(one for one in folder.iterdir() if one.suffix.lower() in READERS and one.is_file())
    if not tables:
        raise FitError(f"{folder}: no recording ({', '.join(READERS)})")
    how = {key: options[key] for key in READING if key in options}
    others = {key: value for key, value in options.items() if key not in READING}
    return [FitJob(file_name(one.stem), (one,), how.get("signs"), how.get("where"), others) for one in tables]


def _job(item: Any, defaults: Mapping[str, Any], path: Path, number: int) -> FitJob:
    location = f"{path}, job {number}"
    check_keys(item, JOB, location)
    name, tables = item.get("name"), item.get("tables")
    if not name or not tables:
        raise FitError(f"{location}: {'tables' if name else 'name'} is missing")
    given = {**defaults, **{key: value for key, value in item.items() if key not in ("name", "tables")}}
    options = {key: given[key] for key in OPTIONS if key in given}
    for key in ("start", "recipe"):
        if key in options and (path.parent / options[key]).is_file():
            options[key] = str(path.parent / options[key])
    files = tuple(path.parent / table for table in tables)
    return FitJob(name, files, given.get("signs"), given.get("where"), options)


def unique(jobs: Sequence[Job], source: str | Path) -> tuple[Job, ...]:
    """Return the jobs.

    Raises `FitError` if a name is no file name, or two jobs would write the same files, also where file names have no
    case.
    """
    known: dict[str, Job] = {}
    for job in jobs:
        if not job.name or file_name(job.name) != job.name:
            example = file_name(job.name, "tire")
            raise FitError(f"{source}: name {quoted(job.name)} of a job is not a file name: {example}, for example")
        if job.name.lower() in known:
            raise FitError(f"{source}: two jobs have the name {quoted(job.name)}")
        known[job.name.lower()] = job
    return tuple(jobs)
