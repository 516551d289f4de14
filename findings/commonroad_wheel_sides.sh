#!/usr/bin/env bash
# The wheels "left" of the multi-body car of commonroad-vehicle-models are the outer ones of a left turn.
#
# Expected:  positive steering, yaw rate and lateral speed are those of a turn to the left, as in all models of this package
#            (x = v cos(psi), y = v sin(psi)); the left wheels are then the inner ones: slower, and with less load.
# Happens:   the wheels LF and LR are the faster ones, and carry the load that the turn moves outwards.
# Matters:   the states 24 to 27 are named left front, right front, left rear, right rear. Who logs them under these names has
#            exchanged sides: in a turn at 0.45 rad/s and 18 m/s, a slip of each wheel that is computed from its spin is wrong by
#            3 %, with opposite signs. An estimator of tires takes that for another friction (10 % of the friction of an axle).
# Source:    commonroad-vehicle-models 3.0.2 on PyPI (vehiclemodels/vehicle_dynamics_mb.py), run on 2026-11-28. The model is that
#            of the US DOT (1990s), whose axes are those of SAE: y to the right, a positive yaw rate is a turn to the right.
# Guess written down before: a tire model that errs by a few percent; nobody looked for exchanged sides.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages commonroad-vehicle-models==3.0.2 2>/dev/null
cat >turn.py <<'END'
import numpy as np
from vehiclemodels.init_mb import init_mb
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb

p = parameters_vehicle2()
state = np.array(init_mb([0.0, 0.0, 0.0, 15.0, 0.0, 0.0, 0.0], p), dtype=np.float64)
for _ in range(3000):  # 3 s: steering to +0.03 rad
    rates = vehicle_dynamics_mb(list(state), [(0.03 - state[2]) / 0.1, 2.0 * (15.0 - state[3])], p)
    state += 0.001 * np.array(rates)
left, right = p.R_w * state[[23, 25]], p.R_w * state[[24, 26]]
print(f"steering {state[2]:+.3f} rad, heading {state[4]:+.2f} rad, y {state[1]:+.1f} m, yaw rate {state[5]:+.3f} rad/s")
print(f"rims LF, LR {left.round(2)} m/s; RF, RR {right.round(2)} m/s")
assert state[1] > 0.0 and state[5] > 0.0 and (left > right).all()
END
PYTHONPATH=packages python3 turn.py
