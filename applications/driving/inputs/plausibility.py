"""Checks of a log against a car and its tires before any estimate: signs, units, a bank, another load class."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
import numpy.typing as npt

from ....boundary.errors import DataError, TirefmuError
from ....measurements.units import GRAVITY, to_si
from ....tires import Tire
from .car import Car
from .grid import MEASURED, Grid, spinning
from .log import Log
from .log_channels import NEAR, RADIUS_OF_KMH, UNITS, share_of_lock

FloatArray = npt.NDArray[np.float64]

#: Limits of the measured yaw rate over that of a car without slip, v delta / l, and of ay over v times yaw rate, or of
#: a track over that of the car. An understeering car has 0.3 at high speed; another unit of an angle has 57 or 1/57,
#: one of acceleration 9.8 or 0.1.
YAW_GAIN, LATERAL_GAIN, TYPICAL_GAIN = (0.15, 3.0), (0.5, 2.0), 0.7
#: Smallest correlation of yaw rate with v delta / l, and smallest angle of the front wheels with a turn, rad; remainder
#: that is an error of rounding, whatever its correlation, relative.
MIN_CORRELATION, MIN_STEER, ROUNDING = 0.5, 0.002, 1e-9
#: Lateral acceleration below which a car does not slide, over the one that 5 % of a drive exceed: as driven, and as the
#: steering wants it. Delays of the yaw rate behind the steering at which both are compared, s: of the car and the log.
CALM, DELAYS = 0.5, (0.0, -0.1, 0.1, 0.2, 0.3)

#: Units of wheel speeds, SI first, from which a speed follows that is not logged.
WHEEL_UNITS = "rad/s", "rpm", "rev/s", "deg/s"
#: Limits of the logged speed over that of the wheels.
RIM_RATIO = (0.75, 1.35)
#: Limits of the static load of a wheel over the nominal load of its tire. A model is used between 0.2 and 2.
LOAD_CLASS = (0.05, 10.0)
#: Standard deviations of the offset of ay from which its mean is that of a bank or of a tilted sensor.
BANKED = 5.0


def check_load_class(car: Car, tires: Mapping[str, Tire]) -> None:
    """Raise `TirefmuError` if the car is far too light or too heavy for its tires.

    `tires`: by axle.
    """
    for (axle, tire), load in zip(tires.items(), car.axle_loads, strict=True):
        share = 0.5 * load / tire.values["FNOMIN"]
        if not LOAD_CLASS[0] < share < LOAD_CLASS[1]:
            option = "--tire" if axle == "front" else "--rear"
            raise TirefmuError(
                f"{car.source}: a {axle} wheel carries {0.5 * load:.3g} N, {100.0 * share:.2g} % of FNOMIN = "
                f"{tire.values['FNOMIN']:g} N of its tire: a tire of another load class ({option}), or mass not in kg?"
            )


def check_wheel_speeds(log: Log, car: Car) -> None:
    """Raise `DataError` if the logged speed is far from that of the wheels: another unit of one, or other radii.

    The numbers of a speed in km/h are near those of a spin in rad/s. They are refused if the radii are other ones.
    """
    wheels = spinning(log, car)
    t, speed = log.channels.get("speed", (np.empty(0), np.empty(0)))
    if not wheels or not speed.any():
        return
    radii = [car.values["radius_front" if corner[0] == "f" else "radius_rear"] for corner in wheels]
    spins = [np.interp(t, *log.channels[f"omega_{corner}"]) for corner in wheels]
    rims = np.mean([radius * spin for radius, spin in zip(radii, spins, strict=True)], axis=0)
    moving = rims > 0.5 * np.quantile(rims, 0.95)
    ratio = float(np.median(speed[moving] / rims[moving])) if moving.any() else 1.0
    spun = float(np.median(speed[moving] / np.mean(spins, axis=0)[moving])) if moving.any() else 0.0
    stated = any(log.units.get(f"omega_{corner}") for corner in wheels)
    if not stated and abs(spun / RADIUS_OF_KMH - 1.0) < NEAR < abs(ratio - 1.0):
        raise DataError(
            f"{log.source}: the wheel speeds have the numbers of the speed in km/h; in rad/s they would be "
            f"{1.0 / ratio:.3g} times those of {car.source}: divide them by 3.6 and the radius, or state "
            f"--columns 'omega_{wheels[0]}=HEADER [rad/s]'"
        )
    if _within(ratio, RIM_RATIO):
        return
    factor = float(to_si(1.0, log.units.get("speed") or "m/s"))
    units = [unit for unit in UNITS["speed"] if _within(ratio * float(to_si(1.0, unit)) / factor, RIM_RATIO)]
    means = [f"speed in {unit} (--columns 'speed=HEADER [{unit}]')" for unit in units]
    remedy = " or ".join([*means, "wheel speeds in another unit, or other radii"])
    raise DataError(f"{log.source}: the speed is {ratio:.3g} times that of the wheels of {car.source}: {remedy}?")


def check_log(log: Log, car: Car, grid: Grid, speed: FloatArray) -> None:
    """Raise `DataError` if the log contradicts the car: no steering, a wrong sign, another unit, another car.

    `speed`, shape (n,): rough forward speed at the intervals.
    """
    steer = grid.steer.mean(axis=0) + car.values["offset"]
    source = log.source
    yaw_rate = _yaw_rate(grid)
    share = "" if car.steering_map is not None or log.units.get("steer") else share_of_lock(log.values("steer"))
    if share:
        raise DataError(f"{source}: {share}; if it is in rad, state it: --columns 'steer=HEADER [rad]'")
    gain, correlation = _turning(grid, steer, speed, yaw_rate, car.values["wheelbase"])
    if np.std(steer) < MIN_STEER and abs(correlation) < MIN_CORRELATION:
        raise DataError(
            f"{source}: steer hardly changes: {np.degrees(np.std(steer)):.2g} deg at the front wheels; without "
            "steering no tire can be judged (is the ratio of the car right, is steer in rad?)"
        )
    if correlation < -MIN_CORRELATION:
        raise DataError(
            f"{source}: yaw rate and steer have opposite signs: both are positive to the left (--columns steer=-HEADER)"
        )
    if correlation < MIN_CORRELATION:
        raise DataError(
            f"{source}: the steering does not explain the yaw rate (correlation {correlation:.2f}): is this the log of "
            f"{car.source}?"
        )
    _check_heading(grid, yaw_rate, source)
    lateral_gain, offset = 1.0, 0.0
    ax, ay = (grid.means[MEASURED.index(name)] for name in ("ax", "ay"))
    braked, correlation = _follows(np.gradient(speed, grid.t), ax)
    if correlation < -MIN_CORRELATION and _within(-braked, LATERAL_GAIN):  # a hill gives ax without such a rate
        raise DataError(
            f"{source}: ax and the rate of the speed have opposite signs: ax is positive where the car gains speed "
            "(--columns ax=-HEADER)"
        )
    if np.isfinite(ay).any():
        lateral = speed * yaw_rate
        (lateral_gain, correlation), (turned_gain, turned) = _follows(lateral, ay), _follows(lateral, ax)
        plausible, exchanged = (
            abs(correlation) > MIN_CORRELATION and _within(abs(gain), LATERAL_GAIN)
            for gain, correlation in ((lateral_gain, correlation), (turned_gain, turned))
        )
        if exchanged and not plausible:
            sign, other = ("-", "") if turned < 0.0 else ("", "-")
            raise DataError(
                f"{source}: ax follows speed times yaw rate, and ay does not: a sensor whose x axis points to a side "
                f"(--columns 'ay={sign}HEADER of ax,ax={other}HEADER of ay')?"
            )
        if abs(correlation) < MIN_CORRELATION:
            raise DataError(
                f"{source}: ay does not follow speed times yaw rate (correlation {correlation:.2f}): another column?"
            )
        if correlation < 0.0:
            raise DataError(
                f"{source}: ay and yaw rate have opposite signs: both are positive to the left (--columns ay=-HEADER)"
            )
        offset = (
            float(np.nanmean(ay - lateral * (1.0 + GRAVITY * car.values["roll_gradient"]))) - car.values["ay_offset"]
        )
    if not (_within(gain, YAW_GAIN) and _within(lateral_gain, LATERAL_GAIN)):
        facts = [f"the yaw rate is {gain:.3g} times v delta / wheelbase of {car.source}"]
        facts += [f"ay is {lateral_gain:.3g} times speed times yaw rate"] if lateral_gain != 1.0 else []
        wheels = [] if "speed" in log.channels else [name for name in log.channels if name.startswith("omega_")]
        raise DataError(f"{source}: {', '.join(facts)}: {_remedy(gain, lateral_gain, log.units, wheels)}")
    largest = car.uncertainties["ay_offset"] + 0.1 * float(np.mean(np.abs(speed * yaw_rate)))
    if abs(offset) > BANKED * largest:
        raise DataError(
            f"{source}: ay is {offset:+.3g} m/s^2 from speed times yaw rate on average: a banked road, or a tilted "
            f"sensor: state it: ay_offset = {offset:.3g} in [sensors] of {car.source} (a bank of 1 rad adds 9.81)"
        )


def _check_heading(grid: Grid, yaw_rate: FloatArray, source: str) -> None:
    """Raise if the heading turns the other way than the yaw rate, as that of a compass does, or in degrees."""
    heading = _rate_of_heading(grid)
    gain, correlation = _slope(yaw_rate, heading) if np.isfinite(heading).any() else (1.0, 0.0)
    if abs(correlation) < MIN_CORRELATION or (gain > 0.0 and _within(gain, LATERAL_GAIN)):
        return
    sign = "-" if gain < 0.0 else ""
    unit = " [deg]" if _within(abs(np.radians(gain)), LATERAL_GAIN) else ""
    means = [*(["to the right, as that of a compass"] if sign else []), *(["in deg"] if unit else [])]
    remedy = f": {' and '.join(means)}? --columns 'heading={sign}HEADER{unit}'" if means else ": in another unit?"
    raise DataError(f"{source}: the heading turns {gain:.3g} times as fast as the yaw rate{remedy}")


def exchanged_axles(grid: Grid, speed: FloatArray, car: Car) -> tuple[str, ...]:
    """Return the axles whose logged left wheel is the faster one in left turns: the sides of the log are exchanged.

    Differences in proportion to the speed are those of rolling radii, and a car that slides shows other ones.

    `speed`, shape (n,): rough forward speed at the intervals.
    """
    yaw_rate, axles = _yaw_rate(grid), list[str]()
    calm = _calm(speed * yaw_rate)
    v, turn = speed[calm], _beyond(speed[calm], yaw_rate[calm])
    for axle, (left, right) in (("front", grid.rims[:2]), ("rear", grid.rims[2:])):
        gain, correlation = _slope(turn, _beyond(v, (right - left)[calm]))
        logged = left.any() and right.any()
        if logged and correlation < -MIN_CORRELATION and _within(-gain / car.values[f"track_{axle}"], LATERAL_GAIN):
            axles.append(axle)
    return tuple(axles)


def _turning(
    grid: Grid, steer: FloatArray, speed: FloatArray, yaw_rate: FloatArray, wheelbase: float
) -> tuple[float, float]:
    """Return gain and correlation of the yaw rate over v delta / l, in the first view in which one explains the other.

    Views: the whole drive; the part in which the car does not slide, since a driver counter-steers where it does; each
    with another offset of the steering and at the delays. If none explains, the first one is returned.
    """
    views = []
    for delay in DELAYS:
        wanted = speed * np.interp(grid.t - delay, grid.t, steer) / wheelbase
        calm = _calm(speed * wanted) & _calm(speed * yaw_rate)
        for rows in (np.ones_like(calm), calm):
            x, y, offset = wanted[rows], yaw_rate[rows], speed[rows]
            # About zero, not about the means: a circle at rising speed explains itself, a slalom with held steering
            # does not.
            views += [_slope(x, y), _slope(_beyond(offset, x), _beyond(offset, y))]
        if views[0][1] < -MIN_CORRELATION and max(correlation for _, correlation in views) < MIN_CORRELATION:
            return views[0]  # a delay of half a period is another sign
    return next((view for view in views if view[1] > MIN_CORRELATION), views[0])


def _calm(lateral: FloatArray) -> npt.NDArray[np.bool_]:
    size = np.abs(np.nan_to_num(lateral))
    return np.asarray(size < CALM * np.quantile(size, 0.95))


def _beyond(offset: FloatArray, values: FloatArray) -> FloatArray:
    """Return values without what is proportional to another one."""
    rest = values - _slope(offset, values)[0] * offset
    return np.asarray(rest * (np.abs(rest) > ROUNDING * np.abs(values).max(initial=0.0)))


def _within(gain: float, limits: tuple[float, float]) -> bool:
    return limits[0] < gain < limits[1]


def _remedy(gain: float, lateral: float, read_as: Mapping[str, str], wheels: Sequence[str]) -> str:
    """Return the units that make both gains plausible, the fewest changes first, with the option that states them.

    `wheels`: channels from which the speed follows, if it is not logged.
    """
    columns = {name: [name] for name in UNITS} | ({"speed": list(wheels)} if wheels else {})
    allowed = UNITS | ({"speed": WHEEL_UNITS} if wheels else {})
    factor = {name: float(to_si(1.0, read_as.get(columns[name][0]) or units[0])) for name, units in allowed.items()}
    candidates = [(name, unit) for name, units in allowed.items() for unit in units if to_si(1.0, unit) != factor[name]]
    fitting: list[tuple[float, str]] = []
    for count in (1, 2, 3):
        for changed in combinations(candidates, count):
            factors = {name: float(to_si(1.0, unit)) / factor[name] for name, unit in changed}
            if len(factors) < count:
                continue
            steer, speed, rate, ay = (factors.get(name, 1.0) for name in UNITS)
            turned, pulled = gain * rate / (speed * steer), lateral * ay / (speed * rate)
            if _within(turned, YAW_GAIN) and _within(pulled, LATERAL_GAIN):
                options = ",".join(f"{column}=HEADER [{unit}]" for name, unit in changed for column in columns[name])
                names = (f"{'wheel speeds' if columns[name] == wheels else name} in {unit}" for name, unit in changed)
                text = f"{' and '.join(names)} (--columns '{options}')"
                fitting.append((abs(np.log(turned / TYPICAL_GAIN)) + abs(np.log(pulled)), text))
        if fitting:
            return f"{' or '.join(text for _, text in sorted(fitting)[:2])}?"
    return "another car, or another ratio of the steering?"


def _yaw_rate(grid: Grid) -> FloatArray:
    """Return the measured yaw rate, or the rate of the heading."""
    measured = grid.means[MEASURED.index("yaw_rate")]
    if np.isfinite(measured).any():
        return np.asarray(measured)
    return _rate_of_heading(grid)


def _rate_of_heading(grid: Grid) -> FloatArray:
    """Return the rate of the heading; NaN if it is not logged."""
    heading = grid.means[MEASURED.index("heading")]
    finite = np.isfinite(heading)
    if not finite.any():
        return np.full(len(grid.t), np.nan)
    return np.asarray(np.gradient(np.interp(grid.t, grid.t[finite], heading[finite]), grid.t))


def _follows(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Return slope and correlation of y over x; 0 if no y is logged.

    About their means or about zero, where the correlation is larger: y may have an offset, and a circle at one speed
    varies by noise alone.
    """
    finite = np.isfinite(x) & np.isfinite(y)
    if not finite.any():
        return 0.0, 0.0
    views = _slope(x - x[finite].mean(), y - y[finite].mean()), _slope(x, y)
    return max(views, key=lambda view: abs(view[1]))


def _slope(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    finite = np.isfinite(x) & np.isfinite(y)
    x, y = x[finite], y[finite]
    return float(x @ y / (x @ x + 1e-300)), float(x @ y / np.sqrt((x @ x) * (y @ y) + 1e-300))
