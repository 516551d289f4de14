"""What lags within the car add to the motion of a moment: load transfer behind acceleration, forces behind slip angles.

A lag follows from the motion before, which one interval does not have. It is computed from the estimated motion in each
round; an interval has its derivatives by the time constants.
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
from ..interval import BODY, SUSPENSION, Interval

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
    laws = [interval.relaxations[axle] for axle in AXLES]
    lateral = np.concatenate([law.at(Fz[2 * i : 2 * i + 2]) for i, law in enumerate(laws)]) / V
    stretch = [
        entries["relaxation"] * entries[f"LKY_{axle}"] ** law.power for axle, law in zip(AXLES, laws, strict=True)
    ]
    constants = np.array([entries["pitch_lag"], entries["roll_lag"], *np.repeat(stretch, 2)])[:, None]
    times = constants * np.concatenate([np.ones_like(acceleration), lateral])
    inputs = np.concatenate([acceleration, slip])
    behind, changed = (np.empty_like(inputs) for _ in "12")
    for number in np.unique(grid.segment):
        rows = grid.segment == number
        both = np.concatenate([times[:, rows], (1 + CHANGE) * times[:, rows]])
        behind[:, rows], changed[:, rows] = np.split(behind_lags(inputs[:, rows], both, grid.step), 2)
    by_time = (changed - behind) / np.maximum(CHANGE * constants, 1e-9)
    parts = behind[:2], by_time[:2], behind[2:], by_time[2:]
    used = (*grid.used[:3], entries["pitch_lag"], entries["roll_lag"], *stretch)
    return replace(grid, behind=np.concatenate(parts), used=used)


def behind_lags(inputs: FloatArray, constants: FloatArray, step: float) -> FloatArray:
    """Return what first-order lags add to inputs at even times, shape (n_constants, n).

    `constants`: time constants, s, which go through the inputs once or more. The inputs are splines; they begin as if
    their first slope had lasted.
    """
    at = np.arange(inputs.shape[1]) * step
    curve = CubicSpline(at, inputs, axis=1)
    fine = np.arange((len(at) - 1) * PARTS + 1) * step / PARTS
    times = CubicSpline(at, constants, axis=1)(fine)
    values = np.tile(curve(fine), (len(constants) // len(inputs), 1))
    slopes = np.diff(values, append=values[:, -1:]) / (step / PARTS)
    kept = np.exp(-step / PARTS / np.maximum(times, 1e-9))
    rest = values - slopes * times
    steady = (1.0 - kept) * rest + slopes * step / PARTS
    result = np.empty_like(values)
    result[:, 0] = rest[:, 0]
    for k in range(len(fine) - 1):
        result[:, k + 1] = kept[:, k] * result[:, k] + steady[:, k]
    return np.asarray((result - values)[:, ::PARTS])
