"""Records of the steps that were run: a step is repeated if its command line, inputs or outputs have changed."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from hashlib import file_digest, sha256
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, TypedDict

from ...boundary.bounded_file import read_bounded
from ...boundary.errors import writing
from ...boundary.json_schema import document, schema_of
from .steps import Step

#: Name of the file with the records, in the folder of the results.
NAME = "run.json"
LARGEST = 10_000_000


class StepRecord(TypedDict):
    """The record of a step: what determines its results, its outputs, and how it ended."""

    key: Annotated[str, "digest of version, equations, command line and inputs"]
    outputs: Annotated[dict[str, str], "SHA-256 digest by file"]
    status: Annotated[int, "exit code"]
    seconds: Annotated[float, "time that the step took"]


def records_schema() -> dict[str, Any]:
    """Return the JSON Schema of the file of records."""
    return document("run", "1.1", "Records of the steps of a project", schema_of(dict[str, StepRecord]))


@dataclass
class Records:
    """The records of a folder of results.

    - `path`: of the file; a file that is missing or damaged has no record.
    - `entries`: by the name of the step.
    """

    path: Path
    entries: dict[str, StepRecord] = field(default_factory=dict)

    @classmethod
    def of(cls, folder: Path) -> Records:
        """Return the records in a folder."""
        path = folder / NAME
        try:
            entries = json.loads(read_bounded(path, LARGEST))
        except (OSError, ValueError, RecursionError):
            entries = {}
        whole = isinstance(entries, dict) and all(isinstance(entry, dict) for entry in entries.values())
        return cls(path, entries if whole else {})

    def status(self, step: Step) -> int | None:
        """Return the exit code of a step whose results are up to date, or None."""
        entry: Mapping[str, Any] = self.entries.get(step.name, {})
        status = entry.get("status")
        current = entry.get("key") == _key(step) and entry.get("outputs") == _digests(step.outputs)
        return status if current and status in (0, 1) else None

    def seconds(self, step: Step) -> float | None:
        """Return the time that a step took the last time that it ended, or None."""
        entry: Mapping[str, Any] = self.entries.get(step.name, {})
        seconds = entry.get("seconds")
        return float(seconds) if isinstance(seconds, int | float) else None

    def add(self, step: Step, status: int, seconds: float) -> None:
        """Record a step that has ended, and write the file."""
        outputs = _digests(step.outputs)
        self.entries[step.name] = {"key": _key(step), "outputs": outputs, "status": status, "seconds": seconds}
        self._write()

    def forget(self, step: Step) -> None:
        """Invalidate the record of a step that begins, and write the file; the time of the step remains."""
        if step.name in self.entries:
            self.entries[step.name]["key"] = ""
            self._write()

    def _write(self) -> None:
        with writing(self.path):
            self.path.write_text(json.dumps(self.entries, indent=1) + "\n", encoding="utf-8")


def _key(step: Step) -> str:
    """Return a digest of what determines the results: version, equations, command line, contents of the inputs."""
    from ...tires.code.printed import sources_digest  # loads NumPy

    parts = [version("tirefmu"), sources_digest(), step.command, step.arguments, _digests(step.inputs)]
    return sha256(json.dumps(parts).encode()).hexdigest()


def _digests(paths: Iterable[Path]) -> dict[str, str]:
    """Return the digest of each file, also of those in folders; '' for one that does not exist."""
    return {str(path): _digest(path) for given in paths for path in files_of(given)}


def files_of(path: Path) -> Iterator[Path]:
    """Yield a file, or the files in a folder and below it."""
    if path.is_dir():
        yield from sorted(file for file in path.rglob("*") if file.is_file())
    else:
        yield path


def _digest(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""
