"""Physical conditions that a fitted tire keeps over its whole operating range.

Those of the Trento report's table 1.2.5 (C > 0, D > 0, E <= 1, B > 0, G > 0), for every model quantity that
they name, in adapted SAE signs. They are imposed on a grid over the range of the data.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
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
    """

    quantity: str
    lower: float
    upper: float
    over: tuple[str, ...]

    @property
    def name(self) -> str:
        """The condition as it is written: ``E_x <= 1``."""
        return f"{self.quantity} <= {self.upper:g}" if self.upper < inf else f"{self.quantity} > 0"

    def distance(self, values: FloatArray) -> FloatArray:
        """Return how far values lie inside the bounds; negative outside, minus infinity where there is no value."""
        distance = np.minimum(values - self.lower, self.upper - values)
        return np.where(np.isnan(distance), -inf, distance)


def _positive(quantity: str, floor: float, *over: str) -> Constraint:
    """Keep a quantity above a floor that is small against any plausible value of it."""
    return Constraint(quantity, floor, inf, over)


def _curvature(quantity: str, *over: str) -> Constraint:
    return Constraint(quantity, -inf, 1.0, over)


#: The conditions of each model, by the output that they belong to. Floors: 0.01 of friction, 0.1 of C and of
#: B in 1/rad, 0.01 of G; E is checked on both sides of zero slip because it jumps there.
VALIDITY: dict[str, dict[str, tuple[Constraint, ...]]] = {
    "mf96": {
        "Fx": (
            _positive("C_x", 0.1),
            _positive("mu_x", 0.01, "Fz", "gamma"),
            _positive("B_x", 0.1, "Fz", "gamma"),
            _curvature("E_x", "Fz", "kappa"),
            _positive("B_xalpha", 0.0, "kappa"),
            _positive("G_xa", 0.01, "kappa", "alpha"),
        ),
        "Fy": (
            _positive("C_y", 0.1),
            _positive("mu_y", 0.01, "Fz", "gamma"),
            _positive("B_y", 0.1, "Fz", "gamma"),
            _curvature("E_y", "Fz", "gamma", "alpha"),
            _positive("B_ykappa", 0.0, "alpha"),
            _positive("G_yk", 0.01, "kappa", "alpha"),
        ),
        "Mz": (
            _positive("C_t", 0.1),
            _positive("B_t", 0.1, "Fz", "gamma"),
            _curvature("E_t", "Fz", "gamma", "alpha"),
        ),
    }
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
        1: loads in five steps, inclination in three, slips at their ends, at zero and near it.

    Returns
    -------
    ndarray, shape (n_inputs, n_points)

    Examples
    --------
    >>> ranges = {"kappa": (-0.2, 0.2), "alpha": (0.0, 0.0), "gamma": (0.0, 0.05), "Fz": (200.0, 1000.0)}
    >>> grid(Constraint("mu_x", 0.01, 9.0, ("Fz", "gamma")), ranges, {"kappa": 0, "alpha": 0}).shape
    (4, 15)
    """
    steps = {"Fz": 4 * density, "gamma": 2 * density}
    axes = []
    for name, (low, high) in ranges.items():
        if name not in constraint.over:
            axes.append(np.array([nominal.get(name, low)]))
        elif name in steps:
            axes.append(np.linspace(low, high, steps[name] + 1))
        else:
            near = 0.02 * max(abs(low), abs(high))  # E takes its two branches beside zero slip
            axes.append(np.concatenate([np.linspace(low, high, 2 * density + 1), [-near, 0.0, near]]))
    points = np.array(list(product(*(np.unique(axis) for axis in axes))))
    return points.T
