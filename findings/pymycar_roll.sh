#!/usr/bin/env bash
# A symmetric car of pymycar rolls when all four wheels are excited alike.
#
# Expected:  a car whose left and right sides are equal heaves and pitches, and does not roll.
# Happens:   it rolls, by 0.29 of its pitch angle, at rest and while its springs carry nothing. The terms of roll and pitch add both
#            sides of an axle where those of roll and heave subtract them; with these signs they would cancel.
# Matters:   roll, frequencies and dampers of the model with seven degrees of freedom are those of another car. The coupling
#            vanishes only if stiffness * track * distance to the center of gravity is equal at both axles.
# Source:    pymycar 0.0.3 on PyPI (June 2026), run on 2026-11-29: `VerticalCar`, its matrices of stiffness and of damping.
# Guess written down before: by symmetry no roll; by the source, which was read before the run, some.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
# It draws by pyvista, and imports it also where nothing is drawn.
python3 -m pip install --quiet --target packages pymycar==0.0.3 scipy==1.15.3 pandas==2.3.1 tabulate==0.9.0 \
    pyvista==0.46.3 2>/dev/null
cat >roll.py <<'END_OF_PYTHON'
import numpy as np
from pymycar.Vehicle.car import MyCar
from pymycar.Vehicle.chassis import Chassis
from pymycar.Vehicle.suspension import SimpleSuspension
from pymycar.Vehicle.wheel import Wheel
from pymycar.VerticalModels.models import VerticalCar

chassis = Chassis(front_axle_to_com=1.1, rear_axle_to_com=1.5, front_track=1.5, rear_track=1.5, com_height=0.5, mass=1200.0,
                  inertia_x=400.0, inertia_y=1600.0, inertia_z=1800.0)  # fmt: skip
parts = {}
for side in ("left", "right"):
    for axle, stiffness in (("front", 2e5), ("rear", 3e5)):  # the front tires are softer: the car pitches
        wheel, suspension = Wheel(), SimpleSuspension()
        wheel.mass, wheel.radial_stiffness, wheel.radial_damping = 40.0, stiffness, 100.0
        suspension.stiffness, suspension.damper = 25e3, 1500.0
        parts |= {f"{side}_{axle}_wheel": wheel, f"{side}_{axle}_suspension": suspension}
model = VerticalCar(MyCar(chassis, **parts), lambda t: 1000.0, np.linspace(0.0, 20.0, 2001))
heave, roll, pitch = model.solve()[-1, :3]
print(f"1 kN at each wheel, 20 s: heave {1e3 * heave:.2f} mm, pitch {1e3 * pitch:.3f} mrad, roll {1e3 * roll:.3f} mrad")
print(f"stiffness between roll and heave {model.K[1, 0]:g} N, between roll and pitch {model.K[1, 2]:g} N m")
assert model.K[1, 0] == 0.0
assert model.K[1, 2] == -15000.0
assert 0.2 < abs(roll / pitch) < 0.4
END_OF_PYTHON
PYTHONPATH=packages python3 roll.py
