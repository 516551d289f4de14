"""Roads, drivers and manoeuvres of `kart.py`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
#: Height, normal, shape (n, 3), and friction of the road at global x and y.
RoadFunction = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]
#: Steering angle of the front wheels and its rate, from time, position, forward axis, velocity and angular velocity.
Driver = Callable[[float, FloatArray, FloatArray, FloatArray, FloatArray], tuple[float, float]]
#: Torques of the wheels at a time, shape (4,), N m.
Torques = Callable[[float], FloatArray]

BUMP = 0.006
#: ISO 3888-1: where the kart changes to the other lane and back, m, and the distance of the lanes, m.
CHANGES, LANE = ((15.0, 45.0), (70.0, 95.0)), 3.5
PREVIEW, GAIN = 6.0, 0.11


@dataclass(frozen=True)
class Manoeuvre:
    """A manoeuvre.

    Attributes
    ----------
    speed, end : float
        At the start, m/s; duration, s.
    road : RoadFunction
    driver : Driver
    drive, brake : Torques
    """

    speed: float
    end: float
    road: RoadFunction
    driver: Driver
    drive: Torques
    brake: Torques


def smooth(t: float, begin: float, duration: float) -> tuple[float, float]:
    """Return a smooth step from 0 to 1 and its rate."""
    share = float(np.clip((t - begin) / duration, 0.0, 1.0))
    return share**2 * (3.0 - 2.0 * share), 6.0 * share * (1.0 - share) / duration


def even(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return a level road."""
    return 0.0 * x, np.stack([0.0 * x, 0.0 * x, 1.0 + 0.0 * x], axis=-1), 1.0 + 0.0 * y


def bumpy(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return a slope of 3 % with a bump, slippery on the right side."""
    along = np.clip((x - 5.0) / 2.0, 0.0, 1.0)
    height = 0.03 * x + BUMP * np.sin(np.pi * along) ** 4
    rise = 0.03 + BUMP * 4.0 * np.sin(np.pi * along) ** 3 * np.cos(np.pi * along) * np.pi / 2.0
    return height, np.stack([-rise, 0.0 * x, 1.0 + 0.0 * x], axis=-1), 0.8 + 0.2 * np.tanh(4.0 * y)


def steep(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return a slope of 20 %."""
    return 0.2 * x, np.stack([-0.2 + 0.0 * x, 0.0 * x, 1.0 + 0.0 * x], axis=-1), 1.0 + 0.0 * y


def straight(t: float, r: FloatArray, ahead: FloatArray, v: FloatArray, w: FloatArray) -> tuple[float, float]:
    """Do not steer."""
    return 0.0, 0.0


def turn(t: float, r: FloatArray, ahead: FloatArray, v: FloatArray, w: FloatArray) -> tuple[float, float]:
    """Steer into a turn to the left."""
    share, rate = smooth(t, 0.1, 0.3)
    return 0.04 * share, 0.04 * rate


def lane(x: float) -> tuple[float, float]:
    """Return the middle of the lanes and its slope."""
    there, back = (smooth(x, begin, end - begin) for begin, end in CHANGES)
    return LANE * (there[0] - back[0]), LANE * (there[1] - back[1])


def follow(t: float, r: FloatArray, ahead: FloatArray, v: FloatArray, w: FloatArray) -> tuple[float, float]:
    """Steer in proportion to the distance of a point ahead from the middle of the lanes."""
    place, rate = r + PREVIEW * ahead, v + PREVIEW * np.cross(w, ahead)
    middle, slope = lane(float(place[0]))
    return GAIN * (middle - float(place[1])), GAIN * (slope * float(rate[0]) - float(rate[1]))


def no_torque(t: float) -> FloatArray:
    """Return no torque."""
    return np.zeros(4)


def braking(t: float) -> FloatArray:
    """Brake all wheels after 0.3 s."""
    return 12.0 * smooth(t, 0.3, 0.3)[0] * np.ones(4)


def driving(t: float) -> FloatArray:
    """Drive the rear wheels."""
    return 25.0 * smooth(t, 0.0, 0.2)[0] * np.array([0.0, 0.0, 1.0, 1.0])


def holding(t: float) -> FloatArray:
    """Hold all wheels."""
    return 60.0 * np.ones(4)


MANOEUVRES = {
    "brake-in-turn": Manoeuvre(12.0, 1.0, bumpy, turn, no_torque, braking),
    "lane-change": Manoeuvre(80.0 / 3.6, 5.0, even, follow, no_torque, no_torque),
    "launch": Manoeuvre(0.5, 1.5, bumpy, straight, driving, no_torque),
    "park": Manoeuvre(0.0, 5.0, steep, straight, no_torque, holding),
}
