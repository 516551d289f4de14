"""What a program should determine: forces, friction, slip stiffness, or coefficients, each with its sensitivities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from tirefmu.boundary.errors import UnknownName
from tirefmu.fitting.uncertainty.sensitivities import sensitivities
from tirefmu.tires import Tire

from .bench_file import SWEPT, Bench
from .information import Experiment
from .maneuvers import held_levels

FloatArray = npt.NDArray[np.float64]

#: Quantities of an aim, by role; the forces are aims by their names.
ROLES = {
    "friction": ("friction_x", "friction_y"), "stiffness": ("stiffness_x", "stiffness_y"),
}  # fmt: skip
AIMS = ("all", "forces", *ROLES)
#: Slips and loads of the operating points.
SLIPS, LOADS = 9, 3
#: The slip over which a channel is an aim.
OWN_SLIP = {"Fx": "kappa", "Fy": "alpha", "Mz": "alpha"}
#: Scale, N, N m or 1, below which a quantity is 0 for a tire.
SMALLEST = 1e-6
#: Standard normal quantile of a two-sided 95 % interval.
QUANTILE = 1.959964


@dataclass(frozen=True, eq=False)
class Target:
    """A quantity at operating points.

    - `name`: a channel, a role or a coefficient.
    - `inputs`, shape (u, n): the operating points; empty for a coefficient.
    - `values`, `scales`, shape (t, n): of each tire, and to what its error is relative.
    - `rows`, shape (t, n, p): derivatives by the coefficients in sizes, relative to the scales.
    """

    name: str
    inputs: FloatArray
    values: FloatArray
    scales: FloatArray
    rows: FloatArray

    def widths(self, covariances: FloatArray) -> FloatArray:
        """Return the relative half width of the 95 % interval at each operating point, by tire, shape (t, n)."""
        variances = np.einsum("tnp,tpq,tnq->tn", self.rows, covariances, self.rows)
        return np.asarray(QUANTILE * np.sqrt(np.maximum(variances, 0.0)))

    def width(self, covariances: FloatArray) -> float:
        """Return the root mean square of the widths."""
        return float(np.sqrt(np.mean(self.widths(covariances) ** 2)))

    @property
    def squares(self) -> FloatArray:
        """Mean square of the rows, shape (t, p, p): its trace with a covariance is the mean relative variance."""
        return np.asarray(np.einsum("tnp,tnq->tpq", self.rows, self.rows) / self.rows.shape[1])


def targets(experiment: Experiment, bench: Bench, aims: Sequence[str] = ("all",)) -> tuple[Target, ...]:
    """Return the quantities of some aims.

    `aims`: of `AIMS`, or names of coefficients. Raises `UnknownName` if there is no such aim.
    """
    found: list[Target] = []
    for aim in aims:
        if aim in ("all", "forces"):
            found += [_force(experiment, bench, channel) for channel in experiment.channels]
        for name, roles in ROLES.items():
            if aim in ("all", name):
                model = experiment.tires[0].symbolic_model
                available = [role for role in roles if role in model.roles and _swept(bench, role)]
                found += [_quantity(experiment, bench, role) for role in available]
        if aim in experiment.free:
            found.append(_coefficient(experiment, aim))
        elif aim not in AIMS:
            raise UnknownName("aim", aim, (*AIMS, *experiment.free))
    return tuple(target for target in found if target.rows.any() and target.scales.min() > SMALLEST)


def _swept(bench: Bench, role: str) -> bool:
    """Return whether the bench has the slip of a role."""
    return {"x": "kappa", "y": "alpha"}[role[-1]] in bench.limits


def operating_points(bench: Bench, tire: Tire, channel: str) -> FloatArray:
    """Return operating points of a channel within the range of the bench, shape (u, n): pure and combined slip."""
    nominal = held_levels(bench, tire)
    ranges = {name: (limits.low, limits.high) for name, limits in bench.limits.items()}
    own = OWN_SLIP[channel]
    (other,) = (name for name in SWEPT if name != own)
    slips = np.linspace(*ranges.get(own, (0.0, 0.0)), SLIPS).tolist()
    levels: list[dict[str, float]] = [{}]
    levels += [{name: end} for name in ("gamma", "p") if name in tire.inputs for end in ranges.get(name, ())]
    levels += [{other: 0.5 * end} for end in ranges.get(other, ()) if channel != "Mz"]
    loads = np.linspace(*ranges.get("Fz", (nominal["Fz"],) * 2), LOADS).tolist()
    points = [{**nominal, "Fz": load, own: slip, **level} for load, level, slip in product(loads, levels, slips)]
    return np.array([[point.get(name, tire.nominal(name)) for name in tire.inputs] for point in points]).T


def _force(experiment: Experiment, bench: Bench, channel: str) -> Target:
    """Return a channel at its operating points, relative to its largest value at the same load."""
    inputs = operating_points(bench, experiment.tires[0], channel)
    output = experiment.channels.index(channel)
    loads, values, scales, rows = inputs[experiment.tires[0].inputs.index("Fz")], [], [], []
    for tire in experiment.tires:
        forces, by_coefficients, _ = experiment.derivatives(tire, inputs)
        size = np.array([np.abs(forces[output, loads == load]).max() for load in loads])
        values.append(forces[output])
        scales.append(np.maximum(size, 1e-9))
        rows.append(by_coefficients[:, output] / scales[-1][:, None])
    return Target(channel, inputs, np.array(values), np.array(scales), np.array(rows))


def _quantity(experiment: Experiment, bench: Bench, role: str) -> Target:
    """Return a named quantity without slip at some loads, relative to its value."""
    tire = experiment.tires[0]
    nominal = held_levels(bench, tire)
    limits = bench.limits.get("Fz")
    loads = np.linspace(limits.low, limits.high, LOADS + 2) if limits else np.array([nominal["Fz"]])
    inputs = np.array(
        [loads if n == "Fz" else np.full(len(loads), nominal.get(n, tire.nominal(n))) for n in tire.inputs]
    )
    values, rows = [], []
    for one in experiment.tires:
        value, slopes, names = sensitivities(one, one.symbolic_model.quantity(role), inputs)
        by_coefficients = np.zeros((len(loads), len(experiment.free)))
        for i, name in enumerate(experiment.free):
            if name in names:
                by_coefficients[:, i] = slopes[names.index(name)] * experiment.sizes[i]
        values.append(value)
        rows.append(by_coefficients / np.maximum(np.abs(value), 1e-9)[:, None])
    return Target(role, inputs, np.array(values), np.maximum(np.abs(np.array(values)), 1e-9), np.array(rows))


def _coefficient(experiment: Experiment, name: str) -> Target:
    """Return a coefficient, relative to its typical size."""
    index, count = experiment.free.index(name), len(experiment.tires)
    rows = np.zeros((count, 1, len(experiment.free)))
    rows[:, 0, index] = 1.0
    values = np.array([[tire.values[name]] for tire in experiment.tires])
    scales = np.full((count, 1), experiment.sizes[index])
    return Target(name, np.zeros((len(experiment.tires[0].inputs), 0)), values, scales, rows)
