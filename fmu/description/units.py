"""Units in the form of the FMI standard: exponents of the SI base units and of rad."""

from __future__ import annotations

import re
from collections import Counter

from ...boundary.errors import FmuError, nearest

#: The factors of products, quotients and powers, as exponents of base units.
#: The FMI standard treats rad as a base unit.
FACTORS: dict[str, dict[str, int]] = {
    "1": {},
    "kg": {"kg": 1},
    "m": {"m": 1},
    "s": {"s": 1},
    "K": {"K": 1},
    "degC": {"K": 1},  # a temperature difference in products and quotients
    "rad": {"rad": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
}
#: Units with an offset: not allowed in products and quotients.
SHIFTED: dict[str, dict[str, int | float]] = {name: {"K": 1, "offset": 273.15} for name in ("deg C", "degC")}

_FACTOR = re.compile(r"(1|[A-Za-z]+)(?:\^(-?\d+))?")


def base_unit(unit: str) -> dict[str, int | float]:
    """Return a unit in base units, as the attributes of FMI's BaseUnit element.

    `unit`: factors separated by spaces, powers with ``^``; all factors after the one ``/`` divide: "N m", "1/rad^2",
    "kg/m s". Returns: exponents of ``kg m s K rad`` that are not 0, and an ``offset`` for a unit with an offset. Raises
    `FmuError` if a factor is unknown.

    >>> base_unit("N m/rad")
    {'kg': 1, 'm': 2, 's': -2, 'rad': -1}
    >>> base_unit("1")
    {}
    >>> base_unit("Nm")
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.FmuError: unit 'Nm': unknown factor 'Nm': did you mean N? ...
    """
    if unit in SHIFTED:
        return dict(SHIFTED[unit])
    exponents: Counter[str] = Counter()
    over, _, under = unit.partition("/")
    for text, direction in ((over, 1), (under, -1)):
        for factor in text.split():
            match = _FACTOR.fullmatch(factor)
            if match is None or match[1] not in FACTORS:
                raise FmuError(f"unit {unit!r}: unknown factor {factor!r}{nearest(factor, FACTORS)}")
            power = direction * int(match[2] or 1)
            for name, exponent in FACTORS[match[1]].items():
                exponents[name] += power * exponent
    return {name: exponents[name] for name in ("kg", "m", "s", "K", "rad") if exponents[name]}
