"""Physical constraints that a fitted tire satisfies over its operating range, each with a name.

A name consists of a kind and a quantity, ``signs:mu_x``; the kind alone selects all of its constraints:

signs
    C, mu (and with it D), B, G, slip stiffness and trail are positive: the Trento report's table 1.2.5. G, a share of
    the force, is also at most 1.05, 1 but for a shift.
curvature
    E <= 1, from the same table.
friction_falling
    mu does not increase with load.
stiffness_saturating
    Slip stiffness increases at most in proportion to load.
extrapolation
    The first two kinds in a range of loads and slips 1.5 times as large as that of the data. In this range no sign
    changes, and no curve turns over (which E above 1 would cause). Only on request.

Each model declares its constraints (`tirefmu.symbolic.contract.PhysicalConstraint`). They are imposed at the corners of
the range of the data and verified on a dense grid that contains these corners; points that violate a constraint are
added. Bounds are in adapted SAE signs.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from math import inf

import numpy as np
import pandas as pd

from ...boundary.errors import UnknownName
from ...numerics.arrays import FloatArray
from ...symbolic.contract import CONSTRAINT_KINDS, PhysicalConstraint
from ...symbolic.models import model_named
from ...tires.tire import Tire

#: Tolerance within which a constraint is satisfied, in the unit of the quantity.
TOLERANCE = 1e-6
#: Tolerances by which the bounds of a solver are narrower than those that are verified. Judgement: half a tolerance
#: between imposed points, with a curvature of 1 per (kN)^2, is a distance of 2 N.
NARROWED = 1.5
#: Factor by which the constraints of the kind extrapolation widen the range of loads and slips.
REACH = 1.5


@dataclass(frozen=True)
class Constraint(PhysicalConstraint):
    """A physical constraint of a model, with its scaled bounds for a solver."""

    @property
    def scaled_bounds(self) -> tuple[float, float]:
        """Bounds of quantity / size, reduced by more than the tolerance, within which a solver satisfies them.

        The rest is for the points between those at which the constraint is imposed.
        """
        narrowed = NARROWED * TOLERANCE
        return self.lower / self.size + narrowed, self.upper / self.size - narrowed

    @property
    def name(self) -> str:
        """Name for users: ``curvature:E_x``."""
        return f"{self.kind}:{self.quantity}"

    @property
    def text(self) -> str:
        """The constraint as a formula: ``E_x <= 1``."""
        if self.measure != "value":
            change = {"growth": "falls" if self.upper <= 0.0 else "grows", "excess": "saturates"}[self.measure]
            return f"{self.quantity} {change} with load"
        above = f"{self.lower:g} <= " if self.lower > -inf else ""
        bound = f"{above}{self.quantity} <= {self.upper:g}" if self.upper < inf else f"{self.quantity} > 0"
        return f"{bound}, {REACH:g} x the range" if self.kind == "extrapolation" else bound

    def distance(self, values: FloatArray) -> FloatArray:
        """Return the distance of values to the nearest bound; negative outside, minus infinity for NaN."""
        distance = np.minimum(values - self.lower, self.upper - values)
        return np.where(np.isnan(distance), -inf, distance)

    def within(self, ranges: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
        """Return the ranges in which the constraint is enforced, given those of the data.

        >>> far = Constraint("mu_x", 0.01, inf, ("Fz",), kind="extrapolation")
        >>> far.within({"kappa": (-0.1, 0.2), "gamma": (0.0, 0.05), "Fz": (300.0, 900.0)})["Fz"]
        (200.0, 1350.0)
        """
        if self.kind != "extrapolation":
            return dict(ranges)
        wide = {name: (low * REACH, high * REACH) for name, (low, high) in ranges.items() if name in ("kappa", "alpha")}
        low, high = ranges["Fz"]
        return {**ranges, **wide, "Fz": (low / REACH, high * REACH)}


def declared_constraints(model: str) -> dict[str, tuple[Constraint, ...]]:
    """Return all constraints that a model declares, by output.

    >>> declared_constraints("mf96")["Mz"][0].text
    'C_t > 0'
    """
    declared = model_named(model).fit.constraints
    return {
        output: tuple(Constraint(**vars(declaration)) for declaration in declarations)
        for output, declarations in declared.items()
    }


def chosen_constraints(
    model: str, also: Collection[str] = (), without: Collection[str] = ()
) -> dict[str, tuple[Constraint, ...]]:
    """Return the constraints of a model: the default ones and those in `also`, without those in `without`.

    `also`, `without`: names of single constraints or of kinds; "all" means all constraints. The result is by output.
    Raises `UnknownName` if the model has no such constraint.

    >>> [each.text for each in chosen_constraints("mf61", without=["all"], also=["curvature"])["Fx"]]
    []
    >>> [each.name for each in chosen_constraints("mf96", without=["signs", "extrapolation", "curvature"])["Fy"]]
    ['friction_falling:mu_y', 'stiffness_saturating:K_yalpha']
    """
    declared = declared_constraints(model)
    single = [constraint.name for constraints in declared.values() for constraint in constraints]
    possible = ["all", *CONSTRAINT_KINDS, *single]
    for name in (*also, *without):
        if name not in possible:
            raise UnknownName(f"constraint of {model}", name, possible)

    def meant(constraint: Constraint, names: Collection[str]) -> bool:
        return bool({"all", constraint.kind, constraint.name} & set(names))

    return {
        output: tuple(
            constraint
            for constraint in constraints
            if not meant(constraint, without) and (not constraint.on_request or meant(constraint, also))
        )
        for output, constraints in declared.items()
    }


def operating_range(table: pd.DataFrame, tire: Tire) -> dict[str, tuple[float, float]]:
    """Return the range of each input of a tire in a table; of an absent input its nominal value, twice."""
    given = {name: table[name] if name in table else np.array(tire.nominal(name)) for name in tire.inputs}
    return {name: (float(values.min()), float(values.max())) for name, values in given.items()}


def grid(
    constraint: Constraint, ranges: Mapping[str, tuple[float, float]], nominal: Mapping[str, float], *, density: int = 1
) -> FloatArray:
    """Return the points at which a constraint is imposed, or verified (density above 1).

    `ranges`: operating range of every input, in the model's order; `Constraint.within` may widen it. `nominal`: values
    of the inputs on which the quantity does not depend. `density`: 0: the corners, and zero slip. 1: five loads, three
    inclinations and pressures, slips at their limits, at zero and near zero. Returns shape (n_inputs, n_points).

    >>> ranges = {"kappa": (-0.2, 0.2), "alpha": (0.0, 0.0), "gamma": (0.0, 0.05), "Fz": (200.0, 1000.0)}
    >>> grid(Constraint("mu_x", 0.01, 9.0, ("Fz", "gamma")), ranges, {"kappa": 0, "alpha": 0}).shape
    (4, 15)
    """
    steps = {"Fz": 4 * density, "gamma": 2 * density, "p": 2 * density}
    axes = []
    for name, (low, high) in constraint.within(ranges).items():
        if name not in constraint.varied:
            axes.append(np.array([nominal.get(name, low)]))
        elif name in steps:
            axes.append(np.linspace(low, high, max(steps[name], 1) + 1))
        elif density == 0:
            axes.append(np.array([low, min(max(low, 0.0), high), high]))
        else:
            near = 0.02 * max(abs(low), abs(high))  # E has different branches on the two sides of zero slip
            axes.append(np.concatenate([np.linspace(low, high, 2 * density + 1), [-near, 0.0, near]]))
    mesh = np.meshgrid(*(np.unique(axis) for axis in axes), indexing="ij")
    return np.stack([points.ravel() for points in mesh])
