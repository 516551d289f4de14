"""A kart on four tires with hub inputs, compared with a monolithic simulation of the same equations.

    python kart.py [brake-in-turn|lane-change|launch|park] [--plot FILE]

The kart is one rigid body: it has no suspension, and the tires are its springs. It brakes in a turn over a bump on an
inclined road whose right side is slippery, changes lanes as in ISO 3888-1, accelerates on the same inclined road, or
stands on a slope of 20 % with its brakes. The FMUs get the motion of the wheel carriers and the road and return forces
at the wheel centres; their wheels spin inside. The host integrates the body only, with forces that are constant over a
step. The monolithic simulation has the body, the lagged slips and the spins in one right-hand side. It has no equations
of standstill: the launch begins at a walking pace, and a parked kart is only required to stand.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np
import numpy.typing as npt
from kart_body import MOTION, RADIUS, STIFFNESS, WRENCH, accelerations, carriers, start
from kart_manoeuvres import MANOEUVRES, Manoeuvre
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from vehicle import instances

import tirefmu
from tirefmu.tires import Tire, published
from tirefmu.tires.code.modules import numpy_module
from tirefmu.tires.hub import hub_wrench, wheel_motion

FloatArray = npt.NDArray[np.float64]

PARAMETERS = {"VERTICAL_STIFFNESS": STIFFNESS, "VERTICAL_DAMPING": 200.0, "WHEEL_INERTIA": 0.12}
#: The launch begins above the speeds at which the equations of standstill act, m/s.
MOVING = {"LOW_SPEED": 0.1}
STEPS = (0.004, 0.002, 0.001)


def tire() -> Tire:
    """Return the tire at all corners."""
    return published("trento_hoosier").in_signs("iso")


def cosimulate(fmu: Path, manoeuvre: Manoeuvre, step: float) -> FloatArray:
    """Return position and velocity of the body and the spins at each communication point, shape (n, 10)."""
    r, turned, v, w = start(manoeuvre)
    spin = manoeuvre.speed / RADIUS
    parameters = PARAMETERS | (MOVING if manoeuvre.speed else {})
    rows = []
    with instances(fmu, [f"tire {i}" for i in range(4)]) as tires:
        for instance, motion in zip(tires, carriers(manoeuvre, 0.0, r, turned, v, w), strict=True):
            instance.set([*parameters, "omega", *MOTION], [*parameters.values(), spin, *motion])
            instance.fmu.exitInitializationMode()
        for i in range(round(manoeuvre.end / step) + 1):
            t, middle = i * step, (i + 0.5) * step
            inputs = carriers(manoeuvre, t, r, turned, v, w)
            wrench = np.array([tire.get([*WRENCH, "omega"]) for tire in tires])
            rows.append([*r, *v, *wrench[:, -1]])
            drive, brake = manoeuvre.drive(middle), manoeuvre.brake(middle)
            a, turning = accelerations(inputs, wrench[:, :-1], drive, turned, w)
            v, w = v + step * a, w + step * turning
            r, turned = r + step * v, Rotation.from_rotvec(step * w) * turned
            moved = carriers(manoeuvre, t + step, r, turned, v, w)
            for instance, motion, torques in zip(tires, moved, zip(drive, brake, strict=True), strict=True):
                instance.set([*MOTION, "T_drive", "T_brake"], [*motion, *torques])
                instance.fmu.doStep(t, step)
    return np.array(rows)


def monolithic(manoeuvre: Manoeuvre, times: FloatArray) -> FloatArray:
    """Return the same at given times, with all equations in one right-hand side."""
    model = tire()
    code, parameters = (
        numpy_module(model.symbolic_model),
        dict(zip(model.symbolic_model.parameters, model.parameters(), strict=True)),
    )
    free, sigma = model.values["UNLOADED_RADIUS"], 0.5 * model.values["UNLOADED_RADIUS"]

    def slope(t: float, state: FloatArray) -> FloatArray:
        r, v, w = state[:3], state[7:10], state[10:13]
        turned = Rotation.from_quat(state[3:7])
        kappa, tangent, omega = state[13:].reshape(3, 4)
        inputs = carriers(manoeuvre, t, r, turned, v, w)
        given = dict(zip(MOTION, inputs.T, strict=True))
        friction = given.pop("road_mu")
        motion = wheel_motion(**given, omega=omega)
        load = PARAMETERS["VERTICAL_STIFFNESS"] * (free - motion["R_l"])
        load = np.where(load > 0.0, np.maximum(load - PARAMETERS["VERTICAL_DAMPING"] * motion["R_l_rate"], 0.0), 0.0)
        scales = model.symbolic_model.motion.friction_scales
        scaled = parameters | {name: parameters[name] * friction for name in scales}
        Fx, Fy, Mz = code.forces([kappa, np.arctan(tangent), motion["gamma"], load], list(scaled.values()))
        placed = {name: value for name, value in given.items() if name.startswith(("R_", "road_n"))}
        hub = hub_wrench(Fx=Fx, Fy=Fy, Fz=load, Mz=Mz, R_l=motion["R_l"], **placed)
        drive, braked = manoeuvre.drive(t), -manoeuvre.brake(t) * np.sign(omega)
        wrench = np.column_stack([*(hub[name] for name in WRENCH[:5]), braked])
        a, turning = accelerations(inputs, wrench, drive, turned, w)
        speed = np.abs(motion["V_x"])
        quaternion = 0.5 * (Rotation.from_quat([*w, 0.0]) * turned).as_quat() * np.linalg.norm(w) if np.any(w) else 0.0
        return np.concatenate([
            v, np.broadcast_to(quaternion, 4), a, turning,
            (motion["wheel_speed"] * free - motion["V_x"] - speed * kappa) / sigma,
            (motion["V_y"] - speed * tangent) / sigma,
            (hub["M_y"] + drive + braked) / PARAMETERS["WHEEL_INERTIA"],
        ])  # fmt: skip

    r, turned, v, w = start(manoeuvre)
    first = np.concatenate([r, turned.as_quat(), v, w, np.zeros(8), np.full(4, manoeuvre.speed / free)])
    run = solve_ivp(slope, (0.0, times[-1]), first, t_eval=times, rtol=1e-7, atol=1e-8, max_step=0.01)
    if not run.success:
        raise RuntimeError(run.message)
    return np.concatenate([run.y[:3], run.y[7:10], run.y[-4:]]).T


def export(folder: Path) -> Path:
    """Write the FMU of the tire."""
    return tirefmu.export(tire(), folder / "tire.fmu", fmi=2, inputs="hub-torque")


def errors(computed: FloatArray, exact: FloatArray) -> float:
    """Return the largest error at the end, as a share of distance, speed and spin."""
    distance, speed = (np.linalg.norm(exact[:, part], axis=1).max() for part in (slice(3), slice(3, 6)))
    size = np.concatenate([np.full(3, distance), np.full(3, speed), np.abs(exact[:, 6:]).max(axis=0)])
    return float(np.max(np.abs(computed[-1] - exact[-1]) / size))


def plot(file: Path, times: FloatArray, runs: dict[str, tuple[FloatArray, FloatArray]]) -> None:
    """Draw path, speed and spins of some runs."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 7.0), layout="constrained")
    path, speed, spin = figure.subplots(3, 1)
    for name, (t, rows) in runs.items():
        style = {"color": "black", "linewidth": 0.8} if name == "monolithic" else {"linewidth": 2.5, "alpha": 0.5}
        path.plot(rows[:, 0], rows[:, 1], label=name, **style)
        speed.plot(t, np.linalg.norm(rows[:, 3:6], axis=1), **style)
        for i, corner in enumerate(("front left", "front right", "rear left", "rear right")):
            line_style = style if name == "monolithic" else {**style, "color": f"C{i}", "label": corner}
            spin.plot(t, rows[:, 6 + i], **line_style)
    path.set(xlabel="x (m)", ylabel="y (m)")
    speed.set(xlabel="t (s)", ylabel="speed (m/s)", xlim=(0.0, times[-1]))
    spin.set(xlabel="t (s)", ylabel="spin (rad/s)", xlim=(0.0, times[-1]))
    for axes in (path, spin):
        axes.legend(frameon=False)
    figure.savefig(file, dpi=110)


