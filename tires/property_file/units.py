"""The [UNITS] of .tir files: the spellings and their conversion of values.

A unit system is declared by LENGTH, FORCE, ANGLE, MASS, TIME and, in some files, PRESSURE; Pa if that is missing. The
spellings are those of the Adams and Ansys manuals and of files in use. As in other readers, units apply to values with
a dimension outside the Magic Formula: sizes, loads, stiffnesses, speeds, pressures, and the ranges of the inputs. The
coefficients of a section ``..._COEFFICIENTS`` never change: their radians are part of the formula, as are radians
within another unit (N/rad), unless the model's property file declares them (`per_angle`).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import pi

_POUND, _POUND_FORCE, _GRAVITY, _INCH, _PSI = 0.45359237, 4.4482216152605, 9.80665, 0.0254, 6894.757293168361


def _spelled(table: Mapping[str, float]) -> dict[str, float]:
    return {_folded(spelling): factor for spellings, factor in table.items() for spelling in spellings.split()}


def _folded(spelling: str) -> str:
    return re.sub(r"[\s_.-]", "", spelling.casefold())


#: Factor to SI by unit key and folded spelling.
UNITS: dict[str, dict[str, float]] = {
    "LENGTH": _spelled(
        {
            "m meter meters metre metres": 1.0,
            "mm millimeter millimeters millimetre millimetres": 1e-3,
            "cm centimeter centimeters centimetre centimetres": 1e-2,
            "km kilometer kilometers kilometre kilometres": 1e3,
            "um micrometer micrometers": 1e-6,
            "in inch inches": _INCH,
            "ft foot feet": 12 * _INCH,
            "mi mile miles": 63360 * _INCH,
        }
    ),
    "FORCE": _spelled(
        {
            "n newton newtons": 1.0,
            "kn knewton kilonewton kilonewtons": 1e3,
            "dan": 10.0,
            "dyn dyne": 1e-5,
            "lbf lb lbs pound_force pound pounds": _POUND_FORCE,
            "kpound_force klbf kip": 1e3 * _POUND_FORCE,
            "ounce_force ozf": _POUND_FORCE / 16,
            "kgf kg_force kilogram_force kp": _GRAVITY,
        }
    ),
    "ANGLE": _spelled({"rad radian radians": 1.0, "deg degree degrees": pi / 180}),
    "MASS": _spelled(
        {
            "kg kilogram kilograms": 1.0,
            "g gram grams": 1e-3,
            "mg milligram": 1e-6,
            "t ton tonne": 1e3,
            "lb lbs lbm pound pounds pound_mass": _POUND,
            "kpound_mass": 1e3 * _POUND,
            "ounce_mass ozm oz": _POUND / 16,
            "slug slugs": _POUND_FORCE / (12 * _INCH),
        }
    ),
    "TIME": _spelled(
        {
            "s sec second seconds": 1.0,
            "ms milli millisecond milliseconds": 1e-3,
            "min minute minutes": 60.0,
            "h hour hours": 3600.0,
        }
    ),
    "PRESSURE": _spelled(
        {
            "pa pascal pascals n/m^2 n/m2": 1.0,
            "hpa mbar millibar": 1e2,
            "kpa kpascal kilopascal": 1e3,
            "mpa mpascal megapascal n/mm^2 n/mm2": 1e6,
            "bar": 1e5,
            "psi": _PSI,
            "ksi": 1e3 * _PSI,
        }
    ),
}
#: The names of units in a file of tirefmu.
WRITTEN = {"LENGTH": "meter", "FORCE": "newton", "ANGLE": "radians", "MASS": "kg", "TIME": "second"}
#: SI symbols in a unit, and the unit key that applies to them.
_RULED_BY = {"m": "LENGTH", "N": "FORCE", "rad": "ANGLE", "kg": "MASS", "s": "TIME", "Pa": "PRESSURE"}
_SYMBOL = re.compile(r"([A-Za-z]+)(?:\^(\d))?")


def unit_factor(key: str, spelling: str) -> float | None:
    """Return the factor from a unit to SI, or None for an unknown spelling.

    >>> unit_factor("FORCE", "POUND_FORCE"), unit_factor("LENGTH", "parsec")
    (4.4482216152605, None)
    """
    return UNITS[key].get(_folded(spelling))


def factor_of(unit: str, factors: Mapping[str, float], *, per_angle: bool = False) -> float:
    """Return the factor to SI of a value with an SI unit, written in a file's units.

    `unit`: unit of a declaration: "N/m", "kg m^2", "rad", "1". `factors`: the file's units by key; SI if one is
    missing. `per_angle`: whether ANGLE also applies within another unit.

    >>> factor_of("N/m", {"LENGTH": 1e-3}), factor_of("rad", {"ANGLE": 0.5}), factor_of("N/rad", {"ANGLE": 0.5})
    (1000.0, 0.5, 1.0)
    >>> factor_of("N/rad", {"ANGLE": 0.5}, per_angle=True)
    2.0
    """
    if unit == "rad":
        return factors.get("ANGLE", 1.0)
    applied = factors if per_angle else {**factors, "ANGLE": 1.0}
    above, _, below = unit.partition("/")
    return _product(above, applied) / _product(below, applied)


def unit_contradicts(word: str, factor: float) -> bool:
    """Return whether the word behind a number is a unit other than the one that the file declares.

    `factor`: conversion of the number by the file's units.

    >>> unit_contradicts("kN", 1.0), unit_contradicts("N", 1.0), unit_contradicts("(N/mm)", 1.0)
    (True, False, True)
    >>> unit_contradicts("mm", 1e-3), unit_contradicts("nominal", 1.0)
    (False, False)
    """
    parts = [_folded(part) for part in re.findall(r"[A-Za-z_]+", word)]
    meanings = [{table[part] for table in UNITS.values() if part in table} for part in parts]
    if not meanings or not all(meanings):
        return False
    return factor not in meanings[0] if len(meanings) == 1 else factor != 1.0 or not all(1.0 in f for f in meanings)


def _product(units: str, factors: Mapping[str, float]) -> float:
    product = 1.0
    for symbol, power in _SYMBOL.findall(units):
        product *= factors.get(_RULED_BY[symbol], 1.0) ** int(power or 1)
    return product
