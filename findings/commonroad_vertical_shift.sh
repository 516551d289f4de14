#!/usr/bin/env bash
# The Magic Formula of commonroad-vehicle-models adds the vertical shift, a force in N, to an angle inside the sine.
#
# Expected:  Fx = D sin(C atan(...)) + SV with SV = Fz p_vx1: for its car 1, -0.009 N a kN of load, which nobody notices.
#            A wheel that rolls without slip has the force of the horizontal shift, 2.7 % of the load, at every load.
# Happens:   Fx = D sin(C atan(...) + SV). SV counts as radians, so that the shift grows with the square of the load:
#            the rolling wheel drives with 1.7 % of the load at 1 kN, brakes with 1.4 % at 4 kN and with 7.6 % at 10 kN.
#            Fy has its shift outside the sine, as in the book.
# Matters:   this car is the reference of planners and of estimators of friction. A drive of it holds an effect of load that
#            no tire file can have; 2 to 3 % of the load are the whole of free rolling.
# Source:    commonroad-vehicle-models 3.0.2 on PyPI (vehiclemodels/utils/tire_model.py), run on 2026-11-28; the formula is
#            4.E9 in Pacejka, Tire and Vehicle Dynamics, 3rd edition.
# Guess written down before: pure slip as in the book, to the last digits.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages commonroad-vehicle-models==3.0.2 2>/dev/null
cat >rolling.py <<'END'
from math import atan, isclose, sin

from vehiclemodels.parameters_vehicle1 import parameters_vehicle1
from vehiclemodels.utils.tire_model import formula_longitudinal

tire = parameters_vehicle1().tire
shares = {}
for load in (1000.0, 4000.0, 10000.0):
    peak = tire.p_dx1 * load
    x = tire.p_kx1 * load / (tire.p_cx1 * peak) * tire.p_hx1
    angle = tire.p_cx1 * atan(x - tire.p_ex1 * (x - atan(x)))
    shift = load * tire.p_vx1
    force = formula_longitudinal(0.0, 0.0, load, tire)
    shares[load] = 100 * force / load
    print(f"load {load:5.0f} N, no slip: {shares[load]:+.2f} % of the load; "
          f"book {100 * (peak * sin(angle) + shift) / load:+.2f} %")
    assert isclose(force, peak * sin(angle + shift), rel_tol=1e-9)
assert shares[1000.0] > 1.6 and shares[4000.0] < -1.3 and shares[10000.0] < -7.5
END
PYTHONPATH=packages python3 rolling.py
