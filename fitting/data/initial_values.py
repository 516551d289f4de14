"""Initial values from the data: slip stiffness, friction, shifts and trail at each load.

A saturating curve is fitted to the sweeps at one load; its slope at zero, zero crossing and height are the values. A
few rows determine it; the slope near zero slip (`tirefmu.numerics.slip_slope`), which targets and checks use, would
be off by up to 28 %. The trail is the ratio of aligning moment to side force. The coefficients that a model declares
for these roles follow by least squares with the equations of the model, for any model and any set of effects.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, radians

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from ...measurements import levels
from ...numerics.arrays import FloatArray
from ...symbolic.contract import Role
from ...tires.code import fastest_code
from ...tires.tire import Tire

#: Largest magnitude of the other slip and of the inclination that counts as zero.
PURE = {"kappa": 0.01, "alpha": radians(1.0), "gamma": radians(1.0)}
MIN_ROWS = 12
#: Largest number of rows for a curve with four parameters; more rows do not improve it.
MAX_ROWS = 2000
#: A curve has reached its peak if it exceeds this share of its height.
FLATTENED = 0.9
#: Quantile of the magnitude that is the size of a force; single outliers do not affect it.
SIZE_QUANTILE = 0.95
#: C_t of the trail curve: the generic value of the declarations.
TRAIL_SHAPE = 1.1
#: Number of parts into which varying loads are divided.
PARTS = 4


@dataclass(frozen=True)
class Reading:
    """A quantity of the model, read from the data.

    - `loads`, `values`, shape (n,): load (N) and value in the quantity's unit, in adapted SAE.
    """

    loads: FloatArray
    values: FloatArray


def readings(table: pd.DataFrame) -> dict[str, Reading]:
    """Read slip stiffness, shift, friction and trail from slip sweeps.

    `table`: measured rows in adapted SAE. The result is by the role of the quantity
    (`tirefmu.symbolic.contract.ROLES`); only quantities that the data show at some load.

    >>> alpha = np.linspace(-0.2, 0.2, 201)
    >>> table = pd.DataFrame({"alpha": alpha, "Fz": 1000.0, "Fy": 1500.0 * np.tanh(20 * alpha + 0.2)})
    >>> {name: [f"{value:.3g}" for value in reading.values] for name, reading in readings(table).items()}
    {'stiffness_y': ['3.04e+04'], 'shift_y': ['0.01'], 'friction_y': ['1.5']}
    """
    readings: dict[str, list[tuple[float, float]]] = {}
    for force, slip, other, names in (
        ("Fx", "kappa", "alpha", ("stiffness_x", "shift_x", "friction_x")),
        ("Fy", "alpha", "kappa", ("stiffness_y", "shift_y", "friction_y")),
    ):
        for part in _pure(table, force, slip, other):
            load = float(part["Fz"].median())
            curve = _curve(part[slip].to_numpy(dtype=float), part[force].to_numpy(dtype=float))
            trail = _trail(part) if force == "Fy" and curve else {}
            values = {
                name: curve[key] for name, key in zip(names, ("slope", "shift", "height"), strict=True) if key in curve
            }
            if names[2] in values:
                values[names[2]] /= load
            for name, value in {**values, **trail}.items():
                readings.setdefault(name, []).append((load, value))
    return {name: Reading(*np.array(pairs).T) for name, pairs in readings.items()}


def starting_values(tire: Tire, table: pd.DataFrame) -> dict[str, float]:
    """Return initial values of the coefficients that can be read from the data.

    `tire`: in adapted SAE; its effects determine the coefficients. `table`: measured rows in adapted SAE. Returns:
    within the bounds of the coefficients' declarations, in adapted SAE.
    """
    live = tire.symbolic_model.live(tire.has)
    values: dict[str, float] = {}
    for name, reading in readings(table).items():
        role = tire.symbolic_model.roles.get(name, Role(""))
        names = [name for name in role.coefficients if name in live][: len(reading.loads)]
        if names:
            values.update(_solved(tire, role.quantity, reading, names))
    return values


def _pure(table: pd.DataFrame, force: str, slip: str, other: str) -> list[pd.DataFrame]:
    """Return the rows of pure slip at the smallest inclination, by load."""
    if force not in table or slip not in table or "Fz" not in table:
        return []
    chosen = table[force].notna().to_numpy() & (table["Fz"].to_numpy() > 0)
    if other in table:
        chosen &= np.abs(table[other].to_numpy()) <= PURE[other]
    if "gamma" in table and chosen.any():
        inclined = np.abs(table["gamma"].to_numpy())
        chosen &= inclined <= inclined[chosen].min() + PURE["gamma"]
    rows = table[chosen]
    if len(rows) < MIN_ROWS:
        return []
    load = rows["Fz"].to_numpy()
    held = np.array(levels(rows["Fz"]))
    if len(held):
        nearest = np.abs(load[:, None] - held).argmin(axis=1)
    else:
        nearest = np.searchsorted(np.quantile(load, np.linspace(0, 1, PARTS + 1)[1:-1]), load)
    parts = (rows[nearest == number] for number in np.unique(nearest))
    return [part.sample(MAX_ROWS, random_state=0) if len(part) > MAX_ROWS else part for part in parts]


def _curve(slip: FloatArray, force: FloatArray) -> dict[str, float]:
    """Return slope at zero, shift, and height if the sweep reaches the peak; empty without a slope."""
    if len(slip) < MIN_ROWS or not slip.min() < 0 < slip.max():
        return {}
    size, reach = float(np.quantile(np.abs(force), SIZE_QUANTILE)), float(np.abs(slip).max())
    if not size > 0:
        return {}
    # Typical sizes of the four parameters of a saturating curve: slope, height, shift, shape.
    typical = np.array([2.0 * size / reach, size, 0.1 * reach, 1.0])

    def residual(x: FloatArray) -> FloatArray:
        slope, height, shift, shape = x * typical
        curve = height * np.sin(shape * np.arctan(slope / (shape * height) * (slip + shift)))
        return np.asarray((curve - force) / size)

    bounds = ([0.01, 0.2, -10.0, 1.0], [100.0, 5.0, 10.0, 2.2])
    slope, height, shift, shape = (
        least_squares(residual, [1.0, 1.0, 0.0, 1.5], bounds=bounds, loss="soft_l1", f_scale=0.1).x * typical
    )
    flat = np.sin(min(shape * np.arctan(slope / (shape * height) * reach), pi / 2.0)) >= FLATTENED
    return {"slope": float(slope), "shift": float(shift), **({"height": float(height)} if flat else {})}


def _trail(part: pd.DataFrame) -> dict[str, float]:
    """Return the trail at zero slip and its rate of decrease, from aligning moment and side force."""
    part = part[part["Mz"].notna()] if "Mz" in part else part[:0]
    if len(part) < MIN_ROWS:
        return {}
    alpha, force, moment = (part[name].to_numpy(dtype=float) for name in ("alpha", "Fy", "Mz"))
    size, reach = float(np.quantile(np.abs(moment), SIZE_QUANTILE)), float(np.abs(alpha).max())
    if not size > 0:
        return {}
    arm = size / float(np.quantile(np.abs(force), SIZE_QUANTILE))
    typical = np.array([2.0 * arm, 2.0 / reach, 0.1 * size])

    def residual(x: FloatArray) -> FloatArray:
        trail, fall, offset = x * typical
        return np.asarray((offset - trail * np.cos(TRAIL_SHAPE * np.arctan(fall * alpha)) * force - moment) / size)

    bounds = ([0.01, 0.01, -10.0], [20.0, 20.0, 10.0])
    trail, fall, _ = least_squares(residual, [1.0, 1.0, 0.0], bounds=bounds, loss="soft_l1", f_scale=0.1).x * typical
    return {"trail": float(trail), "trail_fall": float(fall)}


def _solved(tire: Tire, quantity: str, reading: Reading, names: list[str]) -> dict[str, float]:
    """Return the coefficients by least squares between a quantity and its reading."""
    model, code = tire.symbolic_model, fastest_code(tire.symbolic_model, len(reading.loads))
    index = code.quantities_names.index(quantity)
    order = list(model.parameters)
    columns = [order.index(name) for name in names]
    points = np.array([np.full(len(reading.loads), tire.nominal(name)) for name in tire.inputs])
    for name, row in zip(tire.inputs, points, strict=True):
        row[:] = reading.loads if name == "Fz" else 0.0 if name in ("kappa", "alpha", "gamma", "phit") else row
    declarations = [model.coefficients[name] for name in names]
    factors = np.array([tire.rescaled.get(name, 1.0) for name in names])
    size = float(np.abs(reading.values).max()) or 1.0

    def residual(x: FloatArray) -> FloatArray:
        parameters = tire.parameters()
        parameters[columns] = x * factors
        return np.asarray((code.quantities(points, parameters)[index] - reading.values) / size)

    lower, upper = (
        np.array([getattr(declaration, side) for declaration in declarations]) for side in ("lower", "upper")
    )
    start = np.clip([declaration.generic for declaration in declarations], lower + 1e-6, upper - 1e-6)
    solution = least_squares(residual, start, bounds=(lower, upper), x_scale=np.maximum(np.abs(start), 0.1))
    return {name: float(value) for name, value in zip(names, solution.x, strict=True)}
