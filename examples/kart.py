"""A kart on four tires with hub inputs, compared with a monolithic simulation of the same equations.

    python kart.py

The kart is one rigid body: it has no suspension, and the tires are its springs. It brakes in a turn over a bump on an
inclined road whose right side is slippery. The FMUs get the motion of the wheel carriers and the road and return forces
at the wheel centres; their wheels spin inside. The host integrates the body only, with forces that are constant over a
step. The monolithic simulation has the body, the lagged slips and the spins in one right-hand side.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from vehicle import instances

import tirefmu
from tirefmu.tires import Tire, published
from tirefmu.tires.code.modules import numpy_module
from tirefmu.tires.hub import hub_wrench, wheel_motion

FloatArray = npt.NDArray[np.float64]

MASS, INERTIA = 90.0, np.array([8.0, 14.0, 20.0])  # kg, kg m^2
#: The wheel centres in the axes of the body, m: front left, front right, rear left, rear right.
CORNERS = np.array([[0.6, 0.55, 0.0], [0.6, -0.55, 0.0], [-0.5, 0.55, 0.0], [-0.5, -0.55, 0.0]])
GRAVITY = np.array([0.0, 0.0, -9.81])
SPEED, END, BUMP = 12.0, 1.0, 0.006
PARAMETERS = {"VERTICAL_STIFFNESS": 3e4, "VERTICAL_DAMPING": 200.0, "WHEEL_INERTIA": 0.12}
AXES = "xyz"
MOTION = (
    *(f"r_{a}" for a in AXES), *(f"R_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)), *(f"v_{a}" for a in AXES),
    *(f"w_{a}" for a in AXES), "road_z", *(f"road_n{a}" for a in AXES), "road_mu",
)  # fmt: skip
WRENCH = ("F_x_global", "F_y_global", "F_z_global", "M_x", "M_z", "brake_torque")


def tire() -> Tire:
    """Return the tire at all corners."""
    return published("trento_hoosier").in_signs("iso")


def steering(t: float) -> tuple[float, float]:
    """Return the steering angle of the front wheels, rad, and its rate."""
    share = np.clip((t - 0.1) / 0.3, 0.0, 1.0)
    return 0.04 * share**2 * (3.0 - 2.0 * share), 0.04 * 6.0 * share * (1.0 - share) / 0.3


def brake(t: float) -> float:
    """Return the brake torque of each wheel, N m."""
    share = np.clip((t - 0.3) / 0.3, 0.0, 1.0)
    return float(12.0 * share**2 * (3.0 - 2.0 * share))


def road(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return height, normal, shape (n, 3), and friction of the road: a slope, a bump, a slippery right side."""
    along = np.clip((x - 5.0) / 2.0, 0.0, 1.0)
    height = 0.03 * x + BUMP * np.sin(np.pi * along) ** 4
    rise = 0.03 + BUMP * 4.0 * np.sin(np.pi * along) ** 3 * np.cos(np.pi * along) * np.pi / 2.0
    return height, np.stack([-rise, 0.0 * x, 1.0 + 0.0 * x], axis=-1), 0.8 + 0.2 * np.tanh(4.0 * y)


def carriers(t: float, r: FloatArray, turned: Rotation, v: FloatArray, w: FloatArray) -> FloatArray:
    """Return the inputs `MOTION` of the four tires, shape (4, n)."""
    angle, rate = steering(t)
    arms = turned.apply(CORNERS)
    centres, velocities = r + arms, v + np.cross(w, arms)
    steer = Rotation.from_euler("z", [[angle], [angle], [0.0], [0.0]])
    rates = w + np.array([rate, rate, 0.0, 0.0])[:, None] * turned.apply([0.0, 0.0, 1.0])
    height, normal, friction = road(centres[:, 0], centres[:, 1])
    matrices = (turned * steer).as_matrix().reshape(4, 9)
    return np.column_stack([centres, matrices, velocities, rates, height, normal, friction])


