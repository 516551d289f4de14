"""Checks of a log against a car before any estimate: signs and units of steering, yaw rate and lateral acceleration."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ....boundary.errors import DataError
from .car import Car
from .grid import MEASURED, Grid
from .log import Log

FloatArray = npt.NDArray[np.float64]

#: Limits of the measured yaw rate over that of a car without slip, v delta / l, and of ay over v times yaw rate. An
#: understeering car has 0.3 at high speed; another unit of an angle has 57 or 1/57, one of acceleration 9.8 or 0.1.
YAW_GAIN, LATERAL_GAIN = (0.15, 3.0), (0.5, 2.0)
#: Smallest correlation of yaw rate with v delta / l, and smallest angle of the front wheels with a turn, rad.
MIN_CORRELATION, MIN_STEER = 0.5, 0.002


def check_log(log: Log, car: Car, grid: Grid, speed: FloatArray) -> None:
    """Raise `DataError` if the log contradicts the car: no steering, a wrong sign, another unit, another car.

    `speed`, shape (n,): rough forward speed at the intervals.
    """
    steer = grid.steer.mean(axis=0) + car.values["offset"]
    source = log.source
    yaw_rate = _yaw_rate(grid)
    wanted = speed * steer / car.values["wheelbase"]
    # About zero, not about the means: a circle at rising speed explains itself, a slalom with held steering does not.
    gain, correlation = _slope(wanted, yaw_rate)
    if np.std(steer) < MIN_STEER and abs(correlation) < MIN_CORRELATION:
        raise DataError(
            f"{source}: steer hardly changes: {np.degrees(np.std(steer)):.2g} deg at the front wheels; without "
            "steering no tire can be judged (is the ratio of the car right, is steer in rad?)"
        )
    if correlation < -MIN_CORRELATION:
        raise DataError(f"{source}: yaw rate and steer have opposite signs: both are positive to the left")
    if correlation < MIN_CORRELATION:
        raise DataError(
            f"{source}: the steering does not explain the yaw rate (correlation {correlation:.2f}): is this the log of "
            f"{car.source}?"
        )
    if not YAW_GAIN[0] < gain < YAW_GAIN[1]:
        hint = "radians and degrees confused, or another ratio" if gain > 20 or gain < 0.06 else "another car or ratio"
        raise DataError(f"{source}: the yaw rate is {gain:.3g} times v delta / wheelbase of {car.source}: {hint}?")
    ay = grid.means[MEASURED.index("ay")]
    if np.isfinite(ay).any():
        lateral = speed * yaw_rate
        gain, correlation = _slope(lateral - np.nanmean(lateral), ay - np.nanmean(ay))
        if correlation < 0.0:
            raise DataError(f"{source}: ay and yaw rate have opposite signs: both are positive to the left")
        if not LATERAL_GAIN[0] < gain < LATERAL_GAIN[1]:
            raise DataError(f"{source}: ay is {gain:.3g} times speed times yaw rate: is it in m/s^2, the speed in m/s?")


def _yaw_rate(grid: Grid) -> FloatArray:
    """Return the measured yaw rate, or the rate of the heading."""
    measured = grid.means[MEASURED.index("yaw_rate")]
    if np.isfinite(measured).any():
        return np.asarray(measured)
    heading = grid.means[MEASURED.index("heading")]
    finite = np.isfinite(heading)
    return np.asarray(np.gradient(np.interp(grid.t, grid.t[finite], heading[finite]), grid.t))


def _slope(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    finite = np.isfinite(x) & np.isfinite(y)
    x, y = x[finite], y[finite]
    return float(x @ y / (x @ x + 1e-300)), float(x @ y / np.sqrt((x @ x) * (y @ y) + 1e-300))
