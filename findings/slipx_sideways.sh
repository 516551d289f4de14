#!/usr/bin/env bash
# A car of slipx that slides sideways, as after a spin, never stops: its double-track model has no side force there.
#
# Expected:  a car that slides at 90 degrees has four tires across the motion: it decelerates with mu g and stops from 3 m/s
#            within half a meter. The single-track model of the same package does.
# Happens:   with the double-track model (L2, the finer one) it still has 3.000 m/s after 5 s and 15 m. The lagged slip angle
#            changes with the forward speed over the relaxation length, and this car has no forward speed. At 85 degrees the
#            slide is several times too long, too.
# Matters:   spins, drifts and recovery of small race cars: a controller or a learner sees a car on ice after each spin, and
#            the finer model is the wrong one.
# Source:    slipx 0.2.0 on PyPI (August 2026), run on 2026-11-29. Its pages state that a wheel without motion has no lag that
#            changes; they do not mention a slide.
# Guess written down before: both models decelerate with about mu g, in a straight line.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages slipx==0.2.0 2>/dev/null
cat >slide.py <<'END'
from math import cos, radians, sin

import slipx

SPEED, DURATION, STEP = 3.0, 5.0, 1e-3
car = slipx.load_reference_car()
shortest = SPEED**2 / (2 * car.params.mu_clip * 9.81)
paths = {}
for tier in (slipx.Tier.L1_Bicycle, slipx.Tier.L2_DoubleTrack):
    for angle in (85, 90):
        model, state = slipx.VehicleModel.create(tier, car.params_for_tier(tier)), slipx.VehicleState()
        state.vel_body.x, state.vel_body.y = SPEED * cos(radians(angle)), SPEED * sin(radians(angle))
        path = 0.0
        for _ in range(round(DURATION / STEP)):
            model.step(state, slipx.DriveInput(), STEP)
            path += (state.vel_body.x**2 + state.vel_body.y**2) ** 0.5 * STEP
        paths[tier.name, angle] = path
        print(f"{tier.name:14} slide at {angle} deg: {path:5.2f} m in {DURATION:g} s, then {state.vel_body.y:.3f} m/s sideways "
              f"(mu g stops it in {shortest:.2f} m)")
assert abs(paths["L1_Bicycle", 90] - shortest) < 0.05
assert abs(paths["L2_DoubleTrack", 90] - SPEED * DURATION) < 1e-3
assert paths["L2_DoubleTrack", 85] > 2.5 * paths["L1_Bicycle", 85]
END
PYTHONPATH=packages python3 slide.py
