"""Units in bench files and table headers, and their conversion to SI units."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..boundary.errors import DataError, UnknownName
from ..numerics.arrays import FloatArray

PSI = 6894.757293168361  # Pa, from the pound-force and the inch
POUND = 4.4482216152605  # N, exact
FOOT = 0.3048  # m, exact
GRAVITY = 9.80665  # m/s^2, exact


@dataclass(frozen=True)
class Unit:
    """A unit: its physical quantity and its conversion to SI units.

    `quantity`: "angle", "force", "pressure", ... `factor`, `offset`: value_SI = factor * value + offset. Temperatures
    are converted to deg C; as the quantity "absolute temperature" to kelvin.
    """

    quantity: str
    factor: float = 1.0
    offset: float = 0.0


def _spelled(quantity: str, units: dict[str, float]) -> dict[str, Unit]:
    """Return units by spelling; `units`: spellings separated by blanks, with their factor."""
    return {name: Unit(quantity, factor) for names, factor in units.items() for name in names.split()}


_DEGREE = np.pi / 180.0
#: By normalized spelling (`_normalized`). docs/conventions.md lists them, which a test compares.
UNITS: dict[str, Unit] = {
    "": Unit("ratio"),
    **_spelled("time", {
        "s sec second seconds unixtime": 1.0, "ms msec millisecond milliseconds": 1e-3, "min minute minutes": 60.0,
        "us usec microsecond microseconds": 1e-6, "ns nsec nanosecond nanoseconds": 1e-9, "h hr hour hours": 3600.0,
    }),
    **_spelled("angle", {"rad radian radians": 1.0, "deg degree degrees": _DEGREE, "mrad": 1e-3}),
    **_spelled("ratio", {"none 1 fraction unitless": 1.0, "% percent pct": 0.01}),
    **_spelled("force", {
        "n newton newtons": 1.0, "kn": 1e3, "dan": 10.0, "lb lbs lbf pound pounds": POUND, "kgf kg kp": GRAVITY,
    }),
    **_spelled("moment", {
        "nm": 1.0, "knm": 1e3, "nmm": 1e-3, "kgfm": GRAVITY, "ftlb lbft ftlbf lbfft ftlbs": POUND * FOOT,
        "inlb lbin inlbf lbfin": POUND * FOOT / 12.0,
    }),
    **_spelled("pressure", {
        "pa n/m2": 1.0, "hpa mbar": 1e2, "kpa kpag": 1e3, "mpa": 1e6, "bar barg": 1e5, "psi psig lbf/in2 lb/in2": PSI,
        "kgf/cm2 kg/cm2": GRAVITY * 1e4,
    }),
    **_spelled("speed", {
        "m/s mps ms1": 1.0, "kph km/h kmh kmph": 1.0 / 3.6, "mph mi/h": 0.44704, "ft/s fps": FOOT,
        "kt kts knot knots": 1852.0 / 3600.0,
    }),
    **_spelled("temperature", {"degc c celsius": 1.0}),
    **dict.fromkeys(("degf", "f", "fahrenheit"), Unit("temperature", 5.0 / 9.0, -160.0 / 9.0)),
    **dict.fromkeys(("k", "kelvin"), Unit("temperature", 1.0, -273.15)),
    **_spelled("length", {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "km": 1e3, "in inch": FOOT / 12.0, "ft": FOOT}),
    **_spelled("curvature", {"1/m rad/m m1": 1.0, "1/km": 1e-3}),
    **_spelled("rotation", {
        "rad/s radians/s rads1 radps": 1.0,
        "deg/s degrees/s degree/s dps degs1 degps": _DEGREE, "mrad/s": 1e-3,
        "rpm 1/min rev/min r/min min1": np.pi / 30.0,
        "rev/s": 2.0 * np.pi,
    }),
    **_spelled("acceleration", {"m/s2 ms2 mps2": 1.0, "g gs gforce": GRAVITY, "mg": 1e-3 * GRAVITY, "ft/s2": FOOT}),
}  # fmt: skip
#: Spellings of two units, of one quantity: nothing is converted by them until one of the two is stated.
AMBIGUOUS: dict[str, tuple[str, ...]] = {"rps": ("rad/s", "rev/s")}
#: The common units of tables by quantity, in the spelling of lists and messages, SI first.
UNITS_OF_TABLES: dict[str, tuple[str, ...]] = {
    "time": ("s", "ms", "us", "ns", "min"),
    "ratio": ("1", "%"),
    "angle": ("rad", "deg"),
    "force": ("N", "kN", "daN", "lbf", "kgf"),
    "moment": ("N m", "kN m", "N mm", "lbf ft", "lbf in"),
    "pressure": ("Pa", "kPa", "bar", "psi"),
    "speed": ("m/s", "km/h", "mph"),
    "temperature": ("deg C", "deg F", "K"),
    "absolute temperature": ("K", "deg C", "deg F"),
    "curvature": ("1/m",),
}
#: The quantity of a temperature in kelvin, and 0 deg C in kelvin.
ABSOLUTE, ZERO_CELSIUS = "absolute temperature", 273.15
_SCALED = re.compile(r"(?P<factor>\d{1,6}(\.\d{1,6})?) ?(?P<unit>[A-Za-z%].*)")
#: Characters of instruments: degree signs, superscripts, micro signs; those without a meaning are dropped.
_CHARACTERS = str.maketrans({
    **dict.fromkeys(" -.*_^()[]\u00b7\u22c5\u207b\u2212"),
    **dict.fromkeys("\u00b0\u00ba\u02da", "deg"),
    **dict.fromkeys("\u00b5\u03bc", "u"),
    **dict.fromkeys("\u2044\u00f7", "/"),
    "\u00b9": "1", "\u00b2": "2", "\u00b3": "3",
})  # fmt: skip
_PER = re.compile(r"per(?=sec|s$|min|h|m)")
_TIME = re.compile(r"/(?P<unit>s|h|min)(ec|econd|econds|r|our|ours|ute|utes)?(?![a-z])")


def _normalized(spelling: str) -> str:
    """Return a spelling in lower case without blanks, dashes, dots and powers, its rates as ``/s``, ``/h``, ``/min``.

    >>> [_normalized(text) for text in ("m/s\u00b2", "deg per second", "m/s/s", "\u00b0/sec", "N\u00b7m")]
    ['m/s2', 'deg/s', 'm/s2', 'deg/s', 'nm']
    """
    text = _PER.sub("/", spelling.casefold().translate(_CHARACTERS))
    text = _TIME.sub(r"/\g<unit>", text)
    return text.replace("/s/s", "/s2")


def find_unit(spelling: str) -> Unit | None:
    """Return the unit for a spelling in a file; None if no unit has it.

    `spelling`: "kph", "km/h", "N-m", "deg C", "none", ...; see `_normalized`. A number in front of a
    unit without an offset multiplies it: "0.1 N". Of an ambiguous spelling it is the first of its meanings.

    >>> find_unit("0.1 N").factor, find_unit("dge")
    (0.1, None)
    """
    unit = UNITS.get((meanings(spelling) or (_normalized(spelling),))[0])
    if unit is not None:
        return unit
    scaled = _SCALED.fullmatch(spelling.strip())
    unit = UNITS.get(_normalized(scaled["unit"])) if scaled else None
    if scaled is None or unit is None or unit.offset or not float(scaled["factor"]) > 0.0:
        return None
    return Unit(unit.quantity, float(scaled["factor"]) * unit.factor)


def quantity_of(spelling: str) -> str | None:
    """Return the quantity of a unit in the spelling of a file; None if no unit has it.

    >>> quantity_of("deg/s"), quantity_of("rps"), quantity_of("dge")
    ('rotation', 'rotation', None)
    """
    unit = find_unit(spelling)
    return unit.quantity if unit else None


def meanings(spelling: str) -> tuple[str, ...]:
    """Return the units that an ambiguous spelling may mean; none for any other one.

    >>> meanings("RPS"), meanings("rad/s")
    (('rad/s', 'rev/s'), ())
    """
    return AMBIGUOUS.get(_normalized(spelling), ())


def unit_named(spelling: str) -> Unit:
    """Return the unit for a spelling as of `find_unit`.

    Raises `UnknownName`, with the nearest one, if no unit has it, and `DataError` if it may mean two.

    >>> unit_named("km/h").quantity
    'speed'
    """
    unit = find_unit(spelling)
    if unit is None:
        raise UnknownName("unit", spelling.strip(), UNITS)
    if both := meanings(spelling):
        raise DataError(f"unit {spelling.strip()!r} is {' or '.join(both)}: state one of them")
    return unit


def unit_of(spelling: str, quantity: str) -> Unit:
    """Return the unit of a quantity for a spelling; raises `DataError` if it is one of another quantity.

    >>> unit_of("deg C", "absolute temperature").offset
    273.15
    """
    unit = unit_named(spelling)
    if quantity == ABSOLUTE and unit.quantity == "temperature":
        unit = Unit(ABSOLUTE, unit.factor, unit.offset + ZERO_CELSIUS)
    if unit.quantity != quantity:
        raise DataError(f"unit {spelling.strip()!r} measures {unit.quantity}, not {quantity}")
    return unit


def to_si(values: ArrayLike, spelling: str, quantity: str | None = None) -> FloatArray:
    """Return values in SI units (temperatures in deg C, absolute temperatures in K).

    Parameters
    ----------
    values : array_like, shape (...)
        In the declared unit.
    spelling : str
        The declared unit.
    quantity : str, optional
        The physical quantity of the unit. Default: not checked.

    Returns
    -------
    ndarray, shape (...)
        In the SI unit, of the shape of the values.

    Raises
    ------
    UnknownName
        If the unit is unknown.
    DataError
        If the unit is one of another quantity, or a value is too large for a float in SI.

    Examples
    --------
    >>> to_si([12.0], "psi").round()
    array([82737.])
    >>> to_si(140.0, "deg F").round(6)
    np.float64(60.0)
    """
    unit = unit_named(spelling) if quantity is None else unit_of(spelling, quantity)
    array = np.asarray(values, dtype=np.float64)
    # Without an offset the sign of a zero is preserved; a factor of 1 preserves every bit.
    with np.errstate(over="ignore"):
        converted = array * unit.factor + unit.offset if unit.offset else array * unit.factor
    if np.any(np.isinf(converted) & np.isfinite(array)):
        raise DataError(f"a value in {spelling.strip()} is too large")
    return np.asarray(converted)
