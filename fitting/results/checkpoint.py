"""File with the completed stages of a fit, from which an interrupted fit is resumed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, nan
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...boundary.bounded_file import read_bounded
from ...boundary.errors import FitError, writing
from ...boundary.json_schema import json_value, schema_of
from ...boundary.schema_check import check_content
from ...boundary.whole_file import write_whole
from ...numerics.arrays import FloatArray
from ..problem.recipe import Freed
from .records import StageFit

Count = Annotated[int, {"minimum": 0}]

#: Upper limit of its size, bytes; with 1,000 violated points of each constraint it has 2 MB.
LARGEST = 20_000_000
#: Version of the file format; other versions are rejected.
VERSION = 4


@dataclass(frozen=True)
class Release:
    """A freed coefficient: its first guess and last bounds, the last stage that determined it, whether one did."""

    bounds: Freed
    stage: str
    determined: bool


@dataclass(frozen=True)
class Ended:
    """The end of a stage that used all of its rows: the information required to set up its problem again.

    - `stage`: its index in the recipe.
    - `values`: coefficients of the tire before the stage.
    - `x`, shape (n_free,): scaled free values of the solution.
    """

    stage: Count
    values: dict[str, float]
    free: dict[str, Freed]
    x: FloatArray


@dataclass
class FitState:
    """A fit between two stages.

    - `done`: number of completed stages.
    - `values`: coefficients of the tire so far, in adapted SAE.
    - `violated`, shape (n_inputs, n_points): constraints by name, with the points that verification added.
    """

    done: Count = 0
    values: dict[str, float] = field(default_factory=dict)
    freed: dict[str, Release] = field(default_factory=dict)
    violated: list[tuple[str, FloatArray]] = field(default_factory=list)
    stages: list[StageFit] = field(default_factory=list)
    ended: list[Ended] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Checkpoint:
    """The file of the completed stages of a fit.

    `identity`: inputs of the fit by the names that a user knows (data, model, recipe, ...); see
    `measurements.provenance`.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     checkpoint = Checkpoint(Path(folder) / "tire.progress.json", {"model": "mf96"})
    ...     checkpoint.save(FitState(done=2, values={"PDY1": 0.1 + 0.2}))
    ...     checkpoint.load().values
    {'PDY1': 0.30000000000000004}
    """

    path: Path
    identity: Mapping[str, str]

    def save(self, state: FitState) -> None:
        """Write the state; the file is complete or not written.

        Raises `FitError` if the file cannot be written.
        """
        content = {"version": VERSION, "identity": dict(self.identity), "state": json_value(state)}
        with writing(self.path, FitError):
            write_whole(self.path, self.sealed(content).encode())

    @staticmethod
    def sealed(content: Mapping[str, Any]) -> str:
        """Return the text of the file: JSON with a digest that detects changes."""
        bare = {key: value for key, value in content.items() if key != "digest"}
        return json.dumps({**bare, "digest": _digest(bare)})

    def load(self) -> FitState:
        """Return the saved state.

        Raises `FitError` if the file does not exist, is invalid, or belongs to a fit of other data or options. The
        message states which.
        """
        try:
            content = json.loads(read_bounded(self.path, LARGEST))
        except FileNotFoundError:
            raise FitError(f"{self.path}: no such file: there is no interrupted fit to resume") from None
        except OSError as error:
            raise FitError(f"{self.path}: cannot be read ({error.strerror or error})") from error
        except (ValueError, RecursionError) as error:  # no JSON, or no text
            raise FitError(f"{self.path}: not a progress file ({error})") from error
        if not isinstance(content, dict) or content.get("version") != VERSION:
            raise FitError(f"{self.path}: not a progress file of this version of tirefmu")
        if content.pop("digest", None) != _digest(content):
            raise FitError(f"{self.path}: invalid progress file (it was changed after it was written)")
        before = content.get("identity")
        identity = before if isinstance(before, dict) else {}
        other = [name for name, value in self.identity.items() if identity.get(name) != value]
        if other:
            raise FitError(
                f"{self.path}: belongs to a fit with other {', '.join(other)}: restore them, or run without --resume"
            )
        source = f"{self.path}: invalid progress file"
        check_content(content.get("state"), schema_of(FitState, missing=True), source, FitError)
        try:
            return _state(content["state"])
        except (TypeError, ValueError) as error:
            raise FitError(f"{source}: {error}") from error


def _digest(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _state(content: Mapping[str, Any]) -> FitState:
    """Return the state from JSON that satisfies its schema; raise TypeError or ValueError for impossible numbers."""
    return FitState(
        done=content["done"],
        values=_values(content["values"]),
        freed={
            name: Release(_freed(item["bounds"]), item["stage"], item["determined"])
            for name, item in content["freed"].items()
        },
        violated=[(name, _array(points, 2)) for name, points in content["violated"]],
        stages=[_stage(item) for item in content["stages"]],
        ended=[
            Ended(
                item["stage"],
                _values(item["values"]),
                {name: _freed(bounds) for name, bounds in item["free"].items()},
                _array(item["x"], 1),
            )
            for item in content["ended"]
        ],
        notes=content["notes"],
    )


def _stage(item: Mapping[str, Any]) -> StageFit:
    values: dict[str, Any] = {key: nan if value is None else value for key, value in item.items()}  # null: not finite
    return StageFit(**values)


def _values(given: Mapping[str, Any]) -> dict[str, float]:
    return {name: float(value) for name, value in given.items()}


def _freed(item: Mapping[str, Any]) -> Freed:
    """Return guess and bounds; an infinite bound is null in JSON."""
    guess = float(item["guess"])
    lower, upper = (
        other if item[key] is None else float(item[key]) for key, other in (("lower", -inf), ("upper", inf))
    )
    if lower > upper:
        raise ValueError(f"{lower:g} to {upper:g} are no bounds")
    return Freed(guess, lower, upper)


def _array(numbers: Any, dimensions: int) -> FloatArray:
    array = np.array(numbers, dtype=np.float64)
    if array.ndim != dimensions or not np.isfinite(array).all():
        raise ValueError(f"not an array of {dimensions} dimensions")
    return array
