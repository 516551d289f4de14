#!/usr/bin/env bash
# A car of slipx that reverses goes straight on, whatever its steering.
#
# Expected:  a reversing car turns about the same center as forward: yaw rate = speed * tan(steering) / wheelbase, negative for
#            steering to the left. The kinematic model of the same package does.
# Happens:   with both dynamic models the yaw rate is 0 (L1), or 1 to 10 % of the right one with the other sign (L2), at any speed and
#            steering. Forward, the same calls turn.
# Matters:   parking, recovery from a wall, three-point turns: plans that were made with the kinematic model fail in the finer ones
#            of the same interface, and a learner finds that steering does nothing in reverse.
# Source:    slipx 0.2.0 on PyPI (August 2026), run on 2026-11-29. A comment in its source says that reversing tires lag as rolling
#            ones do; no page says that they do not steer.
# Guess written down before: the yaw rate of the geometry, within 10 %, on all three models.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages slipx==0.2.0 2>/dev/null
cat >reverse.py <<'END'
from math import tan

import slipx

car = slipx.load_reference_car()
for name in ("L0_Kinematic", "L1_Bicycle", "L2_DoubleTrack"):
    tier = getattr(slipx.Tier, name)
    for speed in (3.0, 1.0, -1.0, -3.0):
        model, state = slipx.VehicleModel.create(tier, car.params_for_tier(tier)), slipx.VehicleState()
        state.vel_body.x = speed
        for _ in range(3000):
            accelerator = slipx.hold_speed(state, speed)
            model.step(state, slipx.DriveInput(steer_cmd=0.1, accel_cmd=accelerator), 1e-3)
        right = state.vel_body.x * tan(0.1) / car.params.wheelbase
        print(f"{name:14} {state.vel_body.x:5.2f} m/s, steering 0.1 rad: yaw rate {state.yaw_rate:7.3f} rad/s, "
              f"of the geometry {right:7.3f}")
        share = state.yaw_rate / right
        assert share > 0.75 if speed > 0 or name == "L0_Kinematic" else abs(share) < 0.15
END
PYTHONPATH=packages python3 reverse.py
