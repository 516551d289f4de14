"""Physical conditions that a fitted tire keeps over its whole operating range.

Those of the Trento report's table 1.2.5 (C > 0, D > 0, E <= 1, B > 0, G > 0), for every model quantity that
they name, in adapted SAE signs, and for the later models a positive slip stiffness and trail. They are imposed
on the corners of the range of the data, verified on a dense grid, and imposed where they were broken there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

import numpy as np
import numpy.typing as npt
import pandas as pd

FloatArray = npt.NDArray[np.float64]
#: By how much a quantity may miss its bound before the constraint counts as broken.
TOLERANCE = 1e-6


@dataclass(frozen=True)
class Constraint:
    """A named quantity that stays within bounds.

    Attributes
    ----------
    quantity : str
        Name in the book, such as "E_x".
    lower, upper : float
        In the quantity's unit.
    over : tuple of str
        The inputs on which the quantity depends.
    size : float
        Its usual size, for the solver.
    """

    quantity: str
    lower: float
    upper: float
    over: tuple[str, ...]
    size: float = 1.0

    @property
    def scaled_bounds(self) -> tuple[float, float]:
        """The bounds of quantity / size, so narrowed that what the solver calls kept is kept in the quantity's unit."""
        narrowed = TOLERANCE if self.size > 1.0 else 0.0
        return self.lower / self.size + narrowed, self.upper / self.size - narrowed

    @property
    def name(self) -> str:
        """The condition as it is written: ``E_x <= 1``."""
        return f"{self.quantity} <= {self.upper:g}" if self.upper < inf else f"{self.quantity} > 0"

    def distance(self, values: FloatArray) -> FloatArray:
        """Return how far values lie inside the bounds; negative outside, minus infinity where there is no value."""
        distance = np.minimum(values - self.lower, self.upper - values)
        return np.where(np.isnan(distance), -inf, distance)


def _positive(quantity: str, floor: float, *over: str, size: float = 1.0) -> Constraint:
    """Keep a quantity above a floor that is small against any plausible value of it."""
    return Constraint(quantity, floor, inf, over, size)


def _curvature(quantity: str, *over: str) -> Constraint:
    return Constraint(quantity, -inf, 1.0, over)


def _forces(pressure: tuple[str, ...], *, inclined: bool) -> dict[str, tuple[Constraint, ...]]:
    """Return the conditions on Fx and Fy.

    Parameters
    ----------
    pressure : tuple of str
        The input p, for models that read it.
    inclined : bool
        Whether the weighting functions change with inclination and load.
    """
    shared = ("gamma", "Fz") if inclined else ()
    return {
        "Fx": (
            _positive("C_x", 0.1),
            _positive("mu_x", 0.01, "Fz", "gamma", *pressure),
            _positive("B_x", 0.1, "Fz", "gamma", *pressure),
            _curvature("E_x", "Fz", "kappa"),
            _positive("B_xalpha", 0.0, "kappa", *shared[:1]),
            _positive("G_xa", 0.01, "kappa", "alpha", *shared),
        ),
        "Fy": (
            _positive("C_y", 0.1),
            _positive("mu_y", 0.01, "Fz", "gamma", *pressure),
            _positive("B_y", 0.1, "Fz", "gamma", *pressure),
            _curvature("E_y", "Fz", "gamma", "alpha"),
            _positive("B_ykappa", 0.0, "alpha", *shared[:1]),
            _positive("G_yk", 0.01, "kappa", "alpha", *shared),
        ),
    }


def _mf96() -> dict[str, tuple[Constraint, ...]]:
    trail = (
        _positive("C_t", 0.1),
        _positive("B_t", 0.1, "Fz", "gamma"),
        _curvature("E_t", "Fz", "gamma", "alpha"),
    )
    return {**_forces((), inclined=False), "Mz": trail}


def _mf6() -> dict[str, tuple[Constraint, ...]]:
    """Return those of MF5.2 to 6.2: also with pressure, and the slip stiffnesses and the trail by their own names."""
    forces = _forces(("p",), inclined=True)
    return {
        "Fx": (*forces["Fx"], _positive("K_xkappa", 1.0, "Fz", "p", size=1e4)),
        "Fy": (*forces["Fy"], _positive("K_yalpha", 1.0, "Fz", "gamma", "p", size=1e4)),
        "Mz": (
            _positive("C_t", 0.1),
            _positive("B_t", 0.1, "Fz", "gamma"),
            _positive("D_t", 0.0, "Fz", "gamma", "p", size=0.01),
            _curvature("E_t", "Fz", "gamma", "alpha"),
        ),
    }


#: The conditions of each model, by the output that they belong to. Floors: 0.01 of friction, 0.1 of C and of
#: B in 1/rad, 0.01 of G, 1 of slip stiffness in N and N/rad; E is checked on both sides of zero slip because it
#: jumps there.
VALIDITY: dict[str, dict[str, tuple[Constraint, ...]]] = {
    "mf96": _mf96(),
    "mf52": _mf6(),
    "mf61": _mf6(),
    "mf62": _mf6(),
}


def operating_range(table: pd.DataFrame, inputs: tuple[str, ...]) -> dict[str, tuple[float, float]]:
    """Return the range of each input in a table; (0, 0) for one that is not there.

    Parameters
    ----------
    table : pandas.DataFrame
    inputs : tuple of str

    Returns
    -------
    dict of str to (float, float)
    """
    return {n: (float(table[n].min()), float(table[n].max())) if n in table else (0.0, 0.0) for n in inputs}


def grid(
    constraint: Constraint,
    ranges: Mapping[str, tuple[float, float]],
    nominal: Mapping[str, float],
    *,
    density: int = 1,
) -> FloatArray:
    """Return the points at which a constraint is imposed, or verified (density above 1).

    Parameters
    ----------
    constraint : Constraint
    ranges : mapping of str to (float, float)
        Operating range of every input, in the model's order.
    nominal : mapping of str to float
        Value of the inputs on which the quantity does not depend.
    density : int
        0: the corners, and zero slip. 1: loads in five steps, inclination and pressure in three, slips at their
        ends, at zero and near it.

    Returns
    -------
    ndarray, shape (n_inputs, n_points)

    Examples
    --------
    >>> ranges = {"kappa": (-0.2, 0.2), "alpha": (0.0, 0.0), "gamma": (0.0, 0.05), "Fz": (200.0, 1000.0)}
    >>> grid(Constraint("mu_x", 0.01, 9.0, ("Fz", "gamma")), ranges, {"kappa": 0, "alpha": 0}).shape
    (4, 15)
    """
    steps = {"Fz": 4 * density, "gamma": 2 * density, "p": 2 * density}
    axes = []
    for name, (low, high) in ranges.items():
        if name not in constraint.over:
            axes.append(np.array([nominal.get(name, low)]))
        elif name in steps:
            axes.append(np.linspace(low, high, max(steps[name], 1) + 1))
        elif density == 0:
            axes.append(np.array([low, min(max(low, 0.0), high), high]))
        else:
            near = 0.02 * max(abs(low), abs(high))  # E takes its two branches beside zero slip
            axes.append(np.concatenate([np.linspace(low, high, 2 * density + 1), [-near, 0.0, near]]))
    mesh = np.meshgrid(*(np.unique(axis) for axis in axes), indexing="ij")
    return np.stack([points.ravel() for points in mesh])
