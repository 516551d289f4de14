"""What a test bench can do: ranges and rates of the inputs, times for changes, heat, noise; a TOML file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from importlib.resources import files
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np

from tirefmu.boundary.bounded_file import toml_file
from tirefmu.boundary.errors import DataError, TirefmuError, UnknownName, path_from
from tirefmu.boundary.escaping import quoted
from tirefmu.boundary.json_schema import document, object_schema
from tirefmu.measurements import Noise
from tirefmu.measurements.channels import CHANNELS
from tirefmu.measurements.units import to_si
from tirefmu.measurements.virtual_bench.sensor_noise import ChannelNoise

#: The inputs that a bench sets, and those that it sweeps.
INPUTS, SWEPT = ("kappa", "alpha", "gamma", "Fz", "p", "V"), ("kappa", "alpha")
#: Numbers of limits and noise that have the unit of their channel: a text may state another one.
WITH_UNITS = ("low", "high", "rate", "constant", "offset", "drift", "step")
#: The ends of a range: required, and the only numbers that may be negative.
ENDS = ("low", "high")
#: Numbers of the file that are in no table.
SETTINGS = ("sample_rate", "warm_up", "repeat_every")
#: Numbers of the table [noise].
NOISE = ("correlation_time", "drift_period")
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

    def level_values(self) -> list[float]:
        """Return the levels, from low to high.

        >>> Limits(0.0, 2.0, levels=3).level_values(), Limits(5.0, 5.0).level_values()
        ([0.0, 1.0, 2.0], [5.0])
        """
        return [self.low] if self.low == self.high else np.linspace(self.low, self.high, self.levels).tolist()


@dataclass(frozen=True)
class Heat:
    """Limits of the sliding power: what the tread loses, W, and the energies of a sweep and of a program, J."""

    cooling: float = inf
    energy_of_a_sweep: float = inf
    energy: float = inf


@dataclass(frozen=True)
class Bench:
    """A test bench.

    Attributes
    ----------
    limits : mapping of str to Limits
        By input; an absent one is held at the nominal value of the tire.
    noise : Noise
        Of inputs and outputs.
    heat : Heat
        Limits of the sliding power.
    name : str
        For texts.
    sample_rate : float, Hz
        Rows per second.
    warm_up, repeat_every : float, s
        Before the first sweep; time after which the first sweep is repeated, 0 for never.
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
    """Read a bench file.

    Parameters
    ----------
    path : str or Path
        A TOML file such as that of `example_text`.

    Returns
    -------
    Bench

    Raises
    ------
    PlanError
        If the file cannot be read, or a value is missing or impossible; the message names file and key.
    UnknownName
        If a key or a unit does not exist.

    Examples
    --------
    >>> Path("bench.toml").write_text(example_text()) > 0
    True
    >>> round(read_bench("bench.toml").limits["alpha"].high, 3)
    0.209
    """
    path = path_from(path)
    content = toml_file(path, PlanError)
    plain = {name: content.pop(name) for name in SETTINGS if name in content}
    name = content.pop("name", path.stem)
    for key, value in content.items():
        if key not in (*INPUTS, "heat", "noise"):
            raise UnknownName(f"key of {path}", key, (*INPUTS, "heat", "noise", "name", *SETTINGS))
        if not isinstance(value, dict):
            raise PlanError(f"{path}: {key} has to be a table [{key}]")
    limits = {key: _limits(content[key], key, f"{path}: [{key}]") for key in INPUTS if key in content}
    settings = {key: _number(value, f"{path}: {key}") for key, value in plain.items()}
    if settings.get("sample_rate", 1.0) <= 0.0:
        raise PlanError(f"{path}: sample_rate has to be positive")
    heat = Heat(**_numbers(content.get("heat", {}), _names(Heat), f"{path}: [heat]"))
    largest = limits["Fz"].high if "Fz" in limits else NOISE_LOAD
    noise = _noise(content.get("noise", {}), largest / NOISE_LOAD, f"{path}: [noise")
    if "Fz" in limits and limits["Fz"].low <= 0.0:
        raise PlanError(f"{path}: [Fz] low has to be positive: a lifted wheel has no forces")
    if heat != Heat() and "V" not in limits:
        raise PlanError(f"{path}: [heat] needs the speed, a table [V]")
    if not any(key in limits and limits[key].rate > 0.0 for key in SWEPT):
        raise PlanError(f"{path}: no slip is swept: [alpha] or [kappa] needs low, high and a positive rate")
    return Bench(limits, noise, heat, str(name), **settings)


