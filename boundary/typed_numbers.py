"""Ranges of inputs in SI units, beyond which a number is in another unit, and their check for numbers typed by hand."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any

from .errors import TirefmuError

#: By input: lowest and highest value, and what to write instead. A wheel turns by at most 90 deg, and -1 is a locked
#: wheel; a spinning wheel of a slow vehicle reaches several. The range of Fz is that of a pressed wheel.
RANGES: Mapping[str, tuple[float, float, str]] = {
    "kappa": (-10.5, 10.5, "a fraction: 10 % is 0.1"),
    "alpha": (-1.6, 1.6, "rad: np.radians(5) is 5 deg"),
    "gamma": (-1.6, 1.6, "rad: np.radians(5) is 5 deg"),
    "Fz": (0.0, 1e6, "N, positive where the wheel is pressed to the road"),
    "p": (0.0, 5e6, "Pa: 83e3 is 83 kPa"),
    "V": (-150.0, 150.0, "m/s: 36 km/h is 10"),
}
#: Numbers of a list that is typed by hand. Longer lists and arrays are results of a program and are not checked.
TYPED = 20


def check_typed(inputs: Mapping[str, Any]) -> None:
    """Raise `TirefmuError` if a number or a short list is outside the range of its input; arrays are not checked.

    >>> check_typed({"alpha": 5, "Fz": 900.0})
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.TirefmuError: alpha = 5 is outside -1.6 to 1.6: it is in rad: np.radians(5) is 5 deg
    """
    for name, given in inputs.items():
        low, high, unit = RANGES.get(name, (-inf, inf, ""))
        numbers = given if isinstance(given, (list, tuple)) and len(given) <= TYPED else [given]
        for number in numbers:
            if type(number) in (int, float) and not low <= number <= high and number == number:
                raise TirefmuError(f"{name} = {number:g} is outside {low:g} to {high:g}: it is in {unit}")
