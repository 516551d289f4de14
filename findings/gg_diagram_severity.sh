#!/usr/bin/env bash
# The harder a car is driven, the smaller the severity that gg-diagram gives it, and the shorter its drive.
#
# Expected:  one minute in which ay swings to a peak: its deviation (std_gy, "severity metric") is 0.7 times the peak, and the distance is that
#            of the speed, 1.2 km, at every peak.
# Happens:   up to 1.5 g so; beyond, samples are left out of the metrics as of the picture, without a word. Swings to 2 g have 0.91 g of
#            1.41 g and half of the distance, swings to 3 g 0.88 g, less than those to 1.4 g. A table in g, which its page says it accepts,
#            is divided by g again: 0.07 g of 0.70 g, also with unit="g".
# Matters:   a car on slicks or with downforce reaches 2 to 4 g. Compared before and behind a change of tires, the better tire has the
#            smaller g-g diagram.
# Source:    gg-diagram 0.2.0 on PyPI (April 2026), run on 2026-11-29. Its page: "Auto unit detection -- accepts m/s2, g, or mG".
# Guess written down before: the deviation grows with the peak; a table in g and one in m/s2 give one result.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages gg-diagram==0.2.0 numpy==2.3.5 pandas==2.3.3 2>/dev/null
cat >severity.py <<'END_OF_PYTHON'
import numpy as np
import pandas as pd
from gg_diagram import gg_heatmap

G, SPEED, RATE = 9.80665, 20.0, 100.0
time = np.arange(0.0, 60.0, 1.0 / RATE)


def metrics(peak, one, **options):
    """Return std_gy in g and the distance in km of swings to a peak in g, from a table whose unit is one m/s^2."""
    ay = peak * np.sin(time) * G / one
    table = pd.DataFrame({"ax": 0.2 * ay, "ay": ay, "speed_mps": SPEED})
    found = gg_heatmap(table, ax_col="ax", ay_col="ay", hz=RATE, **options)._gg_meta
    return round(float(found["std_gy"]), 2), round(float(found["total_distance_km"]), 1)


seen = {}
for peak in (1.0, 1.4, 2.0, 3.0):
    seen[peak] = metrics(peak, 1.0)
    print(f"swings to {peak} g, in m/s^2: std_gy {seen[peak][0]} g of {peak * np.std(np.sin(time)):.2f} g, {seen[peak][1]} km of 1.2 km")
seen["g"], seen["g, stated"] = metrics(1.0, G), metrics(1.0, G, unit="g")
print(f"swings to 1.0 g, in g: std_gy {seen['g'][0]} g; with unit='g' {seen['g, stated'][0]} g")
assert seen == {1.0: (0.7, 1.2), 1.4: (0.99, 1.2), 2.0: (0.91, 0.7), 3.0: (0.88, 0.4), "g": (0.07, 1.2), "g, stated": (0.07, 1.2)}
END_OF_PYTHON
PYTHONPATH=packages python3 severity.py
