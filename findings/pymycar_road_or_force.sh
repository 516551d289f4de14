#!/usr/bin/env bash
# The quarter car of pymycar takes a road, its half car and car take a force under the same name; body and wheel exchange their velocities.
#
# Expected:  a car with four equal corners, all of them on the same road, moves as its quarter does; the velocity of the body is the slope of
#            its position.
# Happens:   the quarter car multiplies wheel_excitation by the stiffness of the tire (a road in m), the half car and the car take
#            custom_excitation as it is (a force in N): on a road of 30 mm the body of the quarter moves 36 mm, that of the car 0.3 um. With
#            the road times the stiffness, as the package's example of the car does without a word, they agree. The attributes zs_dot
#            and zu_dot of the quarter car, and its columns in data.txt, are exchanged: zs_dot is the velocity of the wheel.
# Matters:   a road that was tried on the quarter car hardly moves the car, which looks like perfect comfort. A damper is chosen by the
#            velocity of body and wheel, and its comfort by that of the body: both are the other one's.
# Source:    pymycar 0.0.3 (June 2026) on PyPI, run on 2026-11-30. Its docstrings name both "Custom excitation function".
# Guess written down before: quarter car, half car and car agree, without pitch and roll.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages pymycar==0.0.3 scipy==1.16.3 matplotlib==3.10.7 pyvista==0.46.4 pandas==2.3.3 tabulate==0.9.0 \
    numpy==2.3.5 2>/dev/null
cat >car.py <<'END'
import numpy as np
from pymycar.Vehicle.car import MyCar
from pymycar.Vehicle.chassis import Chassis
from pymycar.Vehicle.suspension import SimpleSuspension
from pymycar.Vehicle.wheel import Wheel
from pymycar.VerticalModels.models import VerticalCar, VerticalHalfCar, VerticalQuarterCar

TIMES = np.linspace(0.0, 2.0, 2001)
STIFFNESS = 125560.0


def road(t):
    """Return the height of the road, m."""
    return 0.03 * np.sin(2.0 * np.pi * 2.0 * t)


chassis = Chassis(front_axle_to_com=0.8, rear_axle_to_com=0.8, front_track=0.6, rear_track=0.6, com_height=0.4,
                  mass=160.0, inertia_x=100.0, inertia_y=100.0, inertia_z=1320.0, drag_coefficient=0.34, lift_coefficient=0.0)
wheels = [Wheel(mass=10.0, radial_stiffness=STIFFNESS, radial_damping=0.0) for _ in range(4)]
springs = [SimpleSuspension(stiffness=35000.0, damper=2800.0) for _ in range(4)]
car = MyCar(chassis, *wheels, *springs)

quarter = VerticalQuarterCar(car)
quarter.time_points, quarter.wheel_excitation = TIMES, road
quarter.solve()
size = np.abs(quarter.zs).max()
print(f"quarter car on a road of 30 mm: the body moves {1e3 * size:.1f} mm")
for kind in (VerticalHalfCar, VerticalCar):
    moved = []
    for excitation in (road, lambda t: STIFFNESS * road(t)):
        model = kind(car, excitation, TIMES)
        model.solve()
        moved.append(model.Zs)
    print(f"{kind.__name__}: the same road {1e6 * np.abs(moved[0]).max():.2f} um, times the stiffness {1e3 * np.abs(moved[1]).max():.1f} mm")
    assert np.abs(moved[1] - quarter.zs).max() < 0.01 * size
    assert np.abs(moved[0]).max() < 1e-6
slopes = {"body": np.gradient(quarter.zs, TIMES), "wheel": np.gradient(quarter.zu, TIMES)}
for name in ("zs_dot", "zu_dot"):
    errors = {part: np.abs(getattr(quarter, name) - slope).max() for part, slope in slopes.items()}
    print(f"{name} differs from the velocity of", ", ".join(f"the {part} by {error:.3f} m/s" for part, error in errors.items()))
    assert min(errors, key=errors.get) == ("wheel" if name == "zs_dot" else "body") and min(errors.values()) < 0.02
END
PYTHONPATH=packages python3 car.py >seen.txt
grep -E "^(quarter|Vertical|z)" seen.txt
