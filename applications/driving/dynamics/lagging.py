"""What lags within the car add to the motion of a moment: load transfer behind acceleration, forces behind slip angles.

And what heave adds: side forces lift the body (jacking), a mass on springs; while it rises or falls, all loads differ.

A lag follows from the motion before, which one interval does not have. It is computed from the estimated motion in each
round; an interval has its derivatives by the time constants.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from ....symbolic.vehicle.quantities import CORNERS
from ....tires.code.modules import two_track
from ....tires.states.transient import held_system, recursion, vector_recursion
from ..evaluation import curvature_of
from ..inputs.car import Car
from ..inputs.grid import Grid
from ..inputs.unknowns import AXLES
from ..interval import BODY, SUSPENSION, Interval

FloatArray = npt.NDArray[np.float64]

#: Change of a time constant for its derivative, relative; parts of an interval in which a lag is computed.
CHANGE, PARTS = 0.1, 4
#: Damping of the vertical motion of a body over the critical one. Judgement: cars have 0.25 to 0.4.
DAMPING = 0.3


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
    heave = entries["lift"] * grid.behind[16]
    wheels = two_track.wheels(*middle, *rate, *grid.behind[:2], heave, *turned, *body)
    wheels = np.array(wheels).reshape(3, len(CORNERS), -1)
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
    stiffer = {axle: entries[f"LKY_{axle}"] for axle in AXLES}
    stretch = _stretch(interval, "y", entries, stiffer)
    along = _stretch(
        interval, "x", entries, {axle: k * entries[f"slip_stiffness_{axle}"] for axle, k in stiffer.items()}
    )
    lateral, longitudinal = (
        np.concatenate([interval.relaxations[axle, of].at(Fz[2 * i : 2 * i + 2]) for i, axle in enumerate(AXLES)]) / V
        for of in "yx"
    )
    constants = np.array([entries["pitch_lag"], entries["roll_lag"], *np.repeat(stretch, 2)])[:, None]
    times = constants * np.concatenate([np.ones_like(acceleration), lateral])
    times = np.concatenate([times, np.repeat(along, 2)[:, None] * longitudinal])
    inputs = np.concatenate([acceleration, slip, measured_slips(grid, V, car, entries)])
    late, longer = np.empty((2, *inputs.shape)), (1.0, 1.0 + CHANGE)
    period, heave = entries["heave_period"], np.empty((2, len(grid.t)))
    chains = np.split(np.arange(len(grid.t)), np.flatnonzero(np.diff(grid.segment)) + 1)
    for length in {len(chain) for chain in chains}:
        rows = np.stack([chain for chain in chains if len(chain) == length])
        late[:, :, rows] = behind_lags(inputs[:, rows], times[:, rows], grid.step, longer)
        rise = (acceleration[1] + late[0, 1])[rows] ** 2
        heave[:, rows] = [heaving(rise, factor * period, grid.step) for factor in longer]
    heave[1] = (heave[1] - heave[0]) / (CHANGE * period)
    behind, of_kappa = np.split(late[0], [len(constants)])
    by_time = (late[1, : len(constants)] - behind) / np.maximum(CHANGE * constants, 1e-9)
    parts = behind[:2], by_time[:2], behind[2:], by_time[2:], of_kappa, heave
    used = (*grid.used[:3], entries["pitch_lag"], entries["roll_lag"], *stretch, period)
    return replace(grid, behind=np.concatenate(parts), used=used)


def _stretch(
    interval: Interval, direction: str, entries: Mapping[str, float], factors: Mapping[str, float]
) -> list[float]:
    """Return the relaxation lengths of each axle in a direction over those of its tire file."""
    return [entries["relaxation"] * factors[axle] ** interval.relaxations[axle, direction].power for axle in AXLES]


def measured_slips(grid: Grid, V: FloatArray, car: Car, entries: Mapping[str, float]) -> FloatArray:
    """Return the longitudinal slip of each wheel, shape (4, n): of the other one of its axle if it is not logged."""
    scales = [
        entries[f"radius_{axle}"]
        / max(car.values[f"radius_{axle}"], 1e-9)
        * (1 + side * entries[f"unequal_{axle}"] / 2)
        for axle in AXLES
        for side in (1, -1)
    ]
    logged = np.any(grid.rims != 0.0, axis=1, keepdims=True)
    slips = np.where(logged, grid.rims * np.array(scales)[:, None] / V - 1.0, 0.0)
    other = np.arange(len(slips)) ^ 1
    return np.where(logged, slips, slips[other])


def behind_lags(inputs: FloatArray, constants: FloatArray, step: float, longer: Sequence[float] = (1.0,)) -> FloatArray:
    """Return what first-order lags add to inputs at even times, means over a step, shape (n_longer, *inputs.shape).

    `constants`: time constants of the inputs, s, which are taken `longer` times. The inputs are splines along the last
    axis; they begin as if their first slope had lasted.
    """
    whole, values = _finer(constants), _finer(inputs)
    slopes = np.diff(values, append=values[..., -1:]) / (step / PARTS)
    return np.stack([_means(_behind(values, slopes, factor * whole, step / PARTS)) for factor in longer])


def _behind(values: FloatArray, slopes: FloatArray, times: FloatArray, step: float) -> FloatArray:
    """Return what lags add to values that are linear between even times."""
    kept = np.exp(-step / np.maximum(times, 1e-9))
    rest = values - slopes * times
    steady = (1.0 - kept) * rest + slopes * step
    kept[..., -1], steady[..., -1] = 0.0, np.roll(rest[..., 0], -1)  # one recursion, which begins again in each row
    return recursion(rest.flat[0], kept.ravel()[:-1], steady.ravel()[:-1]).reshape(values.shape) - values


def heaving(rise: FloatArray, period: float, step: float) -> FloatArray:
    """Return the acceleration of a mass on damped springs whose rest position rises, means over a step.

    `rise`: of the rest position at even times, a spline along the last axis; the mass begins at rest. `period`:
    natural, s.
    """
    w = 2.0 * np.pi / period
    at_rest, h = _finer(rise - rise[..., :1]), np.array([step / PARTS])
    # Position and speed of the mass, rest position and its slope, which is constant between the parts.
    law = np.array([[0.0, 1.0, 0.0, 0.0], [-(w**2), -2.0 * DAMPING * w, w**2, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0] * 4])
    (kept,), _ = held_system(law[None], h)
    slopes = np.diff(at_rest, append=at_rest[..., -1:]) / h
    gained, matrix = np.stack([at_rest, slopes], axis=-1) @ kept[:2, 2:].T, np.empty((*at_rest.shape, 2, 2))
    matrix[:] = kept[:2, :2]
    gained[..., -1, :], matrix[..., -1, :, :] = 0.0, 0.0  # one recursion, which begins again in each row
    motion = vector_recursion(np.zeros(2), matrix.reshape(-1, 2, 2)[:-1], gained.reshape(-1, 2)[:-1])
    return _means(w**2 * at_rest + (motion @ law[1, :2]).reshape(at_rest.shape))


def _finer(values: FloatArray) -> FloatArray:
    """Return values at even times at `PARTS` of a step: splines along the last axis."""
    n = values.shape[-1]
    return np.asarray(CubicSpline(np.arange(n), values, axis=-1)(np.arange((n - 1) * PARTS + 1) / PARTS))


def _means(fine: FloatArray) -> FloatArray:
    """Return the means over a step of values at its parts, along the last axis."""
    inside = np.pad(fine, [*[(0, 0)] * (fine.ndim - 1), (PARTS // 2, PARTS // 2)], mode="edge")
    ends = (inside[..., :-PARTS] + inside[..., PARTS:]) / 2
    between = sum(inside[..., part : part - PARTS] for part in range(1, PARTS))
    return np.asarray((ends + between)[..., ::PARTS] / PARTS)
