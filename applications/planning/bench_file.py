"""What a test bench can do: ranges and rates of the inputs, times for changes, heat, noise; a TOML file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from importlib.resources import files
from math import inf, isfinite
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...boundary.bounded_file import toml_file
from ...boundary.errors import DataError, TirefmuError, UnknownName, path_from
from ...boundary.escaping import quoted
from ...boundary.json_schema import document, object_schema
from ...boundary.schema_check import check_content
from ...measurements import ChannelNoise, Noise
from ...measurements.units import to_si
from ...symbolic.channels import CHANNELS

#: The inputs that a bench sets, and those that it sweeps.
INPUTS, SWEPT = ("kappa", "alpha", "gamma", "Fz", "p", "V"), ("kappa", "alpha")
#: Numbers with the unit of their channel: a text may state another one. The ends of a range may be negative.
WITH_UNITS, ENDS = ("low", "high", "rate", "constant", "offset", "drift", "step"), ("low", "high")
#: The schema of a number that is not negative.
POSITIVE = {"type": "number", "minimum": 0}
#: Numbers of the file that are in no table, and those of the table [noise].
SETTINGS, NOISE = ("sample_rate", "warm_up", "repeat_every"), ("correlation_time", "drift_period")
#: Largest load of the default noise, N (`Noise.scaled`).
NOISE_LOAD = 3000.0


class PlanError(TirefmuError):
    """A program that cannot be planned: a bench file with errors, or a bench that cannot do what is required."""


@dataclass(frozen=True)
class Limits:
    """What the bench does with an input, in SI units.

    - `low`, `high`: the range.
    - `change`: seconds for a change to another level.
    - `rate`: largest rate of a sweep, per second; 0: the input is held during a sweep.
    - `levels`: number of levels that a program may use.
    """

    low: float
    high: float
    change: float = 2.0
    rate: float = 0.0
    levels: int = 3

    @property
    def sweeps(self) -> bool:
        """Whether a program may sweep the input."""
        return self.rate > 0.0 and self.high > self.low

    def level_values(self, most: int = 100) -> list[float]:
        """Return the levels, from low to high, at most some of them.

        >>> Limits(0.0, 2.0, levels=3).level_values(), Limits(5.0, 5.0).level_values()
        ([0.0, 1.0, 2.0], [5.0])
        """
        count = 1 if self.low == self.high else min(self.levels, most)
        return [float(level) for level in np.linspace(self.low, self.high, count)]


@dataclass(frozen=True)
class Heat:
    """Limits of the sliding power: what the tread loses, W, and the energies of a sweep and of a program, J."""

    cooling: float = inf
    energy_of_a_sweep: float = inf
    energy: float = inf


@dataclass(frozen=True)
class Bench:
    """A test bench.

    - `limits`: by input; an absent one is held at the nominal value of the tire.
    - `noise`: of inputs and outputs. `heat`: limits of the sliding power. `name`: for texts.
    - `sample_rate`: rows per second.
    - `warm_up`, `repeat_every`: s before the first sweep; s after which it is repeated, 0 for never.
    """

    limits: Mapping[str, Limits]
    noise: Noise = field(default_factory=Noise)
    heat: Heat = Heat()
    name: str = "bench"
    sample_rate: float = 50.0
    warm_up: float = 0.0
    repeat_every: float = 0.0


def example_text() -> str:
    """Return a commented bench file.

    >>> example_text().splitlines()[1]
    'name = "flat-track bench"'
    """
    return (files(__package__) / "bench_example.toml").read_text(encoding="utf-8")


def read_bench(path: str | Path) -> Bench:
    """Return the bench of a TOML file such as that of `example_text`.

    Raises `PlanError` if the file cannot be read, or a key is unknown, or a value is missing or impossible.

    >>> Path("bench.toml").write_text(example_text()) > 0
    True
    >>> round(read_bench("bench.toml").limits["alpha"].high, 3)
    0.209
    """
    path = path_from(path)
    content = toml_file(path, PlanError)
    check_content(content, bench_schema(), str(path), PlanError)
    limits = {key: _limits(content[key], key, str(path)) for key in INPUTS if key in content}
    heat = Heat(**content.get("heat", {}))
    largest = limits["Fz"].high if "Fz" in limits else NOISE_LOAD
    noise = _noise(content.get("noise", {}), largest / NOISE_LOAD, str(path))
    settings = {key: float(content[key]) for key in SETTINGS if key in content}
    if "Fz" in limits and limits["Fz"].low <= 0.0:
        raise PlanError(f"{path}: [Fz] low has to be positive: a lifted wheel has no forces")
    if heat != Heat() and "V" not in limits:
        raise PlanError(f"{path}: [heat] needs the speed, a table [V]")
    if not any(key in limits and limits[key].sweeps for key in SWEPT):
        raise PlanError(f"{path}: no slip is swept: [alpha] or [kappa] needs a range and a positive rate")
    return Bench(limits, noise, heat, content.get("name", path.stem), **settings)


def bench_schema() -> dict[str, Any]:
    """Return the JSON Schema of a bench file."""
    limits = {**_schemas(Limits), "levels": Annotated[int, {"minimum": 2}]}
    noise = dict.fromkeys(CHANNELS, object_schema(_schemas(ChannelNoise)))
    content = {
        "name": str,
        "sample_rate": Annotated[float, "rows per second", {"exclusiveMinimum": 0}],
        "warm_up": POSITIVE,
        "repeat_every": POSITIVE,
        **dict.fromkeys(INPUTS, object_schema(limits, ENDS)),
        "heat": object_schema(_schemas(Heat)),
        "noise": object_schema(
            {"correlation_time": POSITIVE, "drift_period": {"type": "number", "exclusiveMinimum": 0}, **noise}
        ),
    }
    return document("bench", "1.0", "Test bench", object_schema(content))


def _schemas(kind: type[Any]) -> dict[str, Any]:
    """Return the schemas of the numbers of a class."""
    names = [part.name for part in fields(kind)]
    numbers = {name: {"type": "number"} if name in ENDS else POSITIVE for name in names}
    return {
        name: {"anyOf": [number, {"type": "string"}]} if name in WITH_UNITS else number
        for name, number in numbers.items()
    }


def _limits(table: Mapping[str, Any], key: str, source: str) -> Limits:
    limits = Limits(**_in_si(table, key, f"{source}: {key}"))
    if limits.low > limits.high:
        raise PlanError(f"{source}: {key}.low is above high")
    if key in SWEPT and not limits.low <= 0.0 <= limits.high:
        raise PlanError(f"{source}: {key}: 0 has to be within low and high")
    return limits


def _noise(table: Mapping[str, Any], factor: float, source: str) -> Noise:
    channels = dict(Noise().scaled(factor).channels)
    for name in channels.keys() & table.keys():
        channels[name] = ChannelNoise(**_in_si(table[name], name, f"{source}: noise.{name}"))
    return Noise(channels, **{name: float(table[name]) for name in NOISE if name in table})


def _in_si(table: Mapping[str, Any], channel: str, place: str) -> dict[str, Any]:
    """Return the numbers of a table; a text has a unit of the channel."""
    return {
        key: _number(value, f"{place}.{key}", CHANNELS[channel].quantity, signed=key in ENDS)
        if isinstance(value, str)
        else value
        for key, value in table.items()
    }


def _number(text: str, place: str, quantity: str, *, signed: bool) -> float:
    number, _, unit = text.strip().partition(" ")
    try:
        value = float(to_si(float(number), unit, quantity))
    except (ValueError, DataError, UnknownName) as error:
        reason = error if isinstance(error, TirefmuError) else "it has to be a number and a unit, such as '12 deg'"
        raise PlanError(f"{place} is {quoted(text)}: {reason}") from None
    if not isfinite(value) or (value < 0.0 and not signed):
        raise PlanError(f"{place} is {quoted(text)}: expected a finite number{'' if signed else ' of at least 0'}")
    return value
