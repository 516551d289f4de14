"""Units, axes and signs that a log does not state, as its numbers show them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from ....boundary.errors import TirefmuError
from ....measurements.files.columns.cells import numbers
from ....measurements.files.columns.content import Column, Content, is_unit, name_and_unit
from ....measurements.files.columns.resolution import unit_at_end
from ....measurements.units import GRAVITY, to_si
from .log_channels import LOG_CHANNELS, NEAR, RADIUS_OF_KMH, UNITS, VERTICAL
from .nearest_channel import OF_A_CAR, is_named, nearest

FloatArray = npt.NDArray[np.float64]
#: A column, its values, and their times; None if the file has none.
Sampled = tuple[Column, FloatArray, FloatArray | None]

#: Gravity by the unit that a file does not state: SI, g, mg.
GRAVITIES = {"": GRAVITY, "g": 1.0, "mg": 1000.0}
#: m: radius of a wheel of a car.
RADIUS = 0.3
#: Share by which a mean may differ from gravity, correlations that show a sign and a cause.
GRAVITY_SHARE, CLEAR, STRONG = 0.2, 0.3, 0.7
#: Channels of a turn, in which ay is speed times yaw rate, and limit of their ratio: the factors of units are further
#: apart, roll and bank of a car are within.
TURN, TURN_GAIN = ("speed", "yaw_rate", "ay"), 0.8


@dataclass(frozen=True)
class Gravity:
    """What the mean of a vertical acceleration shows.

    - `unit`: of the accelerations of its group; empty for SI, and if unknown.
    - `group`: of its column. `down`: whether z points down.
    """

    unit: str = ""
    group: str = ""
    down: bool = False


def gravity_of(content: Content, source: str) -> Gravity:
    """Return what the first vertical acceleration of a log shows."""
    for column in content.columns:
        name = name_and_unit(column.header)[0]
        vertical = any(is_named(name, alias) for alias in VERTICAL)
        values = numbers_of(column, content, source) if vertical else None
        if values is not None and np.isfinite(values).any():
            mean = float(np.nanmean(values))
            for unit, size in GRAVITIES.items():
                if abs(abs(mean) / size - 1.0) < GRAVITY_SHARE:
                    return Gravity(unit, column.group, mean < 0.0)
            return Gravity()
    return Gravity()


def with_unit(column: Column, name: str) -> str:
    """Return how a car file names the column of a channel, with the unit that its name has without brackets."""
    header = f"{column.group}/{column.header}" if column.group and "/" not in column.header else column.header
    if is_unit(column.declared_unit):
        return header
    near = nearest(column)
    unit = near.unit if near.channel == name else unit_at_end(column.header, LOG_CHANNELS[name].quantity)[1]
    return f"{header} [{unit}]" if unit else header


def proposed_text(column: Column, name: str, values: FloatArray, gravity: Gravity) -> str:
    """Return how a car file names a column, with the unit that its numbers suggest if the file states none.

    g cannot be distinguished from a gentle drive in m/s^2, except by the vertical acceleration of the same sensor.
    """
    header = with_unit(column, name)
    if is_unit(name_and_unit(header)[1] or column.declared_unit) or not np.isfinite(values).any():
        return header
    size = float(np.nanquantile(np.abs(values), 0.99))
    if LOG_CHANNELS[name].quantity == "acceleration":
        shown = gravity.unit and gravity.group == column.group and to_si(size, gravity.unit) < LOG_CHANNELS[name].limit
        return f"{header} [{gravity.unit}]" if shown else header
    degrees = {"angle": ("deg", 3.5 if name == "steer" else 1.6), "rotation": ("deg/s", LOG_CHANNELS[name].limit)}
    unit, most = degrees.get(LOG_CHANNELS[name].quantity, ("", np.inf))
    return f"{header} [{unit}]" if size > most and name != "heading" else header


def meant_unit(name: str, units: Sequence[str], speed: str, values: Mapping[str, Sampled]) -> tuple[str, str]:
    """Return which of the units of an ambiguous spelling a rotation has, and why.

    The first one, but for a wheel whose radius follows from the speed. `speed`: how the car file names its column.
    """
    if name not in OF_A_CAR - {"yaw_rate"} or not speed:
        return units[0], f"{units[0]} in most logs, which its numbers do not show"
    radius = _radius(name, speed, values)
    radii = {unit: radius / float(to_si(1.0, unit)) for unit in units}
    nearest = min(units, key=lambda unit: abs(np.log(radii[unit] / RADIUS)))
    return nearest, "wheels of " + " or ".join(f"{radius:.2g} m ({unit})" for unit, radius in radii.items())


def _radius(name: str, speed: str, values: Mapping[str, Sampled]) -> float:
    """Return the radius of a wheel whose spin is in rad/s, m; infinite if it does not turn."""
    column, data, _ = values["speed"]
    unit = name_and_unit(speed)[1] or column.declared_unit
    forward = float(np.nanmedian(np.abs(to_si(data, unit) if is_unit(unit) else data)))
    spin = float(np.nanmedian(np.abs(values[name][1])))
    return forward / spin if spin else np.inf


def speeds_of_rims(proposal: Mapping[str, str], values: Mapping[str, Sampled]) -> str:
    """Return that spins without a unit have the numbers of the speed in m/s or km/h; empty if they have not."""
    for unit, radius in (("m/s", 1.0), ("km/h", RADIUS_OF_KMH)):
        like = [
            name
            for name in LOG_CHANNELS
            if name in OF_A_CAR - {"yaw_rate"} and {name, "speed"} <= values.keys()
            if not _stated_unit(name, proposal, values)
            and abs(_radius(name, proposal["speed"], values) / radius - 1.0) < NEAR
        ]
        if like:
            wheels = f"wheels of {radius:.3g} m in rad/s, or speeds in {unit}, which are not read: state the unit"
            return f"{', '.join(like)}: {wheels}"
    return ""


def _stated_unit(name: str, proposal: Mapping[str, str], values: Mapping[str, Sampled]) -> str:
    """Return the unit of a channel that its file or the proposal states; empty without one."""
    stated = name_and_unit(proposal[name])[1] or values[name][0].declared_unit
    return stated if is_unit(stated) else ""


def turned_as_fast(proposal: dict[str, str], values: Mapping[str, Sampled], named: Collection[str]) -> str:
    """Return that ay is not speed times yaw rate, and propose the units with which it is; empty if it is.

    Units that file or user state are kept. Those of logs differ by factors that the law tells apart.
    """
    if not set(TURN) <= values.keys():
        return ""
    stated = {name: _stated_unit(name, proposal, values) for name in TURN}
    free = {name: ("",) if name in named or stated[name] else UNITS[name] for name in TURN}
    units_read = {name: stated[name] or UNITS[name][0] for name in TURN}
    sampled = _at_the_times(values["yaw_rate"], *(values[name] for name in units_read))
    in_si = {name: to_si(data, unit) for (name, unit), data in zip(units_read.items(), sampled, strict=True)}
    turn, ay = in_si["speed"] * in_si["yaw_rate"], in_si["ay"]
    if abs(turn @ ay) <= STRONG * float(np.sqrt((turn @ turn) * (ay @ ay))):
        return ""
    gain = abs(float(turn @ ay) / float(turn @ turn))
    factors = {}
    for units in product(*free.values()):
        changed = {name: unit for name, unit in zip(free, units, strict=True) if unit and unit != units_read[name]}
        sizes = {name: float(to_si(1.0, changed.get(name, "1"))) for name in TURN}
        factors[sizes["speed"] * sizes["yaw_rate"] / sizes["ay"]] = changed
    factor = min(factors, key=lambda factor: abs(np.log(gain / factor)))
    if not TURN_GAIN < gain / factor < 1.0 / TURN_GAIN:
        return f"ay is {gain:.2g} times speed times yaw rate: another unit of one of them, or another channel?"
    for name, unit in factors[factor].items():
        proposal[name] = f"{proposal[name]} [{unit}]"
    changes = " and ".join(f"{name} in {unit}" for name, unit in factors[factor].items())
    return f"ay is speed times yaw rate with {changes}" if changes else ""


def agreed(proposal: dict[str, str], values: dict[str, Sampled], named: Collection[str]) -> Sequence[str]:
    """Exchange ax and ay, and turn signs, so that steering, yaw rate and lateral acceleration agree.

    In a turn of a car that moves forward all three have one sign: the one that differs from the two others is turned.
    What the user names stays as it is.
    """
    if "yaw_rate" not in values:
        return ["no yaw rate: signs are not compared"]
    notes = []
    common = {name: _correlation(values["yaw_rate"], values[name]) for name in ("steer", "ax", "ay") if name in values}
    swapped = abs(common.get("ax", 0.0)) > STRONG and abs(common.get("ay", 1.0)) < CLEAR
    if swapped and not {"ax", "ay"} & set(named):
        proposal["ax"], proposal["ay"] = proposal["ay"], proposal["ax"]
        common["ax"], common["ay"] = common["ay"], common["ax"]
        notes.append("ax follows the yaw rate and ay does not: they are exchanged")
    signs = {name: -1.0 if proposal[name].startswith("-") else 1.0 for name in ("yaw_rate", *common)}
    agree = {name: np.sign(common[name] * signs[name] * signs["yaw_rate"]) for name in ("steer", "ay")
             if abs(common.get(name, 0.0)) > CLEAR}  # fmt: skip
    wrong = [name for name, sign in agree.items() if sign < 0.0]
    for name in ["yaw_rate"] if len(wrong) == 2 else wrong:
        if name not in named:
            proposal[name] = proposal[name][1:] if signs[name] < 0.0 else f"-{proposal[name]}"
        notes.append(f"{name} has the other sign than the rest{'' if name in named else ': it is turned'}")
    return notes


def _correlation(first: Sampled, second: Sampled) -> float:
    """Return the correlation of two channels about zero; 0 if their samples cannot be compared."""
    x, y = _at_the_times(first, first, second)
    size = float(np.sqrt((x @ x) * (y @ y)))
    return float(x @ y) / size if size else 0.0


def _at_the_times(of: Sampled, *channels: Sampled) -> list[FloatArray]:
    """Return the values of channels at the times of one where all are there; none if they cannot be compared."""
    (_, reference, times) = of
    rows = []
    for _, values, sampled in channels:
        usable = np.isfinite(values)
        if sampled is not None and times is not None and usable.any():
            values = np.interp(times, sampled[usable], values[usable])
        rows.append(values if len(values) == len(reference) else np.full(len(reference), np.nan))
    there = np.isfinite(rows).all(axis=0)
    return [values[there] for values in rows]


def numbers_of(column: Column, content: Content, source: str) -> FloatArray | None:
    """Return the numbers of a column; None for a column of texts."""
    try:
        return numbers(column.cells, source, column.header, content.location)[0]
    except TirefmuError:
        return None
