"""The rigid body of a kart: the motion of its wheel carriers and its accelerations by the forces of the tires."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from kart_manoeuvres import Manoeuvre
from scipy.spatial.transform import Rotation

FloatArray = npt.NDArray[np.float64]

MASS, INERTIA = 90.0, np.array([8.0, 14.0, 20.0])  # kg, kg m^2
#: The wheel centres in the axes of the body, m: front left, front right, rear left, rear right.
CORNERS = np.array([[0.6, 0.55, 0.0], [0.6, -0.55, 0.0], [-0.5, 0.55, 0.0], [-0.5, -0.55, 0.0]])
#: Free radius, m, and vertical stiffness, N/m, of the tires.
RADIUS, STIFFNESS = 0.2304, 3e4
GRAVITY = np.array([0.0, 0.0, -9.81])
AXES = "xyz"
MOTION = (
    *(f"r_{a}" for a in AXES), *(f"R_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)), *(f"v_{a}" for a in AXES),
    *(f"w_{a}" for a in AXES), "road_z", *(f"road_n{a}" for a in AXES), "road_mu",
)  # fmt: skip
WRENCH = ("F_x_global", "F_y_global", "F_z_global", "M_x", "M_z", "brake_torque")


def carriers(
    manoeuvre: Manoeuvre, t: float, r: FloatArray, turned: Rotation, v: FloatArray, w: FloatArray
) -> FloatArray:
    """Return the inputs `MOTION` of the four tires, shape (4, n)."""
    angle, rate = manoeuvre.driver(t, r, turned.apply([1.0, 0.0, 0.0]), v, w)
    arms = turned.apply(CORNERS)
    centres, velocities = r + arms, v + np.cross(w, arms)
    steer = Rotation.from_euler("z", [[angle], [angle], [0.0], [0.0]])
    rates = w + np.array([rate, rate, 0.0, 0.0])[:, None] * turned.apply([0.0, 0.0, 1.0])
    height, normal, friction = manoeuvre.road(centres[:, 0], centres[:, 1])
    matrices = (turned * steer).as_matrix().reshape(4, 9)
    return np.column_stack([centres, matrices, velocities, rates, height, normal, friction])


def accelerations(
    inputs: FloatArray, wrench: FloatArray, drive: FloatArray, turned: Rotation, w: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the accelerations of the body by the wrenches `WRENCH` of the tires, shape (4, 6), and its engine."""
    forces, (Mx, Mz, braked) = wrench[:, :3], wrench[:, 3:].T
    torques = np.column_stack([Mx, -braked - drive, Mz])
    moments = np.einsum("nij,nj->ni", inputs[:, 3:12].reshape(4, 3, 3), torques)
    moment = (np.cross(turned.apply(CORNERS), forces) + moments).sum(axis=0)
    inertia = turned.as_matrix() @ np.diag(INERTIA) @ turned.as_matrix().T
    return forces.sum(axis=0) / MASS + GRAVITY, np.linalg.solve(inertia, moment - np.cross(w, inertia @ w))


def start(manoeuvre: Manoeuvre) -> tuple[FloatArray, Rotation, FloatArray, FloatArray]:
    """Return position, orientation, velocity and angular velocity: the kart rests on its tires with its weight."""
    normal = manoeuvre.road(np.zeros(1), np.zeros(1))[1][0]
    slope = np.arctan2(-normal[0], normal[2])
    sunk = MASS * -GRAVITY[2] * np.cos(slope) / 4.0 / STIFFNESS
    turned = Rotation.from_euler("y", -slope)
    up, ahead = turned.apply([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    return (RADIUS - sunk) * up, turned, manoeuvre.speed * ahead, np.zeros(3)
