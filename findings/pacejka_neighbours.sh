#!/usr/bin/env bash
# In pacejka 0.1.0 the force at one slip angle depends on the other slip angles of the same call.
#
# Expected:  slip angles are in one stated unit, and an array gives what its values give one by one.
# Happens:   without `alpha_unit` the unit is found from the values: degrees if any of the array is beyond pi/2, radians
#            else. One degree alone is one radian (the full grip); beside a value of 2 it is a degree, a quarter of it.
#            A sweep to 1.5 degrees is on the plateau of the tire from its second point. The docstring says that the unit
#            is detected; nothing is printed when it happens.
# Matters:   fits and integrators call with one point, plots with many: they disagree by a factor of 4. A vehicle in degrees
#            is right in fast corners and wrong in gentle ones.
# Source:    pacejka 0.1.0 (2026-10) on PyPI, run on 2026-11-28.
# Guess written down before: radians, stated in the documentation.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages pacejka==0.1.0 2>/dev/null
cat >sweep.py <<'END'
from pacejka import Tire

tire = Tire.from_macro_properties("tire", 1.0, cornering_stiffness_per_deg=150, longitudinal_stiffness=8000, f_z0=700)
alone = tire.calculate_lateral_force(700.0, [1.0])[0]
beside = tire.calculate_lateral_force(700.0, [1.0, 2.0])[0]
stated = tire.calculate_lateral_force(700.0, [1.0], alpha_unit="deg")[0]
small, large = (tire.calculate_lateral_force(700.0, alpha) for alpha in (1.5, 2.0))
print(f"load 700 N, alpha 1: {alone:.0f} N alone, {beside:.0f} N beside alpha 2, {stated:.0f} N as stated degrees")
print(f"alpha 1.5 gives {small:.0f} N, alpha 2.0 gives {large:.0f} N")
assert beside == stated < 150 and alone > 4 * beside and small > 2 * large
END
PYTHONPATH=packages python3 sweep.py
