"""File with the completed stages of a fit, from which an interrupted fit is resumed."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import partial
from math import inf, isfinite, isnan
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from tirefmu.boundary.bounded_file import read_bounded
from tirefmu.boundary.errors import FitError

from ..problem.recipe import Freed
from .records import StageFit

FloatArray = npt.NDArray[np.float64]
T = TypeVar("T")

#: Upper limit of its size, bytes; with 1,000 violated points of each constraint it has 2 MB.
LARGEST = 20_000_000
#: Version of the file format; other versions are rejected.
VERSION = 3


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

    stage: int
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

    done: int = 0
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
        content = {"version": VERSION, "identity": dict(self.identity), **_plain(asdict(state))}
        part = self.path.with_name(f".{self.path.name}.part")
        try:
            part.unlink(missing_ok=True)  # a link would lead elsewhere
            part.write_text(self.sealed(content), encoding="utf-8")
            os.replace(part, self.path)
        except OSError as error:
            part.unlink(missing_ok=True)
            raise FitError(f"{self.path}: cannot be written ({error.strerror or error})") from error

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
        known = before if isinstance(before, dict) else {}
        other = [name for name, value in self.identity.items() if known.get(name) != value]
        if other:
            raise FitError(
                f"{self.path}: belongs to a fit with other {', '.join(other)}: restore them, or run without --resume"
            )
        try:
            return _state(content)
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise FitError(f"{self.path}: invalid progress file ({error!r})") from error


def _plain(value: Any) -> Any:
    """Return JSON values: infinite bounds as strings, arrays as lists."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, float) and abs(value) == inf:
        return str(value)
    return value.item() if isinstance(value, np.generic) else value


def _digest(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _state(content: Mapping[str, Any]) -> FitState:
    """Return the state from JSON; raise KeyError, TypeError or ValueError if it is invalid."""
    return FitState(
        done=_count(content["done"]),
        values=_values(content["values"]),
        freed={name: _release(_of(dict, item)) for name, item in _of(dict, content["freed"]).items()},
        violated=[(_of(str, name), _array(points, 2)) for name, points in _of(list, content["violated"])],
        stages=[_stage(item) for item in _of(list, content["stages"])],
        ended=[_ended(_of(dict, item)) for item in _of(list, content["ended"])],
        notes=[_of(str, note) for note in _of(list, content["notes"])],
    )


def _release(item: Mapping[str, Any]) -> Release:
    return Release(_freed(item["bounds"]), _of(str, item["stage"]), _of(bool, item["determined"]))


def _ended(item: Mapping[str, Any]) -> Ended:
    free = {name: _freed(bounds) for name, bounds in _of(dict, item["free"]).items()}
    return Ended(_count(item["stage"]), _values(item["values"]), free, _array(item["x"], 1))


def _of(kind: type[T], value: Any) -> T:
    """Return a value if it has the required type."""
    if not isinstance(value, kind):
        raise TypeError(f"{value!r} is not of type {kind.__name__}")
    return value


def _count(value: Any) -> int:
    if isinstance(value, bool) or _of(int, value) < 0:
        raise TypeError(f"{value!r} is not a count")
    return int(value)


def _number(value: Any) -> float:
    """Return a number, or an infinity from its string; NaN is invalid."""
    if isinstance(value, bool) or (isinstance(value, str) and value not in ("inf", "-inf")):
        raise TypeError(f"{value!r} is not a number")
    number = float(value)
    if isnan(number):
        raise ValueError("nan is not a number")
    return number


def _values(given: Any) -> dict[str, float]:
    values = {name: _number(value) for name, value in _of(dict, given).items()}
    if not all(map(isfinite, values.values())):
        raise ValueError("a coefficient is not finite")
    return values


def _stage(item: Any) -> StageFit:
    kinds: dict[str, Callable[[Any], Any]] = {"str": partial(_of, str), "int": _count,
                                              "bool": partial(_of, bool), "float": _number}  # fmt: skip
    return StageFit(
        **{record.name: kinds[str(record.type)](_of(dict, item)[record.name]) for record in fields(StageFit)}
    )


def _freed(item: Any) -> Freed:
    guess, lower, upper = (_number(_of(dict, item)[key]) for key in ("guess", "lower", "upper"))
    if not (isfinite(guess) and lower <= upper):
        raise ValueError(f"{guess:g} and {lower:g} to {upper:g} are no guess and no bounds")
    return Freed(guess, lower, upper)


def _array(numbers: Any, dimensions: int) -> FloatArray:
    array = np.array(numbers, dtype=np.float64)
    if array.ndim != dimensions or not np.isfinite(array).all():
        raise ValueError(f"{numbers!r} is not an array of {dimensions} dimensions")
    return array
