"""The list of fits of a batch: a TOML file of jobs, or a folder of recordings with one job each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from ...boundary.bounded_file import toml_file
from ...boundary.errors import FitError, path_from
from ...boundary.escaping import file_name, quoted
from ...boundary.json_schema import document, object_schema
from ...boundary.schema_check import check_content
from ...fitting.options import VERSIONS, declared_options
from .resumable import Job, recordings_in

#: The types of options by kind.
_TYPES: Mapping[str, Any] = {
    "text": str, "names": list[str], "name or file": str, "integer": int, "number": float, "pairs": dict[str, float],
    "weights": dict[str, float], "flag": bool,
}  # fmt: skip
#: Options of a job: the arguments of `tirefmu.fit` with their types.
OPTIONS: Mapping[str, Any] = {
    "model": str,
    "start": str,
    **{name: _TYPES[option.kind] for name, (option, _) in declared_options("jobs").items()},
}
#: Those that are a name or a path, which is relative to the job file.
_PATHS = ("start", *(name for name, (option, _) in declared_options("jobs").items() if option.kind == "name or file"))
#: Options that determine how the tables are read.
READING: Mapping[str, Any] = {"signs": str, "where": str}


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
    options of all jobs of a folder. Raises `FitError` if the file cannot be read, has no job, an unknown key, an
    invalid value, or two jobs of the same name.

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
        check_content(given, object_schema({**OPTIONS, **READING}), "options", FitError)
        return unique(_jobs_of_folder(path, given), path)
    if options:
        raise FitError(f"{path}: [defaults] in the file sets {', '.join(options)}")
    content = toml_file(path, FitError)
    check_content(content, jobs_schema(), str(path), FitError)
    defaults = content.get("defaults", {})
    return unique([_job(item, defaults, path) for item in content["jobs"]], path)


def jobs_schema() -> dict[str, Any]:
    """Return the JSON Schema of a list of jobs."""
    tables = Annotated[list[str], "the recordings of the tire", {"minItems": 1}]
    job = object_schema({"name": str, "tables": tables, **OPTIONS, **READING}, ["name", "tables"])
    jobs = {"type": "array", "minItems": 1, "items": job, "description": "[[jobs]], one table for each fit"}
    content = {"defaults": object_schema({**OPTIONS, **READING}), "jobs": jobs}
    return document("jobs", VERSIONS["jobs"], "Jobs of many fits", object_schema(content, ["jobs"]))


def _jobs_of_folder(folder: Path, options: Mapping[str, Any]) -> list[FitJob]:
    """Return a job for each recording in a folder."""
    how = {key: options[key] for key in READING if key in options}
    others = {key: value for key, value in options.items() if key not in READING}
    return [
        FitJob(file_name(path.stem), (path,), how.get("signs"), how.get("where"), others)
        for path in recordings_in(folder)
    ]


def _job(item: Mapping[str, Any], defaults: Mapping[str, Any], path: Path) -> FitJob:
    given = {**defaults, **{key: value for key, value in item.items() if key not in ("name", "tables")}}
    options = {key: given[key] for key in OPTIONS if key in given}
    for key in _PATHS:
        if key in options and (path.parent / options[key]).is_file():
            options[key] = str(path.parent / options[key])
    files = tuple(path.parent / table for table in item["tables"])
    return FitJob(item["name"], files, given.get("signs"), given.get("where"), options)


def unique(jobs: Sequence[Job], source: str | Path) -> tuple[Job, ...]:
    """Return the jobs.

    Raises `FitError` if a name is no file name, or two jobs would write the same files, also where file names have no
    case.
    """
    by_name: dict[str, Job] = {}
    for job in jobs:
        if not job.name or file_name(job.name) != job.name:
            example = file_name(job.name, "tire")
            raise FitError(f"{source}: name {quoted(job.name)} of a job is not a file name: {example}, for example")
        if job.name.lower() in by_name:
            raise FitError(f"{source}: two jobs have the name {quoted(job.name)}")
        by_name[job.name.lower()] = job
    return tuple(jobs)
