"""A car on a road in plain NumPy: an independent program whose drives have a known truth.

Four wheels that spin, a body that moves in the plane, loads that lag, angles of compliance, Magic Formula tires written
out here with similarity for combined slip. None of the equations of tirefmu is used. Several drives run side by side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

G = 9.80665
#: Coefficients by .tir name; the tire of the file is without factors.
TIRE = {
    "FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.31, "PCX1": 1.6, "PDX1": 1.1, "PEX1": -0.2, "PKX1": 22.0,
    "PCY1": 1.35, "PDY1": 1.0, "PDY2": -0.12, "PEY1": -0.6, "PKY1": -22.0, "PKY2": 1.8,
}  # fmt: skip
CAR = {
    "mass": 1250.0, "wheelbase": 2.5, "cg_to_front": 1.2, "cg_height": 0.52, "track_front": 1.5, "track_rear": 1.48,
    "yaw_inertia": 1700.0, "front_roll_share": 0.56, "ratio": 15.0, "offset": 0.0, "radius_front": 0.3,
    "radius_rear": 0.3, "x": 0.15, "y": -0.1, "roll_lag": 0.05, "steer_front": 0.0, "steer_rear": 0.0,
    "ay_gain": 1.0, "yaw_rate_gain": 1.0, "misalignment": 0.0, "wheel_delay": 0.0, "lift": 0.0, "heave_period": 0.7,
    "downforce_front": 0.0, "downforce_rear": 0.0,
}  # fmt: skip
#: Standard deviations of a workshop's numbers, and what cars and sensors differ by.
SPREAD = {
    "mass": 37.5, "wheelbase": 0.005, "cg_to_front": 0.036, "cg_height": 0.052, "track_front": 0.0075,
    "track_rear": 0.0074, "yaw_inertia": 170.0, "front_roll_share": 0.1, "ratio": 0.15, "offset": 0.005,
    "radius_front": 0.0015, "radius_rear": 0.0015, "x": 0.05, "y": 0.05, "roll_lag": 0.012, "steer_front": 1e-4,
    "steer_rear": 1e-4, "ay_gain": 0.004, "yaw_rate_gain": 0.003, "misalignment": 0.01, "wheel_delay": 0.01,
    "lift": 1e-4, "heave_period": 0.1,
}  # fmt: skip
WHEEL_INERTIA, STEP = 1.0, 0.002
KINDS = ("slalom", "sweep", "step", "laps", "brake")


@dataclass(frozen=True)
class Truth:
    """What is true in a drive: factors by axle, numbers of the car that differ, delay of the steering log, s."""

    factors: dict[str, dict[str, float]]
    car: dict[str, float]
    steer_log_delay: float = 0.0
    effect: str = ""


def magic(slip, C, D, K, E):
    """Return the Magic Formula of a slip from shape, peak, slope and curvature."""
    x = K / (C * D) * slip
    return D * np.sin(C * np.arctan(x - E * (x - np.arctan(x))))


def tire_forces(kappa, alpha, Fz, V, factors):
    """Return Fx and Fy in W axes at any speed; combined slip as in MF6.1 with r_Bx1 = r_By1 = 8, r_Cx1 = r_Cy1 = 1."""
    load = np.maximum(Fz, 1.0)
    dfz = load / TIRE["FNOMIN"] - 1.0
    Dx = TIRE["PDX1"] * load * factors["LMUX"]
    Dy = (TIRE["PDY1"] + TIRE["PDY2"] * dfz) * load * factors["LMUY"]
    Kx = TIRE["PKX1"] * load * factors["LKX"]
    Ky = (
        TIRE["PKY1"] * TIRE["FNOMIN"] * np.sin(2.0 * np.arctan(load / (TIRE["PKY2"] * TIRE["FNOMIN"]))) * factors["LKY"]
    )
    Fx = magic(kappa, TIRE["PCX1"], Dx, Kx, TIRE["PEX1"])
    Fy = magic(np.tan(alpha), TIRE["PCY1"], Dy, Ky, TIRE["PEY1"])
    weight_x = np.cos(np.arctan(8.0 * np.tan(alpha)))
    weight_y = np.cos(np.arctan(8.0 * kappa))
    return Fx * weight_x, Fy * weight_y


def demands(kind, t, rng, hard):
    """Return the steering wheel angle (rad) and the wanted speed (m/s) over time of one drive."""
    a = rng.uniform(0.85, 1.15)
    if kind == "slalom":
        return (0.9 if hard else 0.35) * a * np.sin(2 * np.pi * 0.45 * a * t), 16.0 + 2.0 * np.sin(0.2 * t)
    if kind == "sweep":
        return (1.0 if hard else 0.4) * a * np.sin(2 * np.pi * (0.15 * t + 0.011 * t**2)), 17.0 + 0.0 * t
    if kind == "step":
        level = np.array([0.0, 1.0, 0.0, -1.0, 0.0, 1.4, 0.0, -1.4])[(t / 3.5).astype(int) % 8]
        smooth = np.convolve(np.pad(level, 150, mode="edge"), np.ones(301) / 301, mode="valid")
        return (1.1 if hard else 0.4) * a * smooth, 17.0 + 1.5 * np.sin(0.11 * t)
    if kind == "laps":
        turn = np.tanh(4.0 * np.sin(2 * np.pi * t / 15.0)) + 0.5 * np.sin(2 * np.pi * t / 6.1)
        return (1.1 if hard else 0.3) * a * turn, 14.0 + 3.0 * np.cos(4 * np.pi * t / 15.0)
    turn = np.sin(2 * np.pi * t / 12.0)
    fall = np.clip((t % 6.0) - 3.5, 0.0, 1.5)
    return (1.1 if hard else 0.35) * a * np.tanh(3.0 * turn), 19.0 - 3.0 * fall


class Road:
    """Simulate drives side by side. `steer`, `speed`, shape (n_steps, n): demands; `truths`: of each drive."""

    def __init__(self, truths, tire=tire_forces):
        self.tire, self.lifted = tire, 0.0
        self.car = c = {key: np.array([{**CAR, **truth.car}[key] for truth in truths]) for key in CAR}
        lf, lr = c["cg_to_front"], c["wheelbase"] - c["cg_to_front"]
        self.X = np.stack([lf, lf, -lr, -lr])
        self.Y = np.stack([c["track_front"], -c["track_front"], c["track_rear"], -c["track_rear"]]) / 2
        self.R = np.stack([c["radius_front"]] * 2 + [c["radius_rear"]] * 2)
        self.factors = {
            name: np.stack(
                [np.array([truth.factors[axle][name] for truth in truths]) for axle in ("front",) * 2 + ("rear",) * 2]
            )
            for name in ("LMUX", "LMUY", "LKX", "LKY")
        }

    def rates(self, state, wheel, torque):
        """Return the rates of vx, vy, r and four spins, and the accelerations."""
        c, X, Y, R = self.car, self.X, self.Y, self.R
        vx, vy, r, spins = state[0], state[1], state[2], state[3:7]
        front, rear = wheel - c["steer_front"] * self.rolled[1], c["steer_rear"] * self.rolled[1]
        angle = np.array([front, front, rear, rear])
        u, w = vx - r * Y, vy + r * X
        cos, sin = np.cos(angle), np.sin(angle)
        along, side = u * cos + w * sin, w * cos - u * sin
        alpha, kappa = np.arctan(side / along), (spins * R - along) / along
        shift = c["mass"] * self.rolled[0] * c["cg_height"] / c["wheelbase"] / 2
        share = c["front_roll_share"]
        roll_f = c["mass"] * self.rolled[1] * c["cg_height"] * share / c["track_front"]
        roll_r = c["mass"] * self.rolled[1] * c["cg_height"] * (1 - share) / c["track_rear"]
        weight = c["mass"] * (G + self.lifted)
        front = (c["downforce_front"] * vx**2 - weight * X[2] / c["wheelbase"]) / 2
        rear = (c["downforce_rear"] * vx**2 + weight * X[0] / c["wheelbase"]) / 2
        Fz = np.array([front - shift - roll_f, front - shift + roll_f, rear + shift - roll_r, rear + shift + roll_r])
        Fx, Fy = self.tire(kappa, alpha, Fz, along, self.factors)
        bx, by = Fx * cos - Fy * sin, Fx * sin + Fy * cos
        ax, ay = bx.sum(0) / c["mass"], by.sum(0) / c["mass"]
        turning = (X * by - Y * bx).sum(0) / c["yaw_inertia"]
        return np.array([ax + r * vy, ay - r * vx, turning, *((torque - Fx * R) / WHEEL_INERTIA)]), (ax, ay), turning

    def run(self, steer, speed):
        """Return the motion at every step: dict of arrays, shape (n_steps, n)."""
        n_steps, n = steer.shape
        state = np.zeros((7, n))
        state[0] = speed[0]
        state[3:] = speed[0] / 0.3
        self.rolled, height = np.zeros((2, n)), np.zeros((2, n))
        pace = 2.0 * np.pi / self.car["heave_period"]
        rows = {
            name: np.empty((n_steps, n))
            for name in ("vx", "vy", "yaw_rate", "ax", "ay", "turning", "fl", "fr", "rl", "rr")
        }
        for i in range(n_steps):
            wheel, later = (steer[min(i + k, n_steps - 1)] / self.car["ratio"] + self.car["offset"] for k in (0, 1))
            middle = (wheel + later) / 2
            force = np.clip(
                2.0 * self.car["mass"] * (speed[i] - state[0]), -0.35 * G * self.car["mass"], 0.3 * G * self.car["mass"]
            )
            share = np.where(force < 0.0, 0.72, 0.0)
            torque = np.array([force * share / 2] * 2 + [force * (1 - share) / 2] * 2) * 0.3
            k1, last, turning = self.rates(state, wheel, torque)
            if hasattr(self.tire, "advance"):
                self.tire.advance(STEP)
            for name, values in zip(rows, (*state[:3], *last, turning, *state[3:]), strict=True):
                rows[name][i] = values
            k2, *_ = self.rates(state + STEP / 2 * k1, middle, torque)
            k3, *_ = self.rates(state + STEP / 2 * k2, middle, torque)
            k4, *_ = self.rates(state + STEP * k3, later, torque)
            state = state + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            self.rolled = last + (self.rolled - last) * np.exp(-STEP / self.car["roll_lag"])
            self.lifted = pace**2 * (self.car["lift"] * self.rolled[1] ** 2 - height[0]) - 0.6 * pace * height[1]
            height[1] += STEP * self.lifted
            height[0] += STEP * height[1]
        return rows


def logs(rows, steer, truths, rng):
    """Return the logs at 100 Hz with the noise of a consumer IMU, offsets, lever arm and delays."""
    every = round(0.01 / STEP)
    t = STEP * np.arange(len(steer))
    made = []
    for i, truth in enumerate(truths):
        part, car = {name: values[:, i] for name, values in rows.items()}, {**CAR, **truth.car}
        ax = part["ax"] - part["turning"] * car["y"] - part["yaw_rate"] ** 2 * car["x"]
        ay = part["ay"] + part["turning"] * car["x"] - part["yaw_rate"] ** 2 * car["y"]
        ax, ay = ax + car["misalignment"] * ay, car["ay_gain"] * (ay - car["misalignment"] * ax)
        m = len(t[::every])
        noise = rng.standard_normal((9, m))
        table = {
            "t": t[::every],
            "steer": np.interp(t[::every] - truth.steer_log_delay, t, steer[:, i]) + 2e-3 * noise[0],
            "speed": part["vx"][::every] + 0.05 * noise[1],
            "yaw_rate": car["yaw_rate_gain"] * part["yaw_rate"][::every] + rng.normal(0, 0.005) + 0.005 * noise[2],
            "ax": ax[::every] + rng.normal(0, 0.1) + 0.1 * noise[3],
            "ay": ay[::every] + rng.normal(0, 0.1) + 0.1 * noise[4],
        }
        for row, corner in enumerate(("fl", "fr", "rl", "rr")):
            table[f"omega_{corner}"] = (
                np.interp(t[::every] - car["wheel_delay"], t, part[corner]) + 0.05 * noise[5 + row]
            )
        made.append(pd.DataFrame(table))
    return made


def made_drives(truths, kinds, hard, seed, seconds=60.0, tire=tire_forces):
    """Return the logs of drives and their motion: lists of DataFrame and the rows of `Road.run`."""
    rng = np.random.default_rng(seed)
    t = STEP * np.arange(round(seconds / STEP))
    wanted = [demands(kind, t, rng, each) for kind, each in zip(kinds, hard, strict=True)]
    steer, speed = np.stack([pair[0] for pair in wanted], axis=1), np.stack([pair[1] for pair in wanted], axis=1)
    rows = Road(truths, tire).run(steer, speed)
    return logs(rows, steer, truths, rng), rows


def drawn_truth(rng):
    """Return a truth: factors within -40 to +20 %, errors of the car as large as a workshop's."""
    factors = {
        axle: {
            "LMUX": rng.uniform(0.7, 1.1),
            "LMUY": rng.uniform(0.6, 1.1),
            "LKX": rng.uniform(0.8, 1.2),
            "LKY": rng.uniform(0.75, 1.2),
        }
        for axle in ("front", "rear")
    }
    factors["rear"]["LMUY"] = factors["front"]["LMUY"] * rng.uniform(0.97, 1.1)  # a car that does not spin
    factors["rear"]["LKY"] = factors["front"]["LKY"] * rng.uniform(0.97, 1.15)
    car = {name: CAR[name] + spread * rng.standard_normal() for name, spread in SPREAD.items()}
    car["roll_lag"] = max(car["roll_lag"], 0.02)
    return Truth(factors, car, steer_log_delay=rng.normal(0.0, 0.02))


