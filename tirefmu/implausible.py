"""What in a tire looks implausible: values and behaviour that measured tires do not show, and the likely slip."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.tires import Tire
from tirefmu.tires.definition import RANGES

#: From where on an end of an input's range is hard to believe, and what the number may be instead. These are
#: judged here, not by the cards of the models that have coefficients for them.
FAR_ENDS = {
    "kappa": (10.0, "in percent?"),
    "alpha": (1.6, "in degrees?"),
    "gamma": (1.6, "in degrees?"),
}
#: What a value beyond its bounds may be instead: coefficient, from, up to, hint.
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
#: Roles of curvature factors, which above 1 turn a curve back on itself.
CURVATURES = ("curvature_x", "curvature_y", "curvature_trail", "curvature_combined_x", "curvature_combined_y")


@dataclass(frozen=True)
class Doubt:
    """Something implausible.

    Attributes
    ----------
    name : str
        The coefficient, input or quantity.
    value : float
    reason : str
        What is wrong with it, and perhaps what it is instead.

    Examples
    --------
    >>> print(Doubt("INFLPRES", 2.2, "outside 10000 .. 2e+06: in bar?"))
    INFLPRES = 2.2: outside 10000 .. 2e+06: in bar?
    """

    name: str
    value: float
    reason: str

    def __str__(self) -> str:
        return f"{self.name} = {self.value:g}: {self.reason}"


def implausible(tire: Tire) -> list[Doubt]:
    """Return what looks implausible in a tire.

    Parameters
    ----------
    tire : Tire

    Returns
    -------
    list of Doubt
        Coefficients beyond the bounds of their cards (in adapted SAE, wherever not at neutral), ranges of unlikely
        size, and over the range of loads: friction that is not positive or rises with load, slip stiffness of
        the wrong or of changing sign, curvature above 1.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> [doubt.name for doubt in implausible(published("trento_hoosier"))]
    ['E_t']
    """
    return [*_beyond_bounds(tire), *_ranges(tire), *_behaviour(tire.in_signs("adapted-sae"))]


def loads(tire: Tire) -> npt.NDArray[np.float64]:
    """Return nine loads, N, shape (9,), over the range in which a tire is known, else around its nominal load."""
    nominal = tire.values["FNOMIN"]
    low, high = tire.ranges.get("Fz", (0.2 * nominal, 2.0 * nominal))
    return np.linspace(max(low, 0.05 * high), high, 9) if high > 0 else np.full(9, nominal)


def _beyond_bounds(tire: Tire) -> Iterator[Doubt]:
    plain = tire.in_signs("adapted-sae").values
    ends = {key for name in FAR_ENDS for key in RANGES[name]}
    for name, card in tire.book.coefficients.items():
        if name in ends or plain[name] == card.neutral or card.lower <= plain[name] <= card.upper:
            continue
        hints = [hint for known, low, high, hint in MISTAKEN if known == name and low <= abs(plain[name]) < high]
        hints += ["wrong sign?"] if card.lower <= -plain[name] <= card.upper else []
        where = "" if plain[name] == tire.values[name] else " with its sign turned (adapted SAE)"
        reason = f"outside {card.lower:g} .. {card.upper:g}{where}"
        yield Doubt(name, tire.values[name], ": ".join([reason, *hints]))


def _ranges(tire: Tire) -> Iterator[Doubt]:
    for name, (end, hint) in FAR_ENDS.items():
        for key, value in zip(RANGES[name], tire.ranges.get(name, ()), strict=False):
            if abs(value) > end:
                yield Doubt(key, value, f"the range of {name} reaches beyond {end:g}: {hint}")
    low, high = tire.ranges.get("Fz", (0.0, np.inf))
    if not low <= tire.values["FNOMIN"] <= high:
        yield Doubt("FNOMIN", tire.values["FNOMIN"], f"outside the range of Fz, {low:g} .. {high:g} N")


def _behaviour(tire: Tire) -> Iterator[Doubt]:
    """Yield doubts about named quantities over the range of loads, in adapted SAE."""
    table = pd.DataFrame(
        [(Fz, side * 0.5 * _end(tire, "kappa", 0.2), side * 0.5 * _end(tire, "alpha", 0.2))
         for Fz in loads(tire) for side in (-1.0, 1.0)],
        columns=["Fz", "kappa", "alpha"],
    )  # fmt: skip
    told = tire.evaluate(table, signs="adapted-sae", steady=True)
    book = tire.book
    for axis in ("x", "y"):
        friction, stiffness = book.quantity(f"friction_{axis}"), book.quantity(f"stiffness_{axis}")
        yield from _sign(told, friction)
        if stiffness:
            yield from _sign(told, stiffness)
        if told[friction].min() > 0 and told[friction].iloc[-1] > told[friction].iloc[0] * (1 + 1e-9):
            first, last = told[friction].iloc[0], told[friction].iloc[-1]
            yield Doubt(friction, float(last), f"rises with load, from {first:.3g} at {told['Fz'].iloc[0]:g} N")
    for name in filter(None, map(book.quantity, CURVATURES)):
        curvature = np.nan_to_num(told[name].to_numpy(dtype=np.float64), nan=-np.inf)
        row = int(curvature.argmax())
        if curvature[row] > 1:
            at = ", ".join(f"{key} = {table[key].iloc[row]:.3g}" for key in ("Fz", "kappa", "alpha"))
            yield Doubt(name, float(curvature[row]), f"above 1 at {at}")


def _sign(told: pd.DataFrame, name: str) -> Iterator[Doubt]:
    """Yield a doubt where a quantity is not positive throughout."""
    values = told[name].to_numpy(dtype=np.float64)
    bad = np.flatnonzero(~(values > 0))
    if bad.size == 0:
        return
    row = bad[0]
    reason = "is not a number" if np.isnan(values[row]) else "is not positive"
    if len(bad) < len(values) and not np.isnan(values[row]):
        reason = "changes its sign within the range of loads"
    yield Doubt(name, float(values[row]), f"{reason} (adapted SAE), Fz = {told['Fz'].iloc[row]:.4g} N")


def _end(tire: Tire, name: str, usual: float) -> float:
    """Return the size of an input at the end of its range, where that is believable."""
    ends = [abs(end) for end in tire.ranges.get(name, ())]
    return max(ends) if ends and 0 < max(ends) <= 1.0 else usual
