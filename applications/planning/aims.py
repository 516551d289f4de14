"""What a program should determine: forces, friction, slip stiffness, or coefficients, each with its sensitivities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from ...boundary.errors import UnknownName
from ...fitting.problem.weighted_residuals import coefficients_by_output
from ...fitting.uncertainty.sensitivities import sensitivities
from ...tires import Tire
from .bench_file import SWEPT, Bench
from .information import Experiment
from .maneuvers import held_levels

FloatArray = npt.NDArray[np.float64]
#: Quantities of an aim, by role; the forces are aims by their names. The slip over which each is an aim.
ROLES = {"friction": ("friction_x", "friction_y"), "stiffness": ("stiffness_x", "stiffness_y")}
AIMS = ("all", "forces", *ROLES)
SLIP = {
    "Fx": "kappa", "Fy": "alpha", "Mz": "alpha", "friction_x": "kappa", "friction_y": "alpha", "stiffness_x": "kappa",
    "stiffness_y": "alpha",
}  # fmt: skip
#: Slips and loads of the operating points of a force; loads of a quantity.
SLIPS, LOADS, QUANTITY_LOADS = 9, 3, 5
#: Scale, N, N m or 1, below which a quantity is 0 for a tire.
SMALLEST = 1e-6
#: Standard normal quantile of a two-sided 95 % interval.
QUANTILE = 1.959964


@dataclass(frozen=True, eq=False)
class Target:
    """A quantity at operating points.

    - `name`: a channel, a role or a coefficient. `slip`: over which the bench varies it.
    - `inputs`, shape (u, n): the operating points; empty for a coefficient.
    - `values`, `scales`, shape (t, n): of each tire, and to what its error is relative.
    - `rows`, shape (t, n, p): derivatives by the coefficients in sizes, relative to the scales.
    """

    name: str
    slip: str
    inputs: FloatArray
    values: FloatArray
    scales: FloatArray
    rows: FloatArray

    def width(self, covariances: FloatArray) -> float:
        """Return the relative half width of the 95 % interval, root mean square over operating points and tires."""
        variances = np.einsum("tpq,tpq->t", self.squares, covariances)
        return float(QUANTILE * np.sqrt(np.maximum(variances, 0.0).mean()))

    @property
    def squares(self) -> FloatArray:
        """Mean square of the rows, shape (t, p, p): its trace with a covariance is the mean relative variance."""
        return np.asarray(np.einsum("tnp,tnq->tpq", self.rows, self.rows) / self.rows.shape[1])


def targets(experiment: Experiment, bench: Bench, aims: Sequence[str] = ("all",)) -> tuple[Target, ...]:
    """Return the quantities of some aims.

    `aims`: of `AIMS`, or names of coefficients. Raises `UnknownName` if there is no such aim.
    """
    tire, wanted = experiment.tires[0], list[Target]()
    for aim in aims:
        if aim in experiment.free:
            wanted.append(_coefficient(experiment, aim))
        elif aim not in AIMS:
            raise UnknownName("aim", aim, (*AIMS, *experiment.free))
        if aim in ("all", "forces"):
            wanted += [_of_tires(experiment, name, _force_points(bench, tire, name)) for name in experiment.channels]
        for role in (role for name in ROLES if aim in ("all", name) for role in ROLES[name]):
            if role in tire.symbolic_model.roles and SLIP[role] in bench.limits:
                wanted.append(_of_tires(experiment, role, _load_points(bench, tire)))
    return tuple(target for target in wanted if target.rows.any() and target.scales.min() > SMALLEST)


def _force_points(bench: Bench, tire: Tire, channel: str) -> FloatArray:
    """Return operating points of a channel within the range of the bench, shape (u, n): pure and combined slip."""
    nominal, slip = held_levels(bench, tire), SLIP[channel]
    ranges = {name: (limits.low, limits.high) for name, limits in bench.limits.items()}
    (other,) = (name for name in SWEPT if name != slip)
    levels: list[dict[str, float]] = [{}]
    levels += [{name: end} for name in ("gamma", "p") if name in tire.inputs for end in ranges.get(name, ())]
    levels += [{other: 0.5 * end} for end in ranges.get(other, ()) if channel != "Mz"]
    slips = np.linspace(*ranges.get(slip, (0.0, 0.0)), SLIPS).tolist()
    loads = np.linspace(*ranges.get("Fz", (nominal["Fz"],) * 2), LOADS).tolist()
    points = [{**nominal, "Fz": load, slip: value, **level} for load, level, value in product(loads, levels, slips)]
    return np.array([[point.get(name, tire.nominal(name)) for name in tire.inputs] for point in points]).T


def _load_points(bench: Bench, tire: Tire) -> FloatArray:
    """Return operating points without slip at some loads, shape (u, n)."""
    nominal, limits = held_levels(bench, tire), bench.limits.get("Fz")
    loads = np.linspace(limits.low, limits.high, QUANTITY_LOADS) if limits else np.array([nominal["Fz"]])
    levels = [loads if name == "Fz" else nominal.get(name, tire.nominal(name)) for name in tire.inputs]
    return np.array(np.broadcast_arrays(*levels))


def _of_tires(experiment: Experiment, name: str, inputs: FloatArray) -> Target:
    """Return a channel, relative to its largest value at the same load, or a quantity, relative to its value."""
    loads, forces = inputs[experiment.tires[0].inputs.index("Fz")], name in experiment.channels
    values, scales, rows = [], [], []
    for tire in experiment.tires:
        quantity = name if forces else tire.symbolic_model.quantity(name)
        value, slopes, names = sensitivities(tire, quantity, inputs)
        by_name = dict(zip(names, slopes, strict=True))
        by_coefficients = np.array([by_name.get(n, 0.0 * value) for n in experiment.free]).T * experiment.sizes
        values.append(value)
        size = np.array([np.abs(value[loads == load]).max() for load in loads]) if forces else np.abs(value)
        scales.append(np.maximum(size, 1e-9))
        rows.append(np.nan_to_num(by_coefficients) / scales[-1][:, None])
    return Target(name, SLIP[name], inputs, np.array(values), np.array(scales), np.array(rows))


def _coefficient(experiment: Experiment, name: str) -> Target:
    """Return a coefficient, relative to its typical size."""
    index, count = experiment.free.index(name), len(experiment.tires)
    rows = np.zeros((count, 1, len(experiment.free)))
    rows[:, 0, index] = 1.0
    values = np.array([[tire.values[name]] for tire in experiment.tires])
    scales = np.full((count, 1), experiment.sizes[index])
    lateral = coefficients_by_output(experiment.tires[0].symbolic_model, plain=True).get("Fy", ())
    slip, inputs = "alpha" if name in lateral else "kappa", np.zeros((len(experiment.tires[0].inputs), 0))
    return Target(name, slip, inputs, values, scales, rows)
