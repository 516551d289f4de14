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


#: By normalized spelling: lower case, without blanks, dashes, dots, stars and degree signs.
UNITS: dict[str, Unit] = {
    **dict.fromkeys(("s", "sec", "second", "seconds"), Unit("time")),
    "ms": Unit("time", 1e-3),
    "min": Unit("time", 60.0),
    "rad": Unit("angle"),
    **dict.fromkeys(("deg", "degree", "degrees"), Unit("angle", np.pi / 180.0)),
    **dict.fromkeys(("", "none", "1", "fraction", "unitless"), Unit("ratio")),
    **dict.fromkeys(("%", "percent", "pct"), Unit("ratio", 0.01)),
    "n": Unit("force"),
    "kn": Unit("force", 1e3),
    "dan": Unit("force", 10.0),
    **dict.fromkeys(("lb", "lbs", "lbf"), Unit("force", POUND)),
    "kgf": Unit("force", GRAVITY),
    "nm": Unit("moment"),
    "knm": Unit("moment", 1e3),
    "nmm": Unit("moment", 1e-3),
    **dict.fromkeys(("ftlb", "lbft", "ftlbf", "lbfft", "ftlbs"), Unit("moment", POUND * FOOT)),
    **dict.fromkeys(("inlb", "lbin", "inlbf", "lbfin"), Unit("moment", POUND * FOOT / 12.0)),
    "pa": Unit("pressure"),
    "kpa": Unit("pressure", 1e3),
    "mpa": Unit("pressure", 1e6),
    "bar": Unit("pressure", 1e5),
    "psi": Unit("pressure", PSI),
    **dict.fromkeys(("m/s", "mps"), Unit("speed")),
    **dict.fromkeys(("kph", "km/h", "km/hr", "kmh", "kmph"), Unit("speed", 1.0 / 3.6)),
    "mph": Unit("speed", 0.44704),
    **dict.fromkeys(("degc", "c", "celsius"), Unit("temperature")),
    **dict.fromkeys(("degf", "f", "fahrenheit"), Unit("temperature", 5.0 / 9.0, -160.0 / 9.0)),
    **dict.fromkeys(("k", "kelvin"), Unit("temperature", 1.0, -273.15)),
    "m": Unit("length"),
    "cm": Unit("length", 1e-2),
    "mm": Unit("length", 1e-3),
    **dict.fromkeys(("in", "inch"), Unit("length", FOOT / 12.0)),
    **dict.fromkeys(("1/m", "rad/m"), Unit("curvature")),
    "rpm": Unit("rotation", np.pi / 30.0),
    "rad/s": Unit("rotation"),
    **dict.fromkeys(("deg/s", "dps"), Unit("rotation", np.pi / 180.0)),
    **dict.fromkeys(("m/s2", "m/s^2"), Unit("acceleration")),
    "g": Unit("acceleration", GRAVITY),
}
#: The common units of tables by quantity, in the spelling of lists and messages, SI first.
UNITS_OF_TABLES: dict[str, tuple[str, ...]] = {
    "time": ("s", "ms", "min"),
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
_IGNORED = str.maketrans("", "", " -.*_\u00b0\u00b7")


def unit_named(spelling: str) -> Unit:
    """Return the unit for a spelling in a file.

    `spelling`: "kph", "km/h", "N-m", "deg C", "none", ...; case, blanks and dashes are ignored. A number in front of a
    unit without an offset multiplies it: "0.1 N". Raises `UnknownName` if no unit has this spelling.

    >>> unit_named("0.1 N").factor
    0.1
    """
    unit = UNITS.get(spelling.casefold().translate(_IGNORED))
    if unit is not None:
        return unit
    scaled = _SCALED.fullmatch(spelling.strip())
    unit = UNITS.get(scaled["unit"].casefold().translate(_IGNORED)) if scaled else None
    if scaled is None or unit is None or unit.offset or not float(scaled["factor"]) > 0.0:
        raise UnknownName("unit", spelling.strip(), UNITS)
    return Unit(unit.quantity, float(scaled["factor"]) * unit.factor)


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
