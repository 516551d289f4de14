"""The simulated vehicle over the recorded steering and speed, in pieces of a few seconds, against the log."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.vehicle.quantities import CORNERS
from tirefmu.tires import Tire
from tirefmu.tires.code.modules import two_track

from .estimate import Estimate
from .inputs.car import Car
from .inputs.grid import MEASURED, Grid
from .interval import BODY, OUTPUTS
from .unknowns import AXLES, Unknowns

FloatArray = npt.NDArray[np.float64]

#: Length of a piece, s; Heun steps of an interval of the grid.
HORIZON, SUBSTEPS = 2.0, 4


@dataclass(frozen=True)
class Simulation:
    """Motion simulated from the estimated state at the start of each piece, NaN outside of pieces.

    `motion`, shape (n, 3): yaw rate, ay and lateral speed at the intervals. `rms`: of their errors, by name.
    """

    motion: FloatArray
    rms: Mapping[str, float]


def simulated(
    grid: Grid, estimate: Estimate, unknowns: Unknowns, car: Car, tires: Mapping[str, Tire], *, known_car: bool
) -> Simulation:
    """Simulate a car on its tires. `known_car`: with the estimated entries of the car, not those of its file."""
    estimated = unknowns.car_values(estimate.z)
    p = {**car.values, **(estimated if known_car else {})}
    p["cg_to_rear"] = p["wheelbase"] - p["cg_to_front"]
    body = [p[entry] for entry in BODY.values()]
    length = round(HORIZON / grid.step)
    starts = [
        first
        for first in range(0, len(grid.t) - length + 1, length)
        if grid.segment[first] == grid.segment[first + length - 1]
    ]
    rows = np.array(starts)[:, None] + np.arange(length)
    # The offset of the steering is one of the log: both cars drive with it.
    steer = grid.steer[:, rows] * car.values["ratio"] / p["ratio"] + estimated.get("offset", car.values["offset"])
    speed = estimate.states[:, 0]
    kappa = estimate.outputs.values[:, [OUTPUTS.index(f"kappa_{axle}") for axle in AXLES]][rows]
    state = estimate.states[grid.left[rows[:, 0]], 1:3].T
    acceleration = np.zeros((2, len(rows)))
    motion = np.full((len(grid.t), 3), np.nan)
    for k in range(length):
        at = rows[:, k]
        ends = speed[grid.left[at]], speed[grid.right[at]]
        along = (ends[1] - ends[0]) / grid.step
        before = state
        for i in range(SUBSTEPS):
            share = (i + 0.5) / SUBSTEPS
            vx = ends[0] + share * (ends[1] - ends[0])
            angle = steer[0, :, k] + share * (steer[1, :, k] - steer[0, :, k])
            h = grid.step / SUBSTEPS
            first, acceleration = _rates(vx, along, state, angle, kappa[:, k], acceleration, body, tires)
            second, acceleration = _rates(vx, along, state + h * first, angle, kappa[:, k], acceleration, body, tires)
            state = state + h / 2 * (first + second)
        mean = (before + state) / 2
        motion[at] = np.stack(
            [mean[1], (state[0] - before[0]) / grid.step + mean[1] * (ends[0] + ends[1]) / 2, mean[0]], axis=1
        )
    return Simulation(motion, _errors(motion, grid, estimate, unknowns, car))


def _rates(
    vx: FloatArray, along: FloatArray, state: FloatArray, steer: FloatArray, kappa: FloatArray, last: FloatArray,
    body: list[float], tires: Mapping[str, Tire],
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Return the rates of lateral speed and yaw rate, twice: as rates, and as those from which loads follow."""
    vy, yaw_rate = state
    wheels = np.array(two_track.wheels(vx, vy, yaw_rate, along, *last, steer, *body))
    alpha, V, Fz = wheels.reshape(3, len(CORNERS), -1)
    Fx, Fy = np.empty_like(alpha), np.empty_like(alpha)
    for i, axle in enumerate(AXLES):
        some = slice(2 * i, 2 * i + 2)
        forces = tires[axle].forces(kappa=kappa[:, i], alpha=alpha[some], Fz=Fz[some], V=V[some], code="numpy")
        Fx[some], Fy[some] = forces["Fx"].mean(axis=0), forces["Fy"]
    _, vy_rate, turning = two_track.accelerations(vx, vy, yaw_rate, steer, *body, *Fx, *Fy)
    rates = np.array([vy_rate, turning])
    return rates, rates


def _errors(motion: FloatArray, grid: Grid, estimate: Estimate, unknowns: Unknowns, car: Car) -> dict[str, float]:
    """Return the rms of simulated minus measured motion, offsets removed; of the estimate where it is not measured."""
    p = {**car.values, **unknowns.car_values(estimate.z)}
    middle = (estimate.states[grid.left] + estimate.states[grid.right]) / 2
    rate = (estimate.states[grid.right] - estimate.states[grid.left]) / grid.step
    yaw_rate = grid.means[MEASURED.index("yaw_rate")]
    # ay and lateral speed are compared at the center of gravity, where they are estimated.
    references = {
        "yaw_rate": np.where(np.isfinite(yaw_rate), yaw_rate - p["yaw_rate_offset"], middle[:, 2]),
        "ay": rate[:, 1] + middle[:, 2] * middle[:, 0],
        "vy": middle[:, 1],
    }
    known = np.isfinite(motion[:, 0])
    return {
        name: float(np.sqrt(np.mean((motion[known, i] - reference[known]) ** 2))) if known.any() else float("nan")
        for i, (name, reference) in enumerate(references.items())
    }