def used_share(rows, truth, i, axle):
    """Return the largest side force of an axle over its peak at the loads of its wheels, exceeded for half a second."""
    c, ax, ay = {**CAR, **truth.car}, rows["ax"][:, i], rows["ay"][:, i]
    lf, roll = c["cg_to_front"], c["front_roll_share"]
    lr = c["wheelbase"] - lf
    sign, arm, share = (1.0, lr, roll) if axle == "front" else (-1.0, lf, 1.0 - roll)
    force = (arm * c["mass"] * ay + sign * c["yaw_inertia"] * rows["turning"][:, i]) / c["wheelbase"]
    mean = c["mass"] * (G * arm - sign * ax * c["cg_height"]) / c["wheelbase"] / 2
    moved = c["mass"] * ay * c["cg_height"] * share / c[f"track_{axle}"]
    loads = np.maximum([mean - moved, mean + moved], 0.0)
    friction = (TIRE["PDY1"] + TIRE["PDY2"] * (loads / TIRE["FNOMIN"] - 1.0)) * truth.factors[axle]["LMUY"]
    return float(np.sort(np.abs(force) / (friction * loads).sum(axis=0))[-round(0.5 / STEP)])


def car_content():
    """Return the content of the car file that belongs to `CAR`."""
    body = (
        "mass",
        "wheelbase",
        "cg_to_front",
        "cg_height",
        "track_front",
        "track_rear",
        "yaw_inertia",
        "front_roll_share",
    )
    return {
        "body": {name: CAR[name] for name in body},
        "steering": {"ratio": CAR["ratio"]},
        "wheels": {name: CAR[name] for name in ("radius_front", "radius_rear")},
        "sensors": {name: CAR[name] for name in ("x", "y")},
    }


def file_tire():
    """Return the tire of the file, without factors."""
    from tirefmu import Tire

    combined = {"RBX1": 8.0, "RCX1": 1.0, "RBY1": 8.0, "RCY1": 1.0}
    effects = ("load_friction", "load_stiffness", "combined_Gxa", "combined_Gyk")
    return Tire("mf61", {**TIRE, **combined}, effects=effects)
