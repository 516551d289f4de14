"""The log on a grid: means of each channel over short intervals, which follow each other in chains without gaps."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, make_interp_spline, splrep

from ....boundary.errors import DataError
from ....measurements.units import GRAVITY
from ....symbolic.vehicle.quantities import CORNERS
from .car import Car
from .log import Log
from .log_channels import LOG_CHANNELS

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

#: Lengths of an interval, s: the longest one is used for which the error of the midpoint rule, relative to the signal,
#: is below a share for the steering, which excites the motion, and for the accelerations together. A slalom of 0.45 Hz
#: has 0.7 % at 0.1 s; braking within 0.1 s has more.
STEPS, STEP_ERROR = (0.1, 0.05, 0.025), 0.01
#: Samples of the accelerations in an interval that they make shorter, at least.
FEWEST_SAMPLES = 2.0
#: The slowest part of a drive is not used: a share of the speed that 5 % exceed, and m/s.
SLOW_SHARE, SLOWEST = 0.1, 0.3
#: Longitudinal slip beyond which a wheel locks or spins: its inertia and its forces are not those of the model.
LARGEST_SLIP = 0.2
#: Shortest chain, s; longest gap in a channel that is bridged, s.
SHORTEST_CHAIN, LONGEST_GAP = 1.0, 0.25
#: Time at both ends of a log within which a delayed steering is unknown, s.
MARGIN = 0.2
#: Samples of the steering between knots of its curve, of which the noise chooses.
KNOTS = (1, 2, 4, 8, 16)
#: The channels of a grid, in the order of the residuals of the estimate.
MEASURED = (
    "yaw_rate", "ax", "ay", "speed", "beta", "vy", "x", "y", "heading", "rim_front", "rim_rear", "speed_rate",
)  # fmt: skip
#: Change of a rolling radius with load and speed, relative; error of the slip of a wheel that follows from its
#: longitudinal force, over the slip; slip over acceleration per g, at least; time for which such an error lasts, s.
RADIUS_ERROR, SLIP_ERROR, SLIP_OF_ACCELERATION, LASTING = 0.001, 0.3, 0.05, 1.0
#: Error of the mean of an acceleration that changes within an interval, over the change.
EDGE_ERROR = 0.1
#: Without ax, the rate of the speed is that of the logged one, averaged over this time, s; its smallest standard
#: deviation, m/s^2.
RATE_WINDOW, RATE_DEVIATION = 0.3, 0.1


@dataclass(frozen=True)
class Grid:
    """A log on a grid of n intervals in chains.

    - `step`: length of an interval, s. `t`, shape (n,): middle of each, s.
    - `left`, `right`, shape (n,): numbers of the nodes at its ends; intervals of a chain share nodes.
    - `means`, `noise`, shape (n_measured, n): mean of each of `MEASURED`, NaN if not sampled, and its
      standard deviation.
    - `course`: angle of the front wheels over time, as logged.
    - `steer`, shape (2, n): angle of the front wheels, without offset: a line over the interval with the mean of the
      channel, at both ends.
    - `steer_slopes`, shape (4, n): its derivatives by delay and lag, at both ends.
    - `rims`, shape (4, n): spin times rolling radius of each of `CORNERS`, m/s; 0 if not logged. `rim_slopes`, shape
      (4, n): their derivatives by the delay of the wheel speeds.
    - `behind`, shape (18, n): what lags add to longitudinal and lateral acceleration, m/s^2, and its derivatives by the
      lags; what relaxation adds to the slip angle of each wheel, rad, its derivatives by the relative length, and what
      it adds to the longitudinal slip of each wheel; the vertical acceleration of the body for a lift of 1, and its
      derivative by the period (`with_lags`).
    - `used`: delay and lag of the steering, delay of the wheel speeds, lag of pitch and of roll, s, the relative
      relaxation lengths of both axles, and the period of heave with which these were computed.
    """

    step: float
    t: FloatArray
    left: IntArray
    right: IntArray
    means: FloatArray
    noise: FloatArray
    course: BSpline
    steer: FloatArray
    steer_slopes: FloatArray
    rims: FloatArray
    rim_slopes: FloatArray
    behind: FloatArray
    used: tuple[float, ...] = 8 * (0.0,)

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return int(self.right[-1]) + 1

    @property
    def sampled(self) -> tuple[str, ...]:
        """The channels that are logged."""
        return tuple(name for name, row in zip(MEASURED, self.means, strict=True) if np.isfinite(row).any())

    def part(self, rows: IntArray) -> tuple[Grid, IntArray]:
        """Return the grid of some intervals, in their order, and the numbers of its nodes in this one."""
        fresh = np.diff(self.right[rows], prepend=-1) != 1
        left = np.arange(len(rows)) + np.cumsum(fresh) - 1
        nodes = np.empty(left[-1] + 2, dtype=np.intp)
        nodes[left], nodes[left + 1] = self.left[rows], self.right[rows]
        names = "means", "noise", "steer", "steer_slopes", "rims", "rim_slopes", "behind"
        columns = {name: getattr(self, name)[:, rows] for name in names}
        return replace(self, t=self.t[rows], left=left, right=left + 1, **columns), nodes

    @property
    def segment(self) -> IntArray:
        """Number of the chain of each interval."""
        return np.asarray(self.left - np.arange(len(self.left)), dtype=np.intp)


def unwrapped(log: Log) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return the channels of a log, the heading without jumps."""
    channels = dict(log.channels)
    if "heading" in channels:
        t, heading = channels["heading"]
        channels["heading"] = t, np.unwrap(heading)
    return channels


