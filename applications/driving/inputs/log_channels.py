"""The channels of a log: one declaration per channel, in SI units and the axes of ISO 8855."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True)
class LogChannel:
    """A channel of a log.

    - `name`, `meaning`: of the contract.
    - `unit`, `quantity`: SI unit and physical quantity; a header may declare another unit.
    - `aliases`: other common names, for suggestions (`survey.py` compares them in the words of `SHORT`). They are
      never accepted silently.
    - `with_unit`: names that count only with a unit of the quantity: the one of a wheel may be that of its torque.
    - `limit`: magnitude beyond which a value can only be in another unit.
    - `precision`: the smallest plausible standard deviation of the noise.
    - `instead`: channels of which a group serves in its place, and `source`: where a log without it may get it.
    """

    name: str
    meaning: str
    unit: str
    quantity: str
    aliases: tuple[str, ...] = ()
    limit: float = 1e9
    precision: float = 0.0
    instead: tuple[tuple[str, ...], ...] = ()
    source: str = ""
    with_unit: tuple[str, ...] = ()


#: Position and heading, which only all three determine the motion of a car.
POSE = ("x", "y", "heading")
_WHEELS = tuple((front, rear) for front in ("omega_fl", "omega_fr") for rear in ("omega_rl", "omega_rr"))
_CHANNELS = (
    LogChannel("t", "time", "s", "time", ("time", "timestamp", "timestamps", "stamp", "elapsed_time", "interval",
               "session_time", "device_time"), 1e11),
    LogChannel("steer", "steering: as the ratio or the map of the car reads it, positive to the left", "rad", "angle",
               ("steering", "steering_angle", "steered_angle", "steer_angle", "delta", "swa",
               "steering_wheel_angle", "hand_wheel_angle", "road_wheel_angle", "steer_sw"), 20.0,
               source="the CAN bus of the car (OBD has none) or a sensor"),
    LogChannel("speed", "forward speed", "m/s", "speed", ("v", "vx", "v_x", "velocity", "velocity_x", "ground_speed",
               "vehicle_speed", "gps_speed", "corr_speed", "velocity_kmh", "wheel_speed", "twist_linear_x", "v_ego"),
               150.0, 0.005, (*_WHEELS, POSE)),
    *(
        LogChannel(f"omega_{corner}", f"spin of the wheel {corner}", "rad/s", "rotation",
                   (f"wheel_speed_{corner}", f"wheel_angular_speed_{corner}", f"wheel_angular_velocity_{corner}",
                    f"wheel_rpm_{corner}", f"rpm_{corner}"),
                   2000.0, 0.01, with_unit=(f"wheel_{corner}", f"w_{corner}"))
        for corner in ("fl", "fr", "rl", "rr")
    ),
    LogChannel("yaw_rate", "yaw rate, positive to the left", "rad/s", "rotation", ("r", "yawrate", "psi_dot",
               "gyro_z", "gz", "wz", "w_z", "omega_z", "angular_velocity_z", "angular_z", "gyro_rad_2",
               "gyro_yaw_velocity", "yaw_velocity", "gyro_yaw", "yaw", "rotation_rate_z",
               "rate_of_rotation_z", "angle_rate_z", "angular_rate_z", "AVz"),
               12.0, 2e-4, (POSE,), "a gyroscope, which phones have (ay/speed and the rate of a GPS course are the "
               "turn of the path, not of the car)"),
    LogChannel("ax", "longitudinal acceleration, positive forward", "m/s^2", "acceleration",
               ("a_x", "acceleration_x", "longitudinal_acceleration", "a_ego", "g_force_long", "longitudinal_g",
               "g_long", "lineal_g", "inline_acceleration", "linear_acceleration_x", "accelerometer_m_s2_0"), 80.0,
               2e-3),
    LogChannel("ay", "lateral acceleration, positive to the left", "m/s^2", "acceleration",
               ("a_y", "acceleration_y", "lateral_acceleration", "g_force_lat", "lateral_g", "g_lat",
               "linear_acceleration_y", "accelerometer_m_s2_1"), 80.0, 2e-3, (POSE,),
               "an accelerometer near the center of gravity"),
    LogChannel("beta", "sideslip angle at the reference point, positive to the left", "rad", "angle",
               ("sideslip", "slip_angle", "side_slip", "sideslip_angle", "side_slip_angle"), 1.6, 2e-4),
    LogChannel("vy", "lateral speed at the reference point, positive to the left", "m/s", "speed",
               ("v_y", "lateral_speed", "lateral_velocity"), 50.0, 2e-3),
    LogChannel("x", "position of the reference point, global x", "m", "length", ("pos_x", "position_x", "east"), 1e7,
               1e-4),
    LogChannel("y", "position of the reference point, global y", "m", "length", ("pos_y", "position_y", "north"), 1e7,
               1e-4),
    LogChannel("heading", "heading, from the global x axis to the left", "rad", "angle", ("yaw", "psi", "yaw_angle"),
               1e4, 1e-4),
)  # fmt: skip
#: Names of the vertical acceleration. It shows the axes: at rest it reads +9.81 m/s^2 with z up, -9.81 with z down.
VERTICAL = ("az", "a_z", "acceleration_z", "vertical_acceleration", "g_force_vert", "linear_acceleration_z",
            "accelerometer_m_s2_2")  # fmt: skip
#: Names of what a car has and a bench has not.
POSITIONS = ("latitude", "longitude", "gps_latitude", "gps_longitude")
#: Words of names that are written in several ways.
SHORT = {"acceleration": "acc", "accel": "acc", "lateral": "lat", "longitudinal": "long", "lon": "long",
         "vertical": "vert", "gs": "g", "gforce": "g", "steering": "steer", "whl": "wheel", "ang": "angle",
         "spd": "speed", "vel": "velocity", "gyroscope": "gyro", "gyr": "gyro", "speeds": "speed",
         "lf": "fl", "rf": "fr", "lr": "rl",
         "angvel": "angular_velocity", "xv": "x", "yv": "y", "zv": "z"}  # fmt: skip
#: Channels that change sign between axes forward, left, up and forward, right, down.
TURNED = ("steer", "yaw_rate", "ay", "beta", "vy", "y", "heading")
LOG_CHANNELS: dict[str, LogChannel] = {declared.name: declared for declared in _CHANNELS}
#: Channels that an estimate needs.
NEEDED = ("steer", "yaw_rate", "ay", "speed")
#: Where numbers of a steering end that are shares of the lock.
FULL_LOCK = (1.0, 100.0)
#: Radius of wheels in m whose spin in rad/s has the numbers of the speed in km/h, and relative distance from it.
RADIUS_OF_KMH, NEAR = 1.0 / 3.6, 0.02
#: Units that logs have, SI first.
UNITS = {
    "steer": ("rad", "deg"), "speed": ("m/s", "km/h", "mph"), "yaw_rate": ("rad/s", "deg/s"), "ay": ("m/s^2", "g"),
}  # fmt: skip
WHEEL_SPEEDS = {"front": ("omega_fl", "omega_fr"), "rear": ("omega_rl", "omega_rr")}


def lacking(names: Collection[str]) -> list[LogChannel]:
    """Return the needed channels that a log with these names lacks, and of which it has no substitute.

    >>> [channel.name for channel in lacking(("steer", "omega_fl", "omega_rr", "ay"))]
    ['yaw_rate']
    """
    needed = [LOG_CHANNELS[name] for name in NEEDED if name not in names]
    return [channel for channel in needed if not any(set(group) <= set(names) for group in channel.instead)]


def share_of_lock(steer: npt.NDArray[np.float64]) -> str:
    """Return that numbers of a steering without a unit end where those of a joystick do; empty if they do not.

    >>> share_of_lock(np.array([0.0, -1.0, 1.0])).partition(",")[0], share_of_lock(np.array([0.0, -1.0, 1.1]))
    ('steer ends at exactly -1 and 1', '')
    """
    finite = steer[np.isfinite(steer)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)
    if high not in FULL_LOCK or low != -high:
        return ""
    divided = "" if high == 1.0 else f"divide it by {high:g} and "
    return (
        f"steer ends at exactly {low:g} and {high:g}, as a share of the lock does: {divided}state map = [[-1, -LOCK], "
        "[1, LOCK]] in [steering] of the car, with the lock of the front wheels in rad"
    )
