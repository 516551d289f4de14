#!/usr/bin/env bash
# With friction a car of highway-env corners at 2.7 g and backs out of a parking space ten meters aside.
#
# Expected:  "dynamical", "whether to simulate dynamics (i.e. friction) rather than kinematics", limits the lateral acceleration to that of a tire, of
#            about 1 g; at walking pace, forward and back, it differs little from the kinematic car.
# Happens:   the force of a tire is proportional to its slip angle without a limit: 26 m/s^2 at 20 m/s and 0.3 rad, more than the
#            kinematic car. In reverse the slip angle is measured from the nose of the car, that is pi for a wheel that rolls straight
#            back: at -5 m/s with 0.05 rad the car is 9.8 m aside after 4 s and turned by 52 deg; without friction by 1.5 m and 11 deg.
# Matters:   a policy that is trained in parking or racing with "dynamical" learns to drive on rails in curves and fights a force of several g in
#            reverse. Lanes that are too fast for a car are not.
# Source:    highway-env 1.12.1 (August 2026) on PyPI, run on 2026-11-30.
# Guess written down before: friction limits the lateral acceleration to about 1 g; in reverse both cars agree.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages highway-env==1.12.1 numpy==2.3.5 2>/dev/null
cat >cars.py <<'END'
import numpy as np
from highway_env.vehicle.dynamics import BicycleVehicle
from highway_env.vehicle.kinematics import Vehicle


def driven(kind, speed, steering):
    """Return meters aside and degrees turned after 4 s at 15 Hz, and the largest lateral acceleration, m/s^2."""
    car = kind(None, [0.0, 0.0], 0.0, speed)
    car.act({"acceleration": 0.0, "steering": steering})
    headings = [0.0]
    for _ in range(60):
        car.step(1 / 15)
        headings.append(float(np.ravel(car.heading)[0]))
    lateral = np.abs(15.0 * speed * np.diff(headings)).max()
    return round(float(car.position[1]), 1), round(float(np.degrees(headings[-1]))), round(float(lateral), 1)


seen = {}
for speed, steering in ((5.0, 0.05), (-5.0, 0.05), (20.0, 0.3)):
    for name, kind in (("kinematic", Vehicle), ("with friction", BicycleVehicle)):
        seen[name, speed] = aside, turned, lateral = driven(kind, speed, steering)
        print(f"{name}, {speed} m/s, {steering} rad: {aside} m aside, turned by {turned} deg, {lateral} m/s^2")
assert seen["with friction", 20.0][2] > seen["kinematic", 20.0][2] > 2.4 * 9.81
assert seen["kinematic", -5.0][:2] == (1.5, -11) and seen["with friction", -5.0][:2] == (9.8, -52)
assert abs(seen["kinematic", 5.0][0] - seen["with friction", 5.0][0]) < 0.2
END
PYTHONPATH=packages python3 cars.py 2>/dev/null
