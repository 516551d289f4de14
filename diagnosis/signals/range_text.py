"""A range of an input as a reader expects it: with its unit, angles in degrees, pressures in kPa."""

from __future__ import annotations

from math import degrees

from ...symbolic import quantities
from ...symbolic.declarations import Quantity

_UNITS = {quantity.name: quantity.unit for quantity in vars(quantities).values() if isinstance(quantity, Quantity)}
#: By SI unit: the unit of a text, and what turns an SI value into it.
_READABLE = {"rad": ("deg", degrees(1.0)), "Pa": ("kPa", 1e-3), "degC": ("deg C", 1.0), "1": ("", 1.0)}


def range_text(name: str, lower: float, upper: float) -> str:
    """Return a range of an input, or of another quantity without its unit.

    `lower`, `upper`: SI units, deg C.

    >>> range_text("gamma", 0.0, 0.07), range_text("Fz", 794.2, 1090.4), range_text("sweep", 1.0, 2.0)
    ('gamma 0 to 4.01 deg', 'Fz 794 to 1090 N', 'sweep 1 to 2')
    """
    unit = _UNITS.get(name, "1")
    text, factor = _READABLE.get(unit, (unit, 1.0))
    first, last = (f"{_rounded(factor * value):.12g}" for value in (lower, upper))
    return f"{name} {first} to {last} {text}".rstrip()


def _rounded(value: float) -> float:
    """Return a value with three digits, large ones to whole numbers, and 0 for what is hardly different from it."""
    if abs(value) >= 100.0:
        return float(round(value))
    return float(f"{value:.3g}") if abs(value) >= 1e-3 else 0.0
