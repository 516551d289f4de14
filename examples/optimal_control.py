"""Launch and stop of a wheel with a mass: the longest way in four seconds from standstill to standstill.

The tire is printed as a CasADi function (`tirefmu generate --language casadi`), saved to a file and loaded from it. The
states are the speeds of the mass and of the wheel, the control is the torque. Slip is regularized at standstill. Run it
with "python optimal_control.py".
"""

from __future__ import annotations

import importlib.util
import sys
import tempfile
from pathlib import Path

import casadi as ca
import numpy as np

from tirefmu.applications.exports.printout import generate
from tirefmu.tires import published

MASS, INERTIA, GRAVITY = 100.0, 0.4, 9.81
LARGEST_TORQUE = 800.0
DURATION, STEPS = 4.0, 100
#: Speed below which slip is no longer proportional to 1/V, m/s.
SLOW = 0.5


def tire_function(folder: Path) -> tuple[ca.Function, tuple[str, ...]]:
    """Print the Trento team's tire and return its saved function, read from the file, and the names of its inputs."""
    generate("trento_hoosier", "casadi", folder, functions=["forces"], only=["Fx"])
    spec = importlib.util.spec_from_file_location("trento_hoosier", folder / "trento_hoosier.py")
    if spec is None or spec.loader is None:
        raise ImportError(folder)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    path = str(folder / "forces.casadi")
    module.function("forces").save(path)
    return ca.Function.load(path), module.INPUTS


def solve(tire: ca.Function, inputs: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Return time, speed, wheel speed, torque, slip and way of the optimal motion."""
    radius = published("trento_hoosier").values["UNLOADED_RADIUS"]
    opti = ca.Opti()
    # Scaled for the solver: the wheel's speed as that of its tread, torque and force as shares of the largest torque.
    v, tread, share = opti.variable(STEPS + 1), opti.variable(STEPS + 1), opti.variable(STEPS)
    torque, step = LARGEST_TORQUE * share, DURATION / STEPS
    tread_gain = step * radius * LARGEST_TORQUE / INERTIA

    def slip_and_force(v: ca.MX, tread: ca.MX) -> tuple[ca.MX, ca.MX]:
        slip = (tread - v) / ca.sqrt(v**2 + SLOW**2)
        column = {"kappa": slip, "Fz": MASS * GRAVITY}
        return slip, tire(ca.vertcat(*(column.get(name, 0.0) for name in inputs)))

    slips = []
    for k in range(STEPS):  # implicit Euler: the wheel is stiff at low speed
        slip, force = slip_and_force(v[k + 1], tread[k + 1])
        opti.subject_to(v[k + 1] == v[k] + step * force / MASS)
        change = (tread[k + 1] - tread[k]) / tread_gain
        opti.subject_to(share[k] == change + radius * force / LARGEST_TORQUE)
        slips.append(slip)
    way = step * ca.sum1(v)
    opti.minimize(-way + 1e-2 * ca.sumsqr(ca.diff(share)))
    opti.subject_to(opti.bounded(-1, share, 1))
    opti.subject_to(opti.bounded(-0.3, ca.vertcat(*slips), 0.3))
    opti.subject_to([v[0] == 0, tread[0] == 0, v[-1] == 0, tread[-1] == 0])
    guess = np.minimum(np.arange(STEPS + 1), np.arange(STEPS + 1)[::-1]) * step * 20
    opti.set_initial(v, guess)
    opti.set_initial(tread, guess)
    opti.solver("ipopt", {"print_time": False}, {"print_level": 0, "sb": "yes", "max_iter": 500})
    solution = opti.solve()
    values = {"v": v, "omega": tread / radius, "torque": torque, "slip": ca.vertcat(*slips)}
    result = {name: np.asarray(solution.value(value)) for name, value in values.items()}
    return {**result, "t": np.linspace(0, DURATION, STEPS + 1), "way": np.asarray(solution.value(way))}


def main() -> int:
    """Solve, print one line, and check it against the bound of constant friction."""
    with tempfile.TemporaryDirectory() as folder:
        tire, inputs = tire_function(Path(folder))
        motion = solve(tire, inputs)
        grid = np.linspace(-0.3, 0.3, 601)
        columns = [{"kappa": slip, "Fz": MASS * GRAVITY} for slip in grid]
        forces = [float(tire([column.get(name, 0.0) for name in inputs])) for column in columns]
    drive, brake = max(forces) / MASS, -min(forces) / MASS
    # The largest accelerations alone: v grows for a share of the time, then falls.
    bound = 0.5 * DURATION**2 * drive * brake / (drive + brake)
    share = float(motion["way"]) / bound
    print(f"way {float(motion['way']):.2f} m, {share:.1%} of the bound, top speed {motion['v'].max():.1f} m/s, "
          f"slip {motion['slip'].min():.3f} to {motion['slip'].max():.3f}")  # fmt: skip
    return 0 if 0.85 < share <= 1.0 else 1


if __name__ == "__main__":
    sys.exit(main())