def parked(rows: FloatArray) -> int:
    """Print how far a parked kart creeps. Return 0 if it stands: less than 0.1 mm/s over the second half."""
    later = rows[len(rows) // 2 :]
    creep, spins = np.linalg.norm(later[:, 3:6], axis=1).max(), np.abs(later[:, 6:]).max()
    print(f"park: speed up to {1e3 * creep:.2g} mm/s, spin up to {spins:g} rad/s")
    return 0 if creep < 1e-4 and spins == 0.0 else 1


def main() -> int:
    """Compare at several communication steps. Return 0 if the error is below 0.2 % at 1 ms."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("manoeuvre", nargs="?", default="brake-in-turn", choices=MANOEUVRES)
    parser.add_argument("--plot", type=Path, help="figure of the paths, speeds and spins")
    given = parser.parse_args()
    manoeuvre, runs = MANOEUVRES[given.manoeuvre], {}
    with tempfile.TemporaryDirectory() as folder:
        fmu = export(Path(folder))
        for step in STEPS:
            rows = cosimulate(fmu, manoeuvre, step)
            runs[f"{1e3 * step:g} ms"] = step * np.arange(len(rows)), rows
    times = runs["4 ms"][0]
    if given.manoeuvre == "park":
        status = max(parked(rows) for _, rows in runs.values())
    else:
        exact = monolithic(manoeuvre, times)
        worst = [errors(rows, exact) for _, rows in runs.values()]
        for name, error in zip(runs, worst, strict=True):
            print(f"{given.manoeuvre}, {name}: {error:.3%}")
        runs["monolithic"] = times, exact
        status = 0 if worst[-1] < 2e-3 else 1
    if given.plot:
        plot(given.plot, times, {name: runs[name] for name in ("4 ms", "monolithic") if name in runs})
    return status


if __name__ == "__main__":
    sys.exit(main())
