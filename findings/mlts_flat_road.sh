#!/usr/bin/env bash
# The lap time of MLTS-point-mass does not change with the banking and the slope of its track.
#
# Expected:  a circle of 50 m banked by 30 degrees to the inside is driven faster than a flat one, one banked to the outside slower; on a circle
#            that climbs and falls by 20 % the speed varies.
# Happens:   all four have one lap time and one speed, in all digits. Slope, banking and elevation move the drawn borders of the track; the
#            dynamics have no gravity. No message says so; the columns are in the list of inputs, with their signs.
# Matters:   an outer bank of 30 degrees holds a car with a friction of 1 at 11 m/s in place of 22 m/s, an inner one at 43 m/s. A lap
#            that is compared with a log, or whose loads go into tires, is that of a flat track.
# Source:    MLTS-point-mass 0.1.0 on PyPI (October 2026), run on 2026-11-29. Its page: "optional elevation, slope (positive uphill), banking
#            (positive: right side up), default 0".
# Guess written down before, from its page: faster on the inner bank, slower on the outer one.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages MLTS-point-mass==0.1.0 casadi==3.8.2 numpy==2.3.5 pandas==2.3.3 2>/dev/null
cat >lap.py <<'END_OF_PYTHON'
import contextlib
import io

import numpy as np
import pandas as pd
from mlts_point_mass import MLTS

RADIUS, FRICTION, G = 50.0, 1.0, 9.81
along = np.linspace(0.0, 2.0 * np.pi * RADIUS, 201)
heading, level = along / RADIUS, np.zeros(201)
direction = np.tile(np.linspace(-np.pi / 2.0, np.pi / 2.0, 19), 4)
forward, left = FRICTION * G * np.sin(direction), FRICTION * G * np.cos(direction)
CIRCLE = pd.DataFrame({"V": np.repeat([5.0, 20.0, 40.0, 60.0], 19), "ax": forward, "ay": left})
QUIET = {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes"}


def lap(banking=0.0, slope=0.0):
    """Return lap time in s and the lowest and highest speed in m/s of a left circle, banking in rad, slope as the sine of its largest angle."""
    track = pd.DataFrame({
        "abscissa": along, "curvature": level + 1.0 / RADIUS, "dir_mid_line": heading,
        "x_mid_line": RADIUS * np.sin(heading), "y_mid_line": RADIUS * (1.0 - np.cos(heading)),
        "width_no_kerbs_L": level + 1.0, "width_no_kerbs_R": level + 1.0,
        "elevation": slope * RADIUS * (1.0 - np.cos(heading)), "slope": np.arcsin(slope * np.sin(heading)), "banking": level + banking,
    })  # fmt: skip
    with contextlib.redirect_stdout(io.StringIO()):
        result = MLTS(track, {"W_total": 1.9, "v_max": 60.0}, CIRCLE).solution([0, 0, 15, 0, 0], mesh=4.0, ipopt_options=QUIET)
    assert result["success"]
    return float(result["time"][-1]), float(result["V"].min()), float(result["V"].max())


roads = {"flat": {}, "inner bank of 30 deg": {"banking": np.pi / 6}, "outer bank": {"banking": -np.pi / 6}, "hill of 20 %": {"slope": 0.2}}
seen = {}
for name, road in roads.items():
    seen[name] = lap(**road)
    print(f"{name}: lap of {seen[name][0]:.3f} s, {seen[name][1]:.2f} to {seen[name][2]:.2f} m/s")
for name, tangent in (("inner", np.tan(np.pi / 6)), ("outer", -np.tan(np.pi / 6))):
    speed = np.sqrt(RADIUS * G * (FRICTION + tangent) / (1.0 - FRICTION * tangent))
    print(f"with gravity, {name} bank: {speed:.1f} m/s")
assert all(np.allclose(values, seen["flat"], rtol=1e-9) for values in seen.values()) and 13.0 < seen["flat"][0] < 15.0
END_OF_PYTHON
PYTHONPATH=packages python3 lap.py