def spinning(log: Log, car: Car) -> tuple[str, ...]:
    """Return the wheels with a logged speed, if both axles have one and their radii are given."""
    if not (log.has_wheel_speeds() and all(_radius(car, corner) > 0.0 for corner in CORNERS)):
        return ()
    return tuple(corner for corner in CORNERS if f"omega_{corner}" in log.channels)


def _radius(car: Car, corner: str) -> float:
    return car.values["radius_front" if corner[0] == "f" else "radius_rear"]


def forward_speed(log: Log, car: Car) -> tuple[FloatArray, FloatArray]:
    """Return times and a rough forward speed: as logged, of the wheels, or from the position."""
    channels, wheels = unwrapped(log), spinning(log, car)
    if "speed" in channels:
        return channels["speed"]
    if wheels:
        t = channels[f"omega_{wheels[0]}"][0]
        rims = [_radius(car, corner) * np.interp(t, *channels[f"omega_{corner}"]) for corner in wheels]
        return t, np.mean(rims, axis=0)
    t = channels["x"][0]
    even = np.arange(t[0], t[-1], 0.1)
    velocity = [np.gradient(np.interp(even, *channels[name]), even) for name in ("x", "y")]
    heading = np.interp(even, *channels["heading"]) - car.values["heading_offset"]
    return even, velocity[0] * np.cos(heading) + velocity[1] * np.sin(heading)


def gridded(log: Log, car: Car, speed: tuple[FloatArray, FloatArray]) -> Grid:
    """Return a log on a grid.

    Raises `DataError` if the car never moves, or moves too briefly for an estimate.
    """
    channels = unwrapped(log)
    start = max(channels[name][0][0] for name in ("steer",))
    end = channels["steer"][0][-1]
    step = _step(log, car)
    edges = start + step * np.arange(int((end - start) / step) + 1)
    middle = (edges[:-1] + edges[1:]) / 2
    v = np.interp(middle, *speed)
    fast = float(np.quantile(v, 0.95))
    if fast <= SLOWEST:
        raise DataError(f"{log.source}: the speed is {fast:.2g} m/s or less: the car does not move forward")
    usable = (v > max(SLOWEST, SLOW_SHARE * fast)) & (middle > start + MARGIN) & (middle < end - MARGIN)
    turning = "yaw_rate" if "yaw_rate" in channels else "heading"
    for name in ("steer", turning):
        usable &= _near_samples(channels[name][0], middle)
    rims = _rims(log, car, middle, step)
    usable &= (np.abs(np.where(rims, rims, v) / v - 1.0) < LARGEST_SLIP).all(axis=0)
    sampled = np.histogram(channels[turning][0], edges)[0] > 0
    usable = _long_runs(usable, sampled, round(SHORTEST_CHAIN / step))
    if not usable.any():
        raise DataError(f"{log.source}: no {SHORTEST_CHAIN:g} s without a gap in which the car moves")
    chosen = np.flatnonzero(usable)
    chain = np.cumsum(np.diff(chosen, prepend=chosen[0]) > 1)
    left = np.arange(len(chosen)) + chain
    means, noise = np.full((2, len(MEASURED), len(chosen)), np.nan)
    for row, name in enumerate(MEASURED):
        if name in channels:
            means[row], noise[row] = _averaged(channels[name], edges, usable, name)
    if "ax" not in channels:
        means[-1] = np.gradient(_windowed(*speed, middle, RATE_WINDOW), middle)[chosen]
        noise[-1] = RATE_DEVIATION
    for axle, (wheels, axle_channels) in zip(("front", "rear"), _axle_speeds(log, car), strict=False):
        if axle == car.driven:  # its slip grows in a turn, beyond what its longitudinal force states
            continue
        row = MEASURED.index(f"rim_{axle}")
        means[row], noise[row] = _averaged(axle_channels, edges, usable, wheels)
        smooth = _windowed(*speed, middle, RATE_WINDOW)
        slip = SLIP_OF_ACCELERATION / GRAVITY * np.gradient(smooth, middle)[chosen]
        measured = means[row] / smooth[chosen]  # near its limit, a wheel slips more
        slip = np.maximum(np.abs(slip), np.abs(np.nan_to_num(measured - np.nanmedian(measured))))
        lasting = LASTING / step * (RADIUS_ERROR**2 + (SLIP_ERROR * slip) ** 2)
        noise[row] = np.sqrt(noise[row] ** 2 + lasting * means[row] ** 2)
    row = MEASURED.index("ax")
    change = np.gradient(means[row]) if len(chosen) > 1 else 0.0 * means[row]
    noise[row] = np.hypot(noise[row], EDGE_ERROR * np.nan_to_num(change))
    empty = np.zeros((18, len(chosen)))
    course = _course(*_wheel_angle(log, car))
    parts = empty[:2], empty[:4], empty[:4], empty[:4], empty
    grid = Grid(step, middle[chosen], left, left + 1, means, noise, course, *parts)
    return with_delays(grid, log, car, car.values)


