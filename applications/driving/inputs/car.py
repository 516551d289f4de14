"""The car of a drive: its numbers with uncertainties, read from ``car.toml``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ....boundary.bounded_file import toml_file
from ....boundary.errors import TirefmuError, path_from
from ....boundary.schema_check import check_content
from ....measurements.units import GRAVITY
from .car_entries import ENTRIES, car_schema

FloatArray = npt.NDArray[np.float64]

#: Wheelbase to which default times belong, m.
USUAL_WHEELBASE = 2.7


class CarError(TirefmuError):
    """A car file that cannot be used; the sentence names file, section and key."""


@dataclass(frozen=True)
class Car:
    """A car.

    - `values`, `uncertainties`: of each entry (`car_entries.ENTRIES`), SI units; one standard deviation.
    - `driven`: "front", "rear" or "all".
    - `steering_map`, shape (n, 2), or None: steering channel and angle of the front wheels, rad, before the offset.
    - `columns`: header of the log for each channel that has another name.
    - `source`: the file.

    >>> car = Car.from_content({"body": {"mass": 1500.0}}, "car.toml")
    Traceback (most recent call last):
    ...
    tirefmu.applications.driving.inputs.car.CarError: car.toml: [body] lacks wheelbase: distance of the axles, m
    """

    values: Mapping[str, float]
    uncertainties: Mapping[str, float]
    driven: str = "rear"
    steering_map: FloatArray | None = None
    columns: Mapping[str, str] = field(default_factory=dict)
    source: str = "car"

    @classmethod
    def from_content(cls, content: Mapping[str, Any], source: str) -> Car:
        """Return the car of the content of a car file.

        Raises `CarError` if an entry is missing, unknown, no number or outside its limits.
        """
        check_content(content, car_schema(), source, CarError)
        given = {
            entry.name: _pair(content[entry.section][entry.name])
            for entry in ENTRIES.values()
            if entry.name in content.get(entry.section, {})
        }
        given |= _from_axle_masses(content.get("body", {}), given, source)
        values, uncertainties = {}, {}
        for entry in ENTRIES.values():
            if entry.name not in given and entry.default is None:
                raise CarError(f"{source}: [{entry.section}] lacks {entry.name}: {entry.meaning}, {entry.unit}")
            value, uncertainty = given.get(entry.name, (entry.default, None))
            values[entry.name] = float(value)  # type: ignore[arg-type]  # a default of None was refused
            if entry.scale == "time" and entry.name not in given:
                values[entry.name] *= np.sqrt(values["wheelbase"] / USUAL_WHEELBASE)
            size = abs(values[entry.name])
            scale = {"relative": size, "time": size, "wheelbase": values["wheelbase"]}.get(entry.scale, 1.0)
            uncertainties[entry.name] = entry.uncertainty * scale if uncertainty is None else uncertainty
        if not values["cg_to_front"] < values["wheelbase"]:
            raise CarError(f"{source}: [body] cg_to_front is not less than wheelbase: the load of an axle is negative")
        driven = content.get("wheels", {}).get("driven", "rear")
        return cls(values, uncertainties, driven, _map(content, source), content.get("columns", {}), source)

    @property
    def axle_loads(self) -> tuple[float, float]:
        """Static loads of the front and of the rear axle, N."""
        return loads_of(self.values)


def loads_of(entries: Mapping[str, Any]) -> tuple[Any, Any]:
    """Return the static loads of the axles, N, from entries that are numbers or CasADi expressions."""
    weight = GRAVITY * entries["mass"]
    rear = weight * entries["cg_to_front"] / entries["wheelbase"]
    return weight - rear, rear


def read_car(path: str | Path) -> Car:
    """Return the car of a TOML file.

    Parameters
    ----------
    path : str or Path
        See ``tirefmu drive --example``.

    Returns
    -------
    Car
        With the default uncertainty of each number that has none.

    Raises
    ------
    CarError
        If the file cannot be read, is not TOML, or an entry is missing, unknown or invalid.
    """
    path = path_from(path)
    return Car.from_content(toml_file(path, CarError), str(path))


def _pair(given: float | Mapping[str, float]) -> tuple[float, float | None]:
    """Return value and uncertainty of an entry: a number, or ``{value = ..., uncertainty = ...}``."""
    pair = given if isinstance(given, Mapping) else {"value": given}
    return float(pair["value"]), pair.get("uncertainty")


def _from_axle_masses(
    body: Mapping[str, Any], given: Mapping[str, tuple[float, float | None]], source: str
) -> dict[str, tuple[float, float | None]]:
    """Return mass and position of the center of gravity from the masses on the axles, if the file has those."""
    if not {"front_mass", "rear_mass"} & body.keys():
        return {}
    front, rear = (body.get(name, 0.0) for name in ("front_mass", "rear_mass"))
    if not (front and rear):
        raise CarError(f"{source}: [body] front_mass and rear_mass are two numbers, kg")
    if {"mass", "cg_to_front"} & given.keys() or "wheelbase" not in given:
        raise CarError(f"{source}: [body] front_mass and rear_mass replace mass and cg_to_front, and need wheelbase")
    return {
        "mass": (front + rear, 0.01 * (front + rear)),
        "cg_to_front": (given["wheelbase"][0] * rear / (front + rear), None),
    }


def _map(content: Mapping[str, Any], source: str) -> FloatArray | None:
    """Return the steering map, if the file has one."""
    pairs = content.get("steering", {}).get("map")
    if pairs is None:
        return None
    table = np.array(pairs, dtype=np.float64)
    if not (np.diff(table[:, 0]) > 0.0).all():
        raise CarError(f"{source}: [steering] map is not a list of pairs [channel, angle in rad] with rising channel")
    return table
