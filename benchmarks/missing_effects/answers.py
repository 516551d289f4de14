"""Recordings as an entry reads them, and answers as a scorer reads them: ``answer.schema.json`` is the contract."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.boundary.bounded_file import read_bounded
from tirefmu.boundary.errors import DataError
from tirefmu.boundary.escaping import quoted
from tirefmu.boundary.schema_check import check_content

FloatArray = npt.NDArray[np.float64]
UNKNOWN = "UNKNOWN"
VERSION = 1
MAX_BYTES = 20_000_000
CASE_NAME = re.compile("(tire|system)_[0-9]{2}")


@dataclass(frozen=True, eq=False)
class Case:
    """A recording: what ``case.json`` states, the recording, and the inputs of the other maneuvers."""

    about: Mapping[str, Any]
    recording: pd.DataFrame
    other: pd.DataFrame

    @property
    def channels(self) -> list[str]:
        """The channels that are measured and to be predicted."""
        return list(self.about["channels"])


@dataclass(frozen=True, eq=False)
class Answer:
    """An answer to a case, as in ``answer.schema.json``.

    - `forces`: the channels on the other maneuvers; None if the method failed.
    """

    found: tuple[str, ...] = ()
    probabilities: Mapping[str, float] = field(default_factory=dict)
    variables: tuple[str, ...] = ()
    forces: pd.DataFrame | None = None
    cpu_seconds: float = 0.0
    failed: str = ""


def read_about(folder: Path) -> dict[str, Any]:
    """Return what ``benchmark.json`` states; raises `DataError` if it is missing or none."""
    path = folder / "benchmark.json"
    about = _json(path)
    if not isinstance(about, dict) or about.get("version") != VERSION:
        raise DataError(f"{path}: version is not {VERSION}")
    if not {"commitment", "digest", "cases"} <= about.keys() or not isinstance(about["cases"], list):
        raise DataError(f"{path}: needs commitment, digest and a list of cases")
    if wrong := [name for name in about["cases"] if not CASE_NAME.fullmatch(str(name))]:
        raise DataError(f"{path}: cases: {quoted(wrong[0])} is not like tire_01")
    return about


def read_cases(folder: Path) -> dict[str, Case]:
    """Return the recordings of a folder by name; raises `DataError` if a file is missing or is none of these."""
    names = read_about(folder)["cases"]
    return {
        name: Case(_json(folder / name / "case.json"), _csv(folder / name / "recording.csv"),
                   _csv(folder / name / "other.csv")) for name in names
    }  # fmt: skip


def write_answer(folder: Path, entry: str, case: str, answer: Answer) -> None:
    """Write an answer into a folder, which is created."""
    folder.mkdir(parents=True, exist_ok=True)
    content = {
        "version": VERSION, "entry": entry, "case": case, "found": list(answer.found),
        "probabilities": {name: round(value, 6) for name, value in answer.probabilities.items()},
        "variables": list(answer.variables), "cpu_seconds": round(answer.cpu_seconds, 3), "failed": answer.failed,
    }  # fmt: skip
    if answer.forces is not None:
        answer.forces.to_csv(folder / f"{case}.csv", index=False, float_format="%.6g")
    (folder / f"{case}.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def read_answer(folder: Path, case: str, channels: list[str], rows: int) -> Answer:
    """Return the answer to a case.

    Raises `DataError` if a file is missing, contradicts the schema, or has not a finite force in each channel and row.
    """
    path = folder / f"{case}.json"
    content = _json(path)
    schema = json.loads((files("missing_effects") / "answer.schema.json").read_text(encoding="utf-8"))
    check_content(content, schema, str(path), DataError)
    if content["case"] != case:
        raise DataError(f"{path}: is the answer to {content['case']}")
    known = {name: content[name] for name in ("probabilities", "cpu_seconds", "failed")}
    answer = Answer(tuple(content["found"]), variables=tuple(content["variables"]), **known)
    if answer.failed:
        return answer
    forces = _csv(path.with_suffix(".csv"))
    if lacking := [name for name in channels if name not in forces]:
        raise DataError(f"{path.with_suffix('.csv')}: no column {lacking[0]}")
    values = forces[channels].apply(pd.to_numeric, errors="coerce")
    if len(values) != rows or not np.isfinite(values.to_numpy(dtype=np.float64)).all():
        raise DataError(f"{path.with_suffix('.csv')}: needs a number in each of {rows} rows of {', '.join(channels)}")
    return Answer(answer.found, variables=answer.variables, forces=values, **known)


def _read(path: Path) -> str:
    try:
        return read_bounded(path, MAX_BYTES).decode()
    except OSError as error:
        raise DataError(f"{path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise DataError(f"{path}: is not UTF-8") from None


def _json(path: Path) -> Any:
    try:
        return json.loads(_read(path))
    except (ValueError, RecursionError) as error:
        raise DataError(f"{path}: is not JSON ({error})") from None


def _csv(path: Path) -> pd.DataFrame:
    try:
        return pd.read_csv(io.StringIO(_read(path)))
    except ValueError as error:
        raise DataError(f"{path}: is not CSV ({error})") from None
