"""What no entry of a car explains: side forces of its axles that grow with the motion, of a size that is estimated.

A car has more than its model, and a tire more than its formula. The difference is a side force of each axle in
proportion to that of its tires, changed smoothly by size, longitudinal acceleration, speed and time, and late by a
time that changes with the size, as relaxation, roll and compliance make it. What the size changes is another curve
over the slip: a factor of the tire is found only beyond it. Its coefficients are unknowns like those of the car, with
one standard deviation that maximizes the evidence. What data contradict shows the size of what they cannot see: an
error in proportion to the force looks like a factor of the tire (Kennedy and O'Hagan, Bayesian calibration of
computer models, JRSS B 63, 2001; Brynjarsdottir and O'Hagan, Inverse Problems 30, 2014).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from ....measurements.units import GRAVITY
from ..inputs.car import USUAL_WHEELBASE
from ..inputs.grid import Grid

FloatArray = npt.NDArray[np.float64]

#: Standard deviation of a coefficient before any data, relative to the required force, and how many coefficients it is
#: worth. Judgement: side forces of repeated tests differ by 0.5 %.
USUAL, WORTH = 0.005, 4.0
#: Standard deviation of the coefficients of the curve of the force over the slip, which data hardly contradict.
#: Judgement: a Magic Formula differs from bench data by 1 %, and the tires of a car from those of the bench by as much.
FORM = 0.01
#: Numbers of the columns of an axle and, of these, of the curve; which of all columns have the estimated size.
N_COLUMNS, N_FORM = 12, 3
SIZED = np.arange(2 * N_COLUMNS) % N_COLUMNS >= N_FORM
#: Longitudinal acceleration per g that changes a force by one coefficient; time by which the force of a typical car is
#: late, s, and its square for masses that move against the body, s^2. Judgement: of the typical size they are 10 ms and
#: (40 ms)^2; relaxation, roll and compliance between body and wheels make forces late by 10 to 40 ms.
ACCELERATION, TIME, INERTIA = 0.3, 2.0, 0.3
#: Smallest and largest size. Judgement: a drive does not show less of what it cannot see; what is larger is no small
#: error of a car, but a contradiction to see.
SMALLEST, LARGEST = USUAL, 0.01


def discrepancy_columns(
    grid: Grid, states: FloatArray, entries: Mapping[str, float], beyond: FloatArray, size: float
) -> tuple[FloatArray, FloatArray]:
    """Return the side forces of both axles per static load for a coefficient of 1, shape (n, 2, n_columns).

    Second: the same over the side forces of the tires, 0 for late ones. Coefficients are standardized. `beyond`, shape
    (n, 2): side force that the motion requires beyond the tires', per static load. The columns follow from the tires'
    part: in proportion to all that the motion requires, they would shrink the noise of accelerations.
    """
    left, right = states[grid.left], states[grid.right]
    vx, vy, yaw_rate = (left + right)[:, :3].T / 2
    vx_dot, vy_dot, turning = (right - left)[:, :3].T / grid.step
    ax, ay = vx_dot - vy * yaw_rate, vy_dot + vx * yaw_rate
    radius = entries["yaw_inertia"] / entries["mass"]
    speed, time = vx / vx.mean() - 1.0, 2.0 * (grid.t - grid.t[0]) / max(np.ptp(grid.t), grid.step) - 1.0
    slower = np.sqrt(entries["wheelbase"] / USUAL_WHEELBASE)  # similar cars
    inner = np.pad(grid.segment[2:] == grid.segment[:-2], 1)
    columns, relative = [], []
    for axle, arm in enumerate((entries["cg_to_rear"], -entries["cg_to_front"])):
        force = (ay + radius / arm * turning) / GRAVITY - beyond[:, axle]
        share = np.abs(force) / max(np.abs(force).max(), 1e-9)
        rate = np.where(inner, slower * np.gradient(force, grid.step), 0.0)
        bend = np.where(inner, slower * np.gradient(rate, grid.step), 0.0)
        along = ax / (ACCELERATION * GRAVITY)
        driving, braking = np.maximum(along, 0.0), np.minimum(along, 0.0)
        curve = [FORM * share**power for power in range(N_FORM)]
        changes = [size * shape for shape in (driving, braking, driving * share, braking * share, speed, time)]
        late = [size * shape for shape in (TIME * rate, TIME * rate * share**2, INERTIA * bend)]
        at_axle = (np.arange(2) == axle)[:, None]
        proportional = np.stack([*curve, *changes, *(0.0 * shape for shape in late)], axis=1)[:, None] * at_axle
        delayed = np.stack([*(0.0 * shape for shape in (*curve, *changes)), *late], axis=1)[:, None] * at_axle
        relative.append(proportional)
        columns.append(proportional * force[:, None, None] + delayed)
    return np.concatenate(columns, axis=2), np.concatenate(relative, axis=2)


def size_of(size: float, deviations: FloatArray, variances: FloatArray) -> float:
    """Return the next size from standardized coefficients that have it and their posterior variances (MacKay)."""
    determined = float(np.sum(1.0 - np.minimum(variances, 1.0)))
    squares = size**2 * float(deviations @ deviations) + WORTH * USUAL**2
    return float(np.clip(np.sqrt(squares / (determined + WORTH)), SMALLEST, LARGEST))
