"""What lags within the car add to the motion of a moment: load transfer behind acceleration, forces behind slip angles.

A lag follows from the motion before, which one interval does not have. It is computed from the estimated motion in each
round; an interval has its derivatives by the time constants, and the relaxation of slip angles to the first order.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from ....symbolic.vehicle.quantities import CORNERS
from ....tires.code.modules import two_track
from ..evaluation import curvature_of
from ..inputs.car import Car
from ..inputs.grid import Grid
from ..inputs.unknowns import AXLES
from ..interval import BODY, SUSPENSION, Interval, nominal_length

FloatArray = npt.NDArray[np.float64]

#: Change of a time constant for its derivative, relative; parts of an interval in which a lag is computed.
CHANGE, PARTS = 0.1, 4


def wheel_motion(grid: Grid, states: FloatArray, car: Car, entries: Mapping[str, float]) -> FloatArray:
    """Return slip angle, speed, load and inclination of each wheel in the middle of the intervals, shape (4, 4, n).

    Slip angles do not lag.
    """
    body, suspension = [entries[name] for name in BODY.values()], [entries[name] for name in SUSPENSION]
    middle, rate = _motion(grid, states)
    more = entries["delay"] - grid.used[0], entries["lag"] - grid.used[1]
    ends = grid.steer + grid.steer_slopes[:2] * more[0] + grid.steer_slopes[2:] * more[1]
    steer = ends.mean(axis=0)
    inner = np.pad(grid.segment[2:] == grid.segment[:-2], 1)
    bend = np.where(inner, np.diff(steer, 2, prepend=0.0, append=0.0), 0.0)
    angle = entries["offset"] + car.values["ratio"] / entries["ratio"] * (steer - bend / 24)
    *turned, gamma = two_track.turned(*middle, *rate, *grid.behind[:2], angle, *suspension)
    wheels = np.array(two_track.wheels(*middle, *rate, *grid.behind[:2], *turned, *body)).reshape(3, len(CORNERS), -1)
    return np.concatenate([wheels, np.broadcast_to(gamma, wheels[:1].shape)])


def _motion(grid: Grid, states: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the motion in the middle of the intervals, and its mean rates, shape (3, n) each."""
    ends = states[grid.left][:, :3].T, states[grid.right][:, :3].T
    return (ends[0] + ends[1]) / 2 - curvature_of(grid, states)[:, :3].T / 8, (ends[1] - ends[0]) / grid.step


def with_lags(grid: Grid, interval: Interval, states: FloatArray, car: Car, entries: Mapping[str, float]) -> Grid:
    """Return a grid with what lags add for the motion of the nodes and for entries of the car."""
    middle, rate = _motion(grid, states)
    acceleration = np.stack([rate[0] - middle[1] * middle[2], rate[1] + middle[0] * middle[2]])
    slip, V, Fz, _ = wheel_motion(grid, states, car, entries)
    lengths = np.concatenate(
        [np.interp(Fz[2 * i : 2 * i + 2], *interval.lengths[axle]) for i, axle in enumerate(AXLES)]
    )
    nominal = np.array([[nominal_length(interval.lengths[axle])] for axle in AXLES for _ in "lr"])
    times = np.broadcast_to([[entries["pitch_lag"]], [entries["roll_lag"]]], acceleration.shape)
    constants = np.concatenate([times, (1 + CHANGE) * times, entries["relaxation"] * lengths / V])
    inputs = np.concatenate([acceleration, acceleration, slip])
    behind, slopes = (np.empty_like(inputs) for _ in "12")
    for number in np.unique(grid.segment):
        rows = grid.segment == number
        behind[:, rows], slopes[:, rows] = behind_lags(inputs[:, rows], constants[:, rows], grid.step)
    by_time = (behind[2:4] - behind[:2]) / np.maximum(CHANGE * times, 1e-9)
    beyond = behind[4:] + entries["relaxation"] * nominal / V * slopes[4:]
    used = (*grid.used[:2], entries["pitch_lag"], entries["roll_lag"])
    return replace(grid, behind=np.concatenate([behind[:2], by_time, beyond]), used=used)


def behind_lags(inputs: FloatArray, constants: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
    """Return what first-order lags add to inputs at even times, and the slopes of the inputs, shape (n_inputs, n) each.

    `constants`: time constants, s. The inputs are splines; they begin as if their first slope had lasted.
    """
    at = np.arange(inputs.shape[1]) * step
    curve = CubicSpline(at, inputs, axis=1)
    fine = np.arange((len(at) - 1) * PARTS + 1) * step / PARTS
    values, times = curve(fine), np.stack([np.interp(fine, at, row) for row in constants])
    slopes = np.diff(values, append=values[:, -1:]) / (step / PARTS)
    kept = np.exp(-step / PARTS / np.maximum(times, 1e-9))
    rest = values - slopes * times
    steady = (1.0 - kept) * rest + slopes * step / PARTS
    result = np.empty_like(values)
    result[:, 0] = rest[:, 0]
    for k in range(len(fine) - 1):
        result[:, k + 1] = kept[:, k] * result[:, k] + steady[:, k]
    return (result - values)[:, ::PARTS], curve(at, 1)