def with_delays(grid: Grid, log: Log, car: Car, entries: Mapping[str, float]) -> Grid:
    """Return a grid with steering and wheel speeds at the delays and the lag of entries of the car."""
    t = log.channels["steer"][0]
    delay, lag = entries["delay"], max(entries["lag"], 0.0)
    ends = np.clip(grid.t - delay + np.array([[-0.5], [0.5]]) * grid.step, t[0], t[-1])

    def line(curve: BSpline) -> FloatArray:
        at_ends, integral = curve(ends), curve.antiderivative()(ends)
        mean = np.diff(integral, axis=0) / np.maximum(np.diff(ends, axis=0), 1e-9)
        return np.asarray(at_ends - at_ends.mean(axis=0) + mean)

    def behind(lag: float) -> BSpline:
        return make_interp_spline(t, _lagged(t, grid.course(t), lag)) if lag else grid.course

    curve = behind(lag)
    steer, by_delay = line(curve), -line(curve.derivative())
    by_lag = (line(behind(lag * 1.05)) - line(behind(lag * 0.95))) / (0.1 * lag) if lag else np.zeros_like(by_delay)
    slopes, late, change = np.concatenate([by_delay, by_lag]), entries["wheel_delay"], grid.step / 4
    before, rims, after = (_rims(log, car, grid.t + late + more, grid.step) for more in (-change, 0.0, change))
    rim_slopes, used = (after - before) / (2 * change), (delay, lag, late, *grid.used[3:])
    return replace(grid, steer=steer, steer_slopes=slopes, rims=rims, rim_slopes=rim_slopes, used=used)


def _course(t: FloatArray, angle: FloatArray) -> BSpline:
    """Return the steering as a smooth curve: a cubic spline with the knots that predict best (Mallows' C_p).

    Lines between samples have errors and noise that depend on where in a sample a delayed interval begins, so that the
    probability of a log would be rough over its delay, by more than an effect of the tires changes it.
    """
    curves = []
    for every in KNOTS:
        curve = BSpline(*splrep(t, angle, t=t[2:-2:every]))  # FITPACK's time is linear in the samples
        n = len(curve.t) - curve.k - 1
        excess = np.mean((curve(t) - angle) ** 2) + 2.0 * _scatter(angle) ** 2 * n / len(t)
        curves.append((excess, curve))
    return min(curves, key=lambda pair: pair[0])[1]


def _wheel_angle(log: Log, car: Car) -> tuple[FloatArray, FloatArray]:
    t, channel = log.channels["steer"]
    return t, np.interp(channel, *car.steering_map.T) if car.steering_map is not None else channel / car.values["ratio"]


def _step(log: Log, car: Car) -> float:
    """Return the length of an interval: see `STEPS`."""
    t, angle = _wheel_angle(log, car)
    lagged = [(t, _lagged(t, angle, car.values["lag"]))]
    accelerations = [log.channels[name] for name in ("ax", "ay") if name in log.channels]
    apart = max((float(np.median(np.diff(times))) for times, _ in accelerations), default=np.inf)
    for step, shorter in itertools.pairwise(STEPS):
        judged = (lagged, accelerations) if shorter >= FEWEST_SAMPLES * apart else (lagged,)
        if sum(_bend(some, step) for some in judged) < (12 * STEP_ERROR) ** 2:
            return step
    return STEPS[-1]


def _bend(channels: list[tuple[FloatArray, FloatArray]], step: float) -> float:
    """Return the squares of the second differences of means over a step, over those of the means, without noise."""
    bend = size = 0.0
    for t, values in channels:
        means = _windowed(t, values, np.arange(t[0] + step, t[-1] - step, step), step)
        noise = len(means) * _scatter(values) ** 2 / max(step * len(t) / max(np.ptp(t), step), 1.0)
        bend += max(float(np.sum(np.diff(means, 2) ** 2)) - 6.0 * noise, 0.0)  # 1 + 4 + 1 variances
        size += max(float(np.sum(means**2)), 1e-12)
    return bend / size


