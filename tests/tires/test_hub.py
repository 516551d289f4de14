"""Wheel kinematics: laws that hold for every motion of the carrier."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tirefmu.boundary.errors import UnknownName
from tirefmu.tires.hub import hub_wrench, wheel_motion

RANDOM = np.random.default_rng(11)
N = 50
AXES = "xyz"
FORCES = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


def vector(name, values):
    return {f"{name}{axis}": values[..., i] for i, axis in enumerate(AXES)}


def rotation(matrix):
    return {f"R_{i + 1}{j + 1}": matrix[..., i, j] for i in range(3) for j in range(3)}


def read(values, name):
    return np.stack([values[f"{name}{axis}"] for axis in AXES], axis=-1)


@pytest.fixture
def poses():
    """Return random motions: orientation, position, velocities, normal and velocity of the road, spin."""
    return {
        "R": Rotation.from_euler("ZXY", RANDOM.uniform(-1, 1, (N, 3)) * [3.0, 0.4, 2.0]).as_matrix(),
        "r": RANDOM.normal(size=(N, 3)) * [5.0, 5.0, 0.02] + [0.0, 0.0, 0.4],
        "v": RANDOM.normal(size=(N, 3)) * 5.0,
        "w": RANDOM.normal(size=(N, 3)),
        "n": RANDOM.normal(size=(N, 3)) * 0.1 + [0.0, 0.0, 1.3],
        "belt": RANDOM.normal(size=(N, 3)),
        "omega": RANDOM.normal(size=N) * 30.0,
    }


def given(poses):
    return {
        **vector("r_", poses["r"]), **rotation(poses["R"]), **vector("v_", poses["v"]), **vector("w_", poses["w"]),
        **vector("road_n", poses["n"]), **vector("road_v", poses["belt"]), "omega": poses["omega"], "road_z": 0.05,
    }  # fmt: skip


def contact_axes(poses):
    """Return the W axes and the direction from the contact point to the wheel centre, by another route."""
    n = poses["n"] / np.linalg.norm(poses["n"], axis=1, keepdims=True)
    s = poses["R"][:, :, 1]
    x = np.cross(s, n)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return x, np.cross(n, x), n, np.cross(x, s)


def test_the_contact_point_is_on_the_road_and_in_the_wheel_plane(poses):
    motion = wheel_motion(**given(poses))
    x, _, n, up = contact_axes(poses)
    c, r = read(motion, "c_"), poses["r"]
    below = r - np.stack([0 * r[:, 0], 0 * r[:, 0], r[:, 2] - 0.05], axis=1)
    for normal, point in ((n, below), (poses["R"][:, :, 1], r), (x, r)):
        assert np.abs(np.einsum("ij,ij->i", normal, c - point)).max() < 1e-12
    assert np.allclose(np.einsum("ij,ij->i", up, r - c), motion["R_l"], atol=1e-13)


def test_velocities_are_the_rate_of_the_contact_point(poses):
    """The carrier moves on, the road plane with its own velocity; the differences are central."""
    h, motion = 1e-5, wheel_motion(**given(poses))
    n = poses["n"] / np.linalg.norm(poses["n"], axis=1, keepdims=True)

    def at(t):
        turned = Rotation.from_rotvec(t * poses["w"]).as_matrix() @ poses["R"]
        r = poses["r"] + t * poses["v"]
        # The plane through (r, 0.05) at t = 0, moved by the velocity of the road.
        foot = poses["r"] * [1.0, 1.0, 0.0] + [0.0, 0.0, 0.05] + t * poses["belt"]
        height = foot[:, 2] - ((r - foot)[:, :2] * n[:, :2]).sum(axis=1) / n[:, 2]
        return wheel_motion(**{**given(poses), **vector("r_", r), **rotation(turned), "road_z": height})

    after, before = at(h), at(-h)
    moved = (read(after, "c_") - read(before, "c_")) / (2 * h) - poses["belt"]
    x, y, n, _ = contact_axes(poses)
    for axis, name in ((x, "V_x"), (y, "V_y")):
        assert np.allclose((axis * moved).sum(axis=1), motion[name], atol=1e-7)
    assert np.abs((n * moved).sum(axis=1)).max() < 1e-7
    assert np.allclose((after["R_l"] - before["R_l"]) / (2 * h), motion["R_l_rate"], atol=1e-7)


def test_power_at_the_hub_is_power_at_the_contact(poses):
    """The hub moves and turns with the wheel; the contact slides, deflects and turns relative to the wheel."""
    poses["belt"] *= 0.0
    motion = wheel_motion(**given(poses))
    contact = {name: RANDOM.normal(size=N) * 1000.0 for name in FORCES}
    wrench = hub_wrench(**contact, R_l=motion["R_l"], **rotation(poses["R"]), **vector("road_n", poses["n"]))
    force, moment = read(wrench, "F_"), read(wrench, "M_")
    into = np.swapaxes(poses["R"], 1, 2)
    v, w = (np.einsum("nij,nj->ni", into, poses[name]) for name in ("v", "w"))
    w[:, 1] += poses["omega"]
    at_hub = (force * v).sum(axis=1) + (moment * w).sum(axis=1)

    gamma, turning = motion["gamma"], motion["wheel_speed"]
    x, _, _, _ = contact_axes(poses)
    tilting = (x * poses["w"]).sum(axis=1)
    at_contact = (
        contact["Fx"] * (motion["V_x"] - motion["R_l"] * turning)
        + contact["Fy"] * motion["V_y"]
        + (contact["Fz"] * np.cos(gamma) - contact["Fy"] * np.sin(gamma)) * motion["R_l_rate"]
        + contact["Mx"] * tilting
        + contact["My"] * turning * np.cos(gamma)
        + contact["Mz"] * (motion["psi_dot"] + turning * np.sin(gamma))
    )
    assert np.allclose(at_hub, at_contact, rtol=1e-10, atol=1e-7)
    turned = np.einsum("nij,nj->ni", poses["R"], force)
    assert np.allclose(turned, np.stack([wrench[f"F_{a}_global"] for a in AXES], axis=1), atol=1e-9)


def test_a_rotation_about_the_vertical_changes_nothing_at_the_contact(poses):
    turn = Rotation.from_euler("z", 1.1).as_matrix()
    turned = {name: poses[name] @ turn.T for name in ("r", "v", "w", "n", "belt")}
    turned |= {"R": turn @ poses["R"], "omega": poses["omega"]}
    first, second = wheel_motion(**given(poses)), wheel_motion(**given(turned))
    for name in ("V_x", "V_y", "wheel_speed", "psi_dot", "gamma", "R_l", "R_l_rate"):
        assert np.allclose(first[name], second[name], atol=1e-10), name
    assert np.allclose(read(first, "c_") @ turn.T, read(second, "c_"), atol=1e-12)


def test_the_mirrored_wheel_moves_as_in_a_mirror(poses):
    """Mirrored at the x-z plane: vectors change y, axial ones x and z; the carrier remains right-handed."""
    flip, axial = np.diag([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
    mirrored = {name: poses[name] @ flip for name in ("r", "v", "n", "belt")}
    mirrored |= {"R": flip @ poses["R"] @ flip, "w": poses["w"] * axial, "omega": poses["omega"]}
    first, second = wheel_motion(**given(poses)), wheel_motion(**given(mirrored))
    for name in ("V_x", "wheel_speed", "R_l", "R_l_rate"):
        assert np.allclose(first[name], second[name], atol=1e-12), name
    for name in ("V_y", "psi_dot", "gamma"):
        assert np.allclose(first[name], -second[name], atol=1e-12), name


def test_an_unknown_name_is_refused():
    with pytest.raises(UnknownName, match="road_nx"):
        wheel_motion(roadnx=1.0)