def accelerations(
    inputs: FloatArray, wrench: FloatArray, turned: Rotation, w: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the accelerations of the body by the wrenches `WRENCH` of the tires, shape (4, 6)."""
    forces, (Mx, Mz, braked) = wrench[:, :3], wrench[:, 3:].T
    moments = np.einsum("nij,nj->ni", inputs[:, 3:12].reshape(4, 3, 3), np.column_stack([Mx, -braked, Mz]))
    moment = (np.cross(turned.apply(CORNERS), forces) + moments).sum(axis=0)
    inertia = turned.as_matrix() @ np.diag(INERTIA) @ turned.as_matrix().T
    return forces.sum(axis=0) / MASS + GRAVITY, np.linalg.solve(inertia, moment - np.cross(w, inertia @ w))


def start() -> tuple[FloatArray, Rotation, FloatArray, FloatArray]:
    """Return position, orientation, velocity and angular velocity: the kart rests on the slope with its weight."""
    slope = np.arctan(0.03)
    sunk = MASS * -GRAVITY[2] * np.cos(slope) / 4.0 / PARAMETERS["VERTICAL_STIFFNESS"]
    turned = Rotation.from_euler("y", -slope)
    up, ahead = turned.apply([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    return (tire().values["UNLOADED_RADIUS"] - sunk) * up, turned, SPEED * ahead, np.zeros(3)


def cosimulate(fmu: Path, step: float) -> FloatArray:
    """Return position and velocity of the body at the end, and the spins: shape (10,)."""
    r, turned, v, w = start()
    spin = SPEED / tire().values["UNLOADED_RADIUS"]
    with instances(fmu, [f"tire {i}" for i in range(4)]) as tires:
        for instance, motion in zip(tires, carriers(0.0, r, turned, v, w), strict=True):
            instance.set([*PARAMETERS, "omega", *MOTION], [*PARAMETERS.values(), spin, *motion])
            instance.fmu.exitInitializationMode()
        for i in range(round(END / step)):
            t = i * step
            inputs = carriers(t, r, turned, v, w)
            a, turning = accelerations(inputs, np.array([each.get(WRENCH) for each in tires]), turned, w)
            v, w = v + step * a, w + step * turning
            r, turned = r + step * v, Rotation.from_rotvec(step * w) * turned
            for instance, motion in zip(tires, carriers(t + step, r, turned, v, w), strict=True):
                instance.set([*MOTION, "T_brake"], [*motion, brake(t + step / 2.0)])
                instance.fmu.doStep(t, step)
        return np.array([*r, *v, *(each.get(["omega"])[0] for each in tires)])


def monolithic() -> FloatArray:
    """Return the same, with all equations in one right-hand side."""
    model = tire()
    code, parameters = numpy_module(model.book), dict(zip(model.book.parameters, model.parameters(), strict=True))
    free, sigma = model.values["UNLOADED_RADIUS"], 0.5 * model.values["UNLOADED_RADIUS"]

    def slope(t: float, state: FloatArray) -> FloatArray:
        r, v, w = state[:3], state[7:10], state[10:13]
        turned = Rotation.from_quat(state[3:7])
        kappa, tangent, omega = state[13:].reshape(3, 4)
        inputs = carriers(t, r, turned, v, w)
        given = dict(zip(MOTION, inputs.T, strict=True))
        friction = given.pop("road_mu")
        motion = wheel_motion(**given, omega=omega)
        load = PARAMETERS["VERTICAL_STIFFNESS"] * (free - motion["R_l"])
        load = np.where(load > 0.0, np.maximum(load - PARAMETERS["VERTICAL_DAMPING"] * motion["R_l_rate"], 0.0), 0.0)
        scaled = parameters | {name: parameters[name] * friction for name in model.book.friction_scales}
        Fx, Fy, Mz = code.forces([kappa, np.arctan(tangent), motion["gamma"], load], list(scaled.values()))
        placed = {name: value for name, value in given.items() if name.startswith(("R_", "road_n"))}
        hub = hub_wrench(Fx=Fx, Fy=Fy, Fz=load, Mz=Mz, R_l=motion["R_l"], **placed)
        braked = -brake(t) * np.sign(omega)
        wrench = np.column_stack([*(hub[name] for name in WRENCH[:5]), braked])
        a, turning = accelerations(inputs, wrench, turned, w)
        speed = np.abs(motion["V_x"])
        quaternion = 0.5 * (Rotation.from_quat([*w, 0.0]) * turned).as_quat() * np.linalg.norm(w) if np.any(w) else 0.0
        return np.concatenate([
            v, np.broadcast_to(quaternion, 4), a, turning,
            (motion["wheel_speed"] * free - motion["V_x"] - speed * kappa) / sigma,
            (motion["V_y"] - speed * tangent) / sigma,
            (hub["M_y"] + braked) / PARAMETERS["WHEEL_INERTIA"],
        ])  # fmt: skip

    r, turned, v, w = start()
    first = np.concatenate([r, turned.as_quat(), v, w, np.zeros(8), np.full(4, SPEED / free)])
    run = solve_ivp(slope, (0.0, END), first, rtol=1e-7, atol=1e-8, max_step=0.01)
    if not run.success:
        raise RuntimeError(run.message)
    return np.concatenate([run.y[:3, -1], run.y[7:10, -1], run.y[-4:, -1]])


def errors(steps: tuple[float, ...]) -> list[float]:
    """Return the largest error at the end by communication step, as a share of distance, speed and spin."""
    exact = monolithic()
    size = np.concatenate([np.full(3, SPEED * END), np.full(3, SPEED), exact[6:]])
    with tempfile.TemporaryDirectory() as folder:
        fmu = tirefmu.export(tire(), Path(folder) / "tire.fmu", fmi=2, inputs="hub-torque")
        return [float(np.max(np.abs(cosimulate(fmu, step) - exact) / size)) for step in steps]


def main() -> int:
    """Compare at several communication steps. Return 0 if the error is below 0.1 % at 1 ms."""
    steps = (0.004, 0.002, 0.001)
    found = errors(steps)
    for step, error in zip(steps, found, strict=True):
        print(f"{1e3 * step:g} ms: {error:.3%}")
    return 0 if found[-1] < 1e-3 else 1


if __name__ == "__main__":
    sys.exit(main())
