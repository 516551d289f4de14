#!/usr/bin/env bash
# A table of a tire as a B-spline of CasADi has no force at all a billionth beyond its last slip angle, and an optimizer that starts there has finished.
#
# Expected:  beyond a table of side force over slip angle, "linear" goes on with the last slope and "bspline" with the last polynomial, or both
#            refuse; an optimizer finds its way back.
# Happens:   "linear" goes on with the last slope. "bspline" is 0 with slope 0 on both sides: 3.5 kN at 0.2 rad, 0 at 0.200000001 rad. Of
#            the slip angle that gives 2 kN, IPOPT says "Solve_Succeeded" where it starts beyond the table, with a force of 0.
# Matters:   tables of forces, of engines and of aerodynamics are splines in lap time simulations, since IPOPT needs second derivatives, and a lap
#            is started from a rough guess. A car that slides, or a load beyond the table, has no grip, no error and no gradient.
# Source:    casadi 3.8.2 on PyPI, run on 2026-11-30.
# Guess written down before: "linear" continues the last slope, "bspline" the last polynomial.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages casadi==3.8.2 numpy==2.3.5 2>/dev/null
cat >table.py <<'END'
import casadi
import numpy as np

ANGLES = np.linspace(0.0, 0.2, 21)
FORCES = 3500.0 * np.sin(1.4 * np.arctan(10.0 * ANGLES))


def slip_angle(force, start):
    """Return the status of IPOPT, the slip angle at which it ends, rad, and its force, N, for a wanted force of 2 kN."""
    alpha = casadi.MX.sym("alpha")
    options = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes"}
    solver = casadi.nlpsol("solver", "ipopt", {"x": alpha, "f": ((force(alpha) - 2000.0) / 1000.0) ** 2}, options)
    end = float(solver(x0=start)["x"])
    return solver.stats()["return_status"], round(end, 4), round(float(force(end)))


seen = {}
for kind in ("linear", "bspline"):
    force = casadi.interpolant("force", kind, [ANGLES.tolist()], FORCES.tolist())
    alpha = casadi.MX.sym("alpha")
    slope = casadi.Function("slope", [alpha], [casadi.jacobian(force(alpha), alpha)])
    seen[kind] = {at: (round(float(force(at))), round(float(slope(at)))) for at in (-0.01, 0.2, 0.2 + 1e-9, 0.25)}
    print(f"{kind}: force (N) and slope (N/rad) at slip angles (rad):", seen[kind])
    for start in (0.19, 0.21):
        seen[kind, start] = slip_angle(force, start)
        print(f"  2 kN wanted, started at {start} rad:", seen[kind, start])
assert seen["bspline"][0.2 + 1e-9] == seen["bspline"][0.25] == seen["bspline"][-0.01] == (0, 0)
assert seen["linear"][0.2] == seen["linear"][0.2 + 1e-9] and seen["linear"][0.25][0] > seen["linear"][0.2][0]
assert seen["bspline"][0.2][0] == seen["linear"][0.2][0] > 3000
assert seen["bspline", 0.21] == ("Solve_Succeeded", 0.21, 0) and seen["bspline", 0.19][2] == 2000
assert seen["linear", 0.21][2] == 2000
END
PYTHONPATH=packages python3 table.py
