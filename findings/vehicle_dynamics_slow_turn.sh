#!/usr/bin/env bash
# The car of vehicle_dynamics turns at walking pace as fast as at 54 km/h: its circle shrinks with the speed.
#
# Expected:  at a fixed steering angle a slow car runs on the circle of its wheels: radius = wheelbase / angle at 2, 4 and 8 m/s.
# Happens:   below 15 m/s a slip angle is a velocity divided by 15 m/s. The yaw rate becomes that of 15 m/s whatever the speed, and
#            the radius speed / 15 m/s of the right one: 7.5 m instead of 56 m at 2 m/s.
# Matters:   parking, urban driving and a planner tuned at low speed; a tire or a steering ratio estimated there is wrong by that factor.
# Source:    vehicle_dynamics 1.0.7 on PyPI (project ROADVIEW), run on 2026-11-28. Its page names no lowest speed.
# Guess written down before: the circle of the wheels, within a few percent.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv packages
packages/bin/pip install --quiet vehicle_dynamics==1.0.7 numpy==2.4.0 2>/dev/null
cat >circle.py <<'END'
import logging

import numpy as np
import yaml

logging.disable(logging.CRITICAL)
from vehicle_dynamics.structures.StateVector import StateVector
from vehicle_dynamics.VehicleDynamics import VehicleDynamics

RADIUS, WHEELBASE, RATIO, LOCK = 0.32, 2.8, 15.0, 6.0
engine = {"idle_rpm": 700, "minimum_rpm": 600, "maximum_rpm": 7000, "w_table": [0.0, 3000.0, 8000.0]}
engine |= {"torque_max": [300.0, 300.0, 300.0], "inertia": 0.2}
converter = {"speed_ratio": [0, 0.9, 1], "ratio": [2.0, 1.0, 1.0], "factor": [0.003, 0.002, 0.001]}
converter |= {"CONVERTER_SYNC_TIME": 10, "lock_up_ratio": 0.9}
gearbox = {"MIN_GEAR_CHANGE_INTERVAL": 100, "gear_ratio": [0, 4.0, 2.0], "efficiency": 0.9, "inertia": 0.1}
gearbox |= {"gear_max_rpm": [[0.0, 6500, 6500]] * 11, "gear_min_rpm": [[0.0, 700, 700]] * 11}
curve = {"peak_friction": 1.0, "shape_factor": 1.3}
car = {
    "powertrain": {"bias": [0.25] * 4, "engine": engine, "torque_converter": converter, "gearbox": gearbox,
                   "differential": {"ratio": 3.0, "driveshaft_inertia": 1.0}},
    "brake": {"max_braking_torque": 10000.0, "brake_bias": [0.3, 0.2, 0.3, 0.2]},
    "steering": {"maximum_steering_angle": LOCK, "ratio": RATIO},
    "tire": {"relaxation": 0.1, "inertia": [1.5] * 4, "rolling_resistance_coefficient": 0.0, "dynamic_radius": [RADIUS] * 4,
             "longitudinal": curve | {"slip_stiffness": 22.0}, "lateral": curve | {"cornering_coefficient": 25.0}},
    "aerodynamics": {"air_drag_coefficient": 0.0, "front_area": 2.0, "air_density": 1.2},
    "suspension": {"roll_bar_stiffness": 0.0, "pitch_centre_height": 0.5, "roll_centre_height": 0.5,
                   "unsprung_mass": [40.0] * 4, "spring_rate": [20000.0] * 4, "damping_rate": [3000.0] * 4},
    "body": {"lf": WHEELBASE / 2, "lr": WHEELBASE / 2, "wl": 0.8, "wr": 0.8, "sz": 0.5, "mass": 1600.0,
             "i_x_s": 600.0, "i_y_s": 2200.0, "i_z": 2500.0},
}  # fmt: skip
with open("car.yaml", "w") as file:
    yaml.safe_dump(car, file)

angle = 0.05
right = WHEELBASE / angle
for speed in (2.0, 4.0, 8.0, 20.0):
    model = VehicleDynamics(StateVector(vx=speed), 1, 1000, "car.yaml")
    state = model.current_states
    for _ in range(3000):
        state.x_a.vx = speed
        state.wheel_w_vel = np.full(4, speed / RADIUS)
        model.wheels.wheels(state, angle * RATIO / LOCK)
        model.body.body(state)
    radius = speed / abs(state.x_a.wz)
    print(f"{speed:4.0f} m/s: yaw rate {abs(state.x_a.wz):.3f} rad/s, radius {radius:5.1f} m; wheelbase / angle = {right:.1f} m")
    assert abs(radius / right - min(1.0, speed / 15.0)) < 0.08
END
packages/bin/python circle.py
