#!/usr/bin/env bash
# Two of the three cars of vehicle-dynamics-sim turn as if their wheels were steered twice as far.
#
# Expected:  at walking pace every car follows the geometry: yaw rate = speed * tan(steering) / wheelbase.
# Happens:   the car of two degrees of freedom does. Those of seven and ten degrees turn twice as fast: a radius of 14 m
#            instead of 28 m at 0.1 rad, at any steering. Velocities are turned into the axes of the wheel, and the steering is
#            added to their angle again. As the force is then not across the slip, these cars get faster in a turn without torque.
# Matters:   its examples calibrate these models; stiffness that is fitted to a measured drive makes up for a doubled steering, and a
#            controller that was made with the small model steers the large ones twice as far.
# Source:    vehicle-dynamics-sim 0.1.2 on PyPI (August 2026), run on 2026-11-29. All three describe the same input, "front steering
#            angle [rad]".
# Guess written down before: the yaw rate of the geometry for all three.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages vehicle-dynamics-sim==0.1.2 2>/dev/null
cat >turn.py <<'END_OF_PYTHON'
from math import tan

import numpy as np
from vdsim.models.tires import LinearTireParams
from vdsim.models.vehicle import dof2, dof7, dof10

BODY = {"g": 9.81, "m": 1500.0, "lf": 1.4, "lr": 1.4, "r": 0.3, "iz": 2500.0}
WHEELS = {"h": 0.5, "L1": 0.75, "L2": 0.75, "ir": 1.2, "ra": 0.0, "s": 0.0, "cx": 0.0}
SPRINGS = {"ms": 1350.0, "ix": 600.0, "iy": 2300.0, **{f"ks{i}": 3e4 for i in (1, 2, 3, 4)},
           **{f"ds{i}": 3e3 for i in (1, 2, 3, 4)}}  # fmt: skip
TIRES = [LinearTireParams(Cx=80e3, Cy=80e3)] * 4
SMALL, LARGE, LARGEST = (
    dof2.VehiclePhysicalParams2DOF(**BODY),
    dof7.VehiclePhysicalParams7DOF(**BODY, **WHEELS),
    dof10.VehiclePhysicalParams10DOF(**BODY, **WHEELS, **SPRINGS),
)
CARS = {
    "DOF2": dof2.DOF2(dof2.VehicleConfig2DOF(SMALL, *TIRES)),
    "DOF7": dof7.DOF7(dof7.VehicleConfig7DOF(LARGE, *TIRES)),
    "DOF10": dof10.DOF10(dof10.VehicleConfig10DOF(LARGEST, *TIRES)),
}
SPEED, STEP = 3.0, 5e-4
for name, car in CARS.items():
    for steering in (0.02, 0.1):
        start = dict.fromkeys(car.state_keys, 0.0) | {"vx": SPEED}
        start |= {key: SPEED / BODY["r"] for key in start if key.startswith("omega")}
        start |= {key: WHEELS["h"] for key in start if key == "z"}  # the height at rest
        state, inputs = np.array(list(start.values())), np.array([0.0, 0.0, 0.0, 0.0, steering, 0.0])
        for _ in range(4000):
            state = state + STEP * np.asarray(car.get_dx__dt(state, inputs)[0])
        speed, yaw_rate = (state[car.state_keys[key]] for key in ("vx", "psidt"))
        right = speed * tan(steering) / (BODY["lf"] + BODY["lr"])
        print(f"{name:5} steering {steering:4} rad: {SPEED} m/s become {speed:.3f} m/s, yaw rate {yaw_rate:.4f} rad/s, "
              f"of the geometry {right:.4f}: {yaw_rate / right:.3f} times")
        assert abs(yaw_rate / right - (1.0 if name == "DOF2" else 2.0)) < 0.02
        assert (speed > SPEED) == (name != "DOF2")
END_OF_PYTHON
PYTHONPATH=packages python3 turn.py
