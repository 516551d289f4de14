#!/usr/bin/env bash
# A road of roadprofile is up to three times as rough if its points are further apart, or if it is short.
#
# Expected:  a road of class A by ISO 8608 with waves of 0.0078 to 4 cycles/m is 6.4 mm rough (rms), whatever its points and its length.
# Happens:   on 100 m it is 8 mm with points each 0.1 m, 15 mm at 0.5 m and 20 mm at 1 m; 1000 m with points each 1 m are as rough as
#            100 m each 0.1 m. The number of waves is half of the number of points, and the longest of them, of 128 m, has the height of
#            all waves in its share of the band. Class B has 13 mm.
# Matters:   wheel loads of a ride are simulated on such roads. Who takes a coarser grid to save time, or a shorter road, gets another
#            road, and what is compared between two grids is the generator.
# Source:    roadprofile 1.0.4 on PyPI (June 2026), run on 2026-11-29. Its page shows that its spectrum is that of the standard; its
#            classes have the upper limit of the standard as their mean (class A: 32e-6 m^3, in the middle of the class 16e-6).
# Guess written down before: the same roughness at every step.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages roadprofile==1.0.4 numpy==2.3.5 scipy==1.16.3 2>/dev/null
cat >roughness.py <<'END_OF_PYTHON'
from math import sqrt

import numpy as np
from roadprofile import RoadProfile

SEEN = {(100.0, 0.1): 1.28, (100.0, 0.5): 2.33, (100.0, 1.0): 3.22, (1000.0, 1.0): 1.28}
np.random.seed(1)
road = RoadProfile()
road.set_profile_class("A")
right = sqrt(road.Gdn0 * road.n0**2 * (1.0 / road.n_min - 1.0 / road.n_max))
print(f"by the spectrum of the class: {1e3 * right:.1f} mm")
for (length, step), times in SEEN.items():
    squares = [np.mean(road.generate(length, step).profile ** 2) for _ in range(200)]
    ratio = sqrt(np.mean(squares)) / right
    print(f"{length:.0f} m, points each {step} m: {1e3 * ratio * right:.1f} mm, {ratio:.2f} times")
    assert abs(ratio / times - 1.0) < 0.05
END_OF_PYTHON
PYTHONPATH=packages python3 roughness.py