def bench_schema() -> dict[str, Any]:
    """Return the JSON Schema of a bench file."""
    noise = dict.fromkeys(CHANNELS, object_schema(_number_schemas(_names(ChannelNoise))))
    content = {
        "name": Any,
        **_number_schemas(SETTINGS),
        **dict.fromkeys(INPUTS, object_schema(_number_schemas(_names(Limits)), ENDS)),
        "heat": object_schema(_number_schemas(_names(Heat))),
        "noise": object_schema({**_number_schemas(NOISE), **noise}),
    }
    return document("bench", "1.0", "Test bench", object_schema(content))


def _number_schemas(names: Iterable[str]) -> dict[str, Any]:
    """Return the schemas of numbers as `_number` accepts them."""
    signed = {name: {"type": "number"} if name in ENDS else {"type": "number", "minimum": 0} for name in names}
    return {name: {"anyOf": [one, {"type": "string"}]} if name in WITH_UNITS else one for name, one in signed.items()}


def _names(kind: type[Any]) -> tuple[str, ...]:
    return tuple(part.name for part in fields(kind))


def _limits(table: Mapping[str, Any], key: str, where: str) -> Limits:
    values = _numbers(table, _names(Limits), where, CHANNELS[key].quantity)
    for end in ENDS:
        if end not in values:
            raise PlanError(f"{where} has no {end}")
    if values["low"] > values["high"]:
        raise PlanError(f"{where} low is above high")
    if (key in SWEPT and values["low"] > 0.0) or (key in SWEPT and values["high"] < 0.0):
        raise PlanError(f"{where}: 0 has to be within low and high")
    levels = values.pop("levels", 3.0)
    if levels < 2 or levels != int(levels):
        raise PlanError(f"{where} levels has to be a whole number of at least 2")
    return Limits(**values, levels=int(levels))


def _noise(table: Mapping[str, Any], factor: float, where: str) -> Noise:
    channels = dict(Noise().scaled(factor).channels)
    plain = {key: value for key, value in table.items() if not isinstance(value, dict)}
    settings = _numbers(plain, NOISE, f"{where}]")
    for name, content in table.items():
        if isinstance(content, dict):
            if name not in CHANNELS:
                raise UnknownName(f"channel of {where}]", name, CHANNELS)
            values = _numbers(content, _names(ChannelNoise), f"{where}.{name}]", CHANNELS[name].quantity)
            channels[name] = ChannelNoise(**values)
    try:
        return Noise(channels, **settings)
    except DataError as error:
        raise PlanError(f"{where}]: {error}") from None


def _numbers(table: Mapping[str, Any], names: tuple[str, ...], where: str, quantity: str = "") -> dict[str, float]:
    """Return the numbers of a table; a text has a unit of the quantity."""
    for key in table:
        if key not in names:
            raise UnknownName(f"key of {where}", key, names)
    return {
        key: _number(value, f"{where} {key}", quantity if key in WITH_UNITS else "") for key, value in table.items()
    }


def _number(value: Any, where: str, quantity: str = "") -> float:
    if isinstance(value, str) and quantity:
        number, _, unit = value.strip().partition(" ")
        try:
            return _number(float(to_si(float(number), unit, quantity)), where)
        except (ValueError, DataError, UnknownName) as error:
            reason = error if isinstance(error, TirefmuError) else "it has to be a number and a unit, such as '12 deg'"
            raise PlanError(f"{where} = {quoted(value)}: {reason}") from None
    signed = where.endswith(tuple(f" {name}" for name in ENDS))
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise PlanError(f"{where} = {quoted(value)}: it has to be a finite number")
    if value < 0.0 and not signed:
        raise PlanError(f"{where} = {quoted(value)}: it has to be 0 or more")
    return float(value)
