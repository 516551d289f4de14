"""Words and units of figures, tables and messages: SI units, but degrees for angles, kPa for pressures, deg C."""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from ..symbolic.channels import CHANNELS
from ..symbolic.quantities import DISTANCE

Numbers = TypeVar("Numbers", float, npt.NDArray[np.float64])
#: SI units: of the channels, and of the input that is none.
_UNITS = {DISTANCE.name: DISTANCE.unit} | {name: declared.unit for name, declared in CHANNELS.items()}
_DRAWN = {"rad": ("deg", degrees(1.0)), "Pa": ("kPa", 1e-3), "K": ("deg C", 1.0), "1": ("-", 1.0)}
#: The temperature that is drawn as 0, K.
ZERO_CELSIUS = 273.15
_GREEK = {"kappa": "κ", "alpha": "α", "gamma": "γ", "phit": "φt"}
#: The name of the levels of a channel.
LEVEL = {"Fz": "load", "gamma": "camber", "p": "pressure", "V": "speed"}
LEVEL |= {"alpha": "slip angle", "kappa": "longitudinal slip"}
_CONVENTION = {
    "iso": "ISO-W signs (Fz > 0; Fy < 0 at α > 0)",
    "adapted-sae": "adapted SAE signs (Fz > 0; Fy > 0 at α > 0)",
    "sae": "SAE signs (Fz < 0; Fy < 0 at α > 0)",
}


def drawn_unit(channel: str) -> str:
    """Return the unit in which a channel is drawn: its SI unit, but degrees, kPa and deg C."""
    unit = _UNITS[channel]
    return _DRAWN[unit][0] if unit in _DRAWN else unit


def per_si(channel: str) -> float:
    """Return the factor from a change of a channel's SI value to that of its drawn value."""
    unit = _UNITS[channel]
    return _DRAWN[unit][1] if unit in _DRAWN else 1.0


def drawn_value(channel: str, value: Numbers) -> Numbers:
    """Return an SI value of a channel in its drawn unit.

    >>> drawn_value("T_road", 310.15), drawn_value("p", 83e3)
    (37.0, 83.0)
    """
    return (value - (ZERO_CELSIUS if _UNITS[channel] == "K" else 0.0)) * per_si(channel)


def stiffness_unit(slip: str) -> str:
    """Return the unit of a force's slope over a slip: that of the named quantities, also where angles are in deg."""
    return "N/rad" if _UNITS[slip] == "rad" else "N"


def letter(channel: str, signs: str = "iso") -> str:
    """Return a channel's letter; the sign of a load is such that a loaded tire has a positive value.

    >>> letter("Fy"), letter("alpha"), letter("Fz", "sae")
    ('Fy', 'α', '-Fz')
    """
    return "-Fz" if channel == "Fz" and signs == "sae" else _GREEK.get(channel, channel)


def axis_label(channel: str, signs: str = "iso") -> str:
    """Return a channel's letter and the unit in which it is drawn.

    >>> axis_label("alpha"), axis_label("kappa"), axis_label("Fy")
    ('α (deg)', 'κ (-)', 'Fy (N)')
    """
    return f"{letter(channel, signs)} ({drawn_unit(channel)})"


def level_text(channel: str, level: float) -> str:
    """Return a level in its drawn unit; loads by magnitude.

    >>> level_text("Fz", -220.4), level_text("gamma", 0.0349), level_text("kappa", -0.2251)
    ('220 N', '2 deg', '-0.225')
    """
    if channel == "Fz":
        return f"{abs(level):.0f} N"
    if drawn_unit(channel) == "-":
        return f"{round(level, 3) + 0.0:g}"
    return f"{round(drawn_value(channel, level), 1) + 0.0:.3g} {drawn_unit(channel)}"  # + 0.0: no -0


def range_text(channel: str, lower: float, upper: float) -> str:
    """Return a range of an input in its drawn unit, with three digits.

    `lower`, `upper`: SI units, deg C. What is hardly different from 0 is 0.

    >>> range_text("gamma", 0.0, 0.07), range_text("Fz", 794.2, 1090.4), range_text("kappa", 1e-5, 0.2)
    ('gamma 0 to 4.01 deg', 'Fz 794 to 1090 N', 'kappa 0 to 0.2')
    """
    values = [per_si(channel) * value for value in (lower, upper)]
    first, last = (
        f"{round(value)}" if abs(value) >= 100.0 else f"{value if abs(value) >= 1e-3 else 0.0:.3g}" for value in values
    )
    return f"{channel} {first} to {last} {drawn_unit(channel).strip('-')}".rstrip()


def held_text(signs: str, held: Mapping[str, float]) -> str:
    """Return the constant channels and their levels."""
    return ", ".join(f"{letter(name, signs)} = {level_text(name, level)}" for name, level in held.items())


def note(signs: str, *parts: str) -> str:
    """Return the note below a figure: the sign convention and further parts.

    >>> note("iso", "points: data")
    'ISO-W signs (Fz > 0; Fy < 0 at α > 0); points: data'
    """
    return "; ".join([_CONVENTION[signs], *parts])
