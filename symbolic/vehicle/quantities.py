"""Quantities of the two-track vehicle.

Axes are those of ISO 8855: x forward, y left, z up, origin at the center of gravity.
"""

from __future__ import annotations

from ..declarations import Quantity

CORNERS = ("fl", "fr", "rl", "rr")

MOTION = (
    Quantity("v_x", "m/s", "forward speed of the center of gravity", typical=15.0),
    Quantity("v_y", "m/s", "lateral speed of the center of gravity", typical=1.0),
    Quantity("yaw_rate", "rad/s", "yaw rate", typical=0.5),
)
RATES = (
    Quantity("v_x_dot", "m/s^2", "rate of the forward speed"),
    Quantity("v_y_dot", "m/s^2", "rate of the lateral speed"),
    Quantity("yaw_rate_dot", "rad/s^2", "rate of the yaw rate"),
)
STEER = Quantity("steer", "rad", "steering angle of both front wheels, positive to the left", typical=0.05)
TURNED = (
    Quantity("delta_f", "rad", "angle of both front wheels with that of roll and compliance", typical=0.05),
    Quantity("delta_r", "rad", "angle of both rear wheels", typical=0.001),
)
LAG = (
    Quantity("a_x_lag", "m/s^2", "what the lag of pitch adds to the longitudinal acceleration that moves load"),
    Quantity("a_y_lag", "m/s^2", "what the lag of roll adds to the lateral acceleration that moves load"),
)
HEAVE = (Quantity("a_z", "m/s^2", "vertical acceleration of the body, up, that cornering causes"),)
SUSPENSION = (
    Quantity("steer_f", "rad s^2/m", "angle that lateral acceleration takes from the front wheels: understeer"),
    Quantity("steer_r", "rad s^2/m", "angle that lateral acceleration adds to the rear wheels: understeer"),
    Quantity("camber", "rad s^2/m", "inclination of all wheels over lateral acceleration, out of a turn"),
)
CAR = (
    Quantity("m", "kg", "mass"),
    Quantity("I_z", "kg m^2", "yaw inertia"),
    Quantity("l_f", "m", "distance of the front axle from the center of gravity"),
    Quantity("l_r", "m", "distance of the rear axle from the center of gravity"),
    Quantity("w_f", "m", "front track"),
    Quantity("w_r", "m", "rear track"),
    Quantity("h", "m", "height of the center of gravity"),
    Quantity("roll_front", "1", "share of the roll stiffness at the front axle"),
    Quantity("drag", "N s^2/m^2", "drag force over the square of the speed"),
    Quantity("down_f", "N s^2/m^2", "downforce of the front axle over the square of the speed"),
    Quantity("down_r", "N s^2/m^2", "the same of the rear axle"),
)
SENSOR = (
    Quantity("s_x", "m", "position of the sensor, forward"),
    Quantity("s_y", "m", "position of the sensor, to the left"),
    Quantity("roll_gradient", "rad s^2/m", "roll angle over lateral acceleration"),
    Quantity("misalignment", "rad", "angle of the sensor about the vertical axis, to the left"),
)
FORCES = tuple(
    Quantity(f"{force}_{corner}", "N", f"{text} of the tire {corner}, W axes", typical=1000.0)
    for force, text in (("Fx", "longitudinal force"), ("Fy", "side force"))
    for corner in CORNERS
)
WHEELS = tuple(
    Quantity(f"{name}_{corner}", unit, f"{text} of the wheel {corner}")
    for name, unit, text in (("alpha", "rad", "slip angle"), ("V", "m/s", "forward speed"), ("Fz", "N", "load"))
    for corner in CORNERS
)
TURNING = (*TURNED, Quantity("gamma", "rad", "inclination angle of all wheels"))
BALANCE = (
    Quantity("F_x_front", "N", "longitudinal force of the front axle, vehicle axes"),
    Quantity("F_x_rear", "N", "longitudinal force of the rear axle"),
    Quantity("F_y_front", "N", "side force of the front axle, vehicle axes"),
    Quantity("F_y_rear", "N", "side force of the rear axle"),
    Quantity("e_x", "N", "longitudinal force that the motion requires beyond the tires'"),
    Quantity("e_front", "N", "side force at the front axle that the motion requires beyond the tires'"),
    Quantity("e_rear", "N", "side force at the rear axle that the motion requires beyond the tires'"),
)
ACCELERATIONS = (
    Quantity("v_x_dot", "m/s^2", "rate of the forward speed that the forces cause"),
    Quantity("v_y_dot", "m/s^2", "rate of the lateral speed that the forces cause"),
    Quantity("yaw_rate_dot", "rad/s^2", "rate of the yaw rate that the forces cause"),
)
READINGS = (
    Quantity("sensor_a_x", "m/s^2", "longitudinal acceleration that the sensor measures"),
    Quantity("sensor_a_y", "m/s^2", "lateral acceleration that the sensor measures, gravity of a rolled body included"),
    Quantity("sensor_v_x", "m/s", "forward speed of the sensor"),
    Quantity("sensor_v_y", "m/s", "lateral speed of the sensor"),
)
