"""Implausible values and behaviour of a tire, and the probable mistake."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..numerics.ties import graded
from . import Tire
from .definition import RANGES
from .evaluation import quantities

#: Largest plausible magnitude of the ends of an input's range, and the probable unit of a larger number. They replace
#: the bounds in the declarations of the coefficients.
FAR_ENDS = {
    "kappa": (10.0, "in percent?"),
    "alpha": (1.6, "in degrees?"),
    "gamma": (1.6, "in degrees?"),
}
#: Probable units of values outside their bounds: coefficient, from, up to, hint.
MISTAKEN = (
    ("INFLPRES", 0.3, 20.0, "in bar?"),
    ("INFLPRES", 20.0, 2000.0, "in kPa?"),
    ("NOMPRES", 0.3, 20.0, "in bar?"),
    ("NOMPRES", 20.0, 2000.0, "in kPa?"),
    ("UNLOADED_RADIUS", 30.0, 3000.0, "in mm?"),
    ("WIDTH", 15.0, 1500.0, "in mm?"),
    ("RIM_RADIUS", 25.0, 2500.0, "in mm?"),
    ("FNOMIN", 0.05, 1.0, "in kN?"),
    ("VERTICAL_STIFFNESS", 10.0, 1000.0, "in N/mm?"),
    ("LONGVL", 1e-3, 0.1, "in mm/s?"),
)
#: Roles of curvature factors, which are implausible above 1.
CURVATURES = ("curvature_x", "curvature_y", "curvature_trail", "curvature_combined_x", "curvature_combined_y")


@dataclass(frozen=True)
class Doubt:
    """An implausible value.

    - `name`: the coefficient, input or quantity.
    - `reason`: the problem, and the probable mistake.

    >>> print(Doubt("INFLPRES", 2.2, "outside 10000 .. 2e+06: in bar?"))
    INFLPRES = 2.2: outside 10000 .. 2e+06: in bar?
    """

    name: str
    value: float
    reason: str

    def __str__(self) -> str:
        return f"{self.name} = {self.value:g}: {self.reason}"


def implausible(tire: Tire) -> list[Doubt]:
    """Return the implausible values of a tire.

    Returns: coefficients outside their declared bounds (in adapted SAE, unless neutral), implausible ranges, and over
    the range of loads: friction that is not positive or increases with load, slip stiffness of wrong or changing sign,
    curvature above 1.

    >>> from tirefmu.tires import published
    >>> [doubt.name for doubt in implausible(published("trento_hoosier"))]
    ['E_t']
    """
    return [*_beyond_bounds(tire), *_ranges(tire), *_behaviour(tire.in_signs("adapted-sae"))]


def loads(tire: Tire) -> npt.NDArray[np.float64]:
    """Return nine loads, N, shape (9,), over the valid range of a tire, or around its nominal load."""
    nominal = tire.values["FNOMIN"]
    low, high = tire.ranges.get("Fz", (0.2 * nominal, 2.0 * nominal))
    return np.linspace(max(low, 0.05 * high), high, 9) if high > 0 else np.full(9, nominal)


def _beyond_bounds(tire: Tire) -> Iterator[Doubt]:
    plain = tire.in_signs("adapted-sae").values
    ends = {key for name in FAR_ENDS for key in RANGES[name]}
    for name, declared in tire.symbolic_model.coefficients.items():
        if name in ends or plain[name] == declared.neutral or declared.lower <= plain[name] <= declared.upper:
            continue
        hints = [hint for mistaken, low, high, hint in MISTAKEN if mistaken == name and low <= abs(plain[name]) < high]
        hints += ["wrong sign?"] if declared.lower <= -plain[name] <= declared.upper else []
        converted = "" if plain[name] == tire.values[name] else " with the sign of adapted SAE"
        reason = f"outside {declared.lower:g} .. {declared.upper:g}{converted}"
        yield Doubt(name, tire.values[name], ": ".join([reason, *hints]))


def _ranges(tire: Tire) -> Iterator[Doubt]:
    for name, (end, hint) in FAR_ENDS.items():
        for key, value in zip(RANGES[name], tire.ranges.get(name, ()), strict=False):
            if abs(value) > end:
                yield Doubt(key, value, f"the range of {name} exceeds {end:g}: {hint}")
    low, high = tire.ranges.get("Fz", (0.0, np.inf))
    if not low <= tire.values["FNOMIN"] <= high:
        yield Doubt("FNOMIN", tire.values["FNOMIN"], f"outside the range of Fz, {low:g} .. {high:g} N")


def _behaviour(tire: Tire) -> Iterator[Doubt]:
    """Yield doubts about named quantities over the range of loads, in adapted SAE."""
    points = [(Fz, side * 0.5 * _end(tire, "kappa", 0.2), side * 0.5 * _end(tire, "alpha", 0.2))
              for Fz in loads(tire) for side in (-1.0, 1.0)]  # fmt: skip
    inputs = dict(zip(("Fz", "kappa", "alpha"), np.array(points).T, strict=True))
    computed, load = quantities(tire.in_signs("adapted-sae"), inputs), inputs["Fz"]
    model = tire.symbolic_model
    for axis in ("x", "y"):
        friction, stiffness = model.quantity(f"friction_{axis}"), model.quantity(f"stiffness_{axis}")
        yield from _sign(friction, computed[friction], load)
        if stiffness:
            yield from _sign(stiffness, computed[stiffness], load)
        first, last = computed[friction][0], computed[friction][-1]
        if computed[friction].min() > 0 and last > first * (1 + 1e-9):
            yield Doubt(friction, float(last), f"increases with load, from {first:.3g} at {load[0]:g} N")
    for name in filter(None, map(model.quantity, CURVATURES)):
        curvature = np.nan_to_num(computed[name], nan=-np.inf)
        row = int(graded(curvature).argmax())
        if curvature[row] > 1:
            at = ", ".join(f"{key} = {values[row]:.3g}" for key, values in inputs.items())
            yield Doubt(name, float(curvature[row]), f"above 1 at {at}")


def _sign(name: str, values: npt.NDArray[np.float64], load: npt.NDArray[np.float64]) -> Iterator[Doubt]:
    """Yield a doubt if a quantity is not positive everywhere."""
    bad = np.flatnonzero(~(values > 0))
    if bad.size == 0:
        return
    row = bad[0]
    reason = "is not a number" if np.isnan(values[row]) else "is not positive"
    if len(bad) < len(values) and not np.isnan(values[row]):
        reason = "changes sign within the range of loads"
    yield Doubt(name, float(values[row]), f"{reason} (adapted SAE), Fz = {load[row]:.4g} N")


def _end(tire: Tire, name: str, default: float) -> float:
    """Return the largest magnitude in the range of an input if plausible, else `default`."""
    ends = [abs(end) for end in tire.ranges.get(name, ())]
    return max(ends) if ends and 0 < max(ends) <= 1.0 else default