def _rims(log: Log, car: Car, middle: FloatArray, width: float) -> FloatArray:
    """Return the mean speeds of the rims over windows around given times, shape (4, n)."""
    rims = np.zeros((len(CORNERS), len(middle)))
    for corner in spinning(log, car):
        samples = log.channels[f"omega_{corner}"]
        rims[CORNERS.index(corner)] = _radius(car, corner) * _windowed(*samples, middle, width)
    return rims


def _axle_speeds(log: Log, car: Car) -> Iterator[tuple[str, tuple[FloatArray, FloatArray]]]:
    """Yield a channel and samples of the mean speed of the rims of each axle, if both wheels have one."""
    logged = spinning(log, car)
    for left, right in (CORNERS[:2], CORNERS[2:]) if len(logged) == len(CORNERS) else ():
        t, values = log.channels[f"omega_{left}"]
        both = (values + np.interp(t, *log.channels[f"omega_{right}"])) / 2
        yield f"omega_{left}", (t, _radius(car, left) * both)


def _windowed(t: FloatArray, values: FloatArray, at: FloatArray, width: float) -> FloatArray:
    """Return the means of a channel over windows around given times."""
    integral = np.concatenate([[0.0], np.cumsum(np.diff(t) * (values[1:] + values[:-1]) / 2)])
    around = np.clip(at[..., None] + np.array([-0.5, 0.5]) * width, t[0], t[-1])
    ends = np.interp(around, t, integral)
    return np.asarray((ends[..., 1] - ends[..., 0]) / np.maximum(around[..., 1] - around[..., 0], 1e-9))


def _lagged(t: FloatArray, values: FloatArray, lag: float) -> FloatArray:
    """Return values behind a first-order lag, exact for values that are linear between samples."""
    if not lag:
        return values
    result, state = np.empty_like(values), values[0]
    for i, (ahead, now) in enumerate(zip(values, np.diff(t, prepend=t[0]), strict=True)):
        before = values[i - 1] if i else ahead
        slope = (ahead - before) / now if now else 0.0
        state = ahead - slope * lag + (state - before + slope * lag) * np.exp(-now / lag)
        result[i] = state
    return result


def _near_samples(t: FloatArray, middle: FloatArray) -> npt.NDArray[np.bool_]:
    after = np.clip(np.searchsorted(t, middle), 1, len(t) - 1)
    near: npt.NDArray[np.bool_] = (t[after] - t[after - 1] < LONGEST_GAP) & (middle > t[0]) & (middle < t[-1])
    return near


def _long_runs(usable: npt.NDArray[np.bool_], sampled: npt.NDArray[np.bool_], shortest: int) -> npt.NDArray[np.bool_]:
    """Return the intervals of long runs of usable ones, which begin and end with a sampled one: no end is a guess."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], usable.astype(int), [0]])))
    kept = np.zeros_like(usable)
    for first, last in edges.reshape(-1, 2):
        inside = first + np.flatnonzero(sampled[first:last])
        if len(inside) and np.ptp(inside) + 1 >= shortest:
            kept[inside[0] : inside[-1] + 1] = True
    return kept


def _averaged(
    samples: tuple[FloatArray, FloatArray], edges: FloatArray, usable: npt.NDArray[np.bool_], name: str
) -> tuple[FloatArray, FloatArray]:
    """Return means over the usable intervals, and the standard deviation of their noise.

    The noise of a sample is that of fourth differences, which a motion of a few Hz hardly reaches.
    """
    t, values = samples
    number = np.searchsorted(edges, t, side="right") - 1
    inside = (number >= 0) & (number < len(edges) - 1)
    counts = np.bincount(number[inside], minlength=len(edges) - 1)
    middle = (edges[:-1] + edges[1:]) / 2
    # A mean of samples belongs to their mean time: the slope of the channel moves it to the middle.
    sums, times = (np.bincount(number[inside], part[inside], len(edges) - 1) for part in (values, t))
    with np.errstate(invalid="ignore", divide="ignore"):
        means, shift = sums / counts, times / counts - middle
    step = edges[1] - edges[0]
    slope = np.diff(_windowed(t, values, middle[:, None] + np.array([-step, step]), step))[:, 0] / (2 * step)
    deviation = max(_scatter(values), LOG_CHANNELS[name].precision)
    noise = deviation / np.sqrt(np.maximum(counts, 1))
    return (means - shift * slope)[usable], noise[usable]


def _scatter(values: FloatArray) -> float:
    """Return the standard deviation of the noise of a channel, from fourth differences."""
    differences = np.diff(values, 4)
    return 1.4826 * float(np.median(np.abs(differences - np.median(differences)))) / float(np.sqrt(70.0))
