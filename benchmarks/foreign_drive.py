"""A drive of a third-party multi-body car: the lateral tire curve of `tirefmu drive` compared with the car's.

    python benchmarks/foreign_drive.py

The car is the BMW 320i of commonroad-vehicle-models (extra foreign-car): 29 states with suspension
and compliance, its own tires. Peak friction of the given tire file is 25 % too high, its cornering stiffness
20 % too low.
"""

from __future__ import annotations

import sys

import numpy as np
import pandas as pd
from vehiclemodels.init_mb import init_mb
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
from vehiclemodels.utils.tire_model import formula_lateral
from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb

import tirefmu
from tirefmu import Tire
from tirefmu.applications.driving.inputs.car import Car
from tirefmu.applications.driving.interval import OUTPUTS

STEP, SECONDS, SPEED = 0.001, 30.0, 17.0
#: Peak friction and cornering stiffness of the file relative to those of the car.
FRICTION, STIFFNESS = 1.25, 0.8


def wanted_steer(t: float) -> float:
    """Return the steering angle of the front wheels: turns of growing size, up to the limit."""
    return (0.02 + 0.0022 * t) * float(np.tanh(3.0 * np.sin(2.0 * np.pi * t / 5.0)))


def recorded() -> pd.DataFrame:
    """Return the log of a drive: 100 Hz, noise of a consumer IMU."""
    p = parameters_vehicle2()
    state = np.array(init_mb([0.0, 0.0, 0.0, SPEED, 0.0, 0.0, 0.0], p), dtype=np.float64)
    rows = []
    for i in range(round(SECONDS / STEP)):
        t = i * STEP
        inputs = [(wanted_steer(t) - state[2]) / 0.01, 2.0 * (SPEED - state[3])]
        k1 = np.array(vehicle_dynamics_mb(list(state), inputs, p))
        k2 = np.array(vehicle_dynamics_mb(list(state + STEP * k1), inputs, p))
        if i % 10 == 0:
            rows.append([t, state[2], state[3], state[5], k1[3] - state[10] * state[5], k1[10] + state[3] * state[5],
                         *state[23:27]])  # fmt: skip
        state = state + STEP / 2 * (k1 + k2)
    names = ["t", "steer", "speed", "yaw_rate", "ax", "ay", *(f"omega_{corner}" for corner in ("fl", "fr", "rl", "rr"))]
    log = pd.DataFrame(rows, columns=names)
    noise = {"steer": 1e-4, "speed": 0.05, "yaw_rate": 0.005, "ax": 0.1, "ay": 0.1}
    rng = np.random.default_rng(0)
    return log.assign(**{name: log[name] + size * rng.standard_normal(len(log)) for name, size in noise.items()})


def given_car() -> Car:
    """Return the car as its parameters describe it."""
    p = parameters_vehicle2()
    roll = (p.K_sf * p.T_f**2 / 2 - p.K_tsf, p.K_sr * p.T_r**2 / 2 - p.K_tsr)
    body = {
        "mass": p.m, "wheelbase": p.a + p.b, "cg_to_front": p.a, "cg_height": p.h_cg, "track_front": p.T_f,
        "track_rear": p.T_r, "yaw_inertia": p.I_z, "front_roll_share": roll[0] / sum(roll),
    }  # fmt: skip
    wheels = {"radius_front": p.R_w, "radius_rear": p.R_w, "brake_front": p.T_sb}
    return Car.from_content({"body": body, "wheels": wheels}, "BMW 320i")


def given_tire() -> Tire:
    """Return the tire of the file."""
    q = parameters_vehicle2().tire
    values = {
        "FNOMIN": 2700.0, "UNLOADED_RADIUS": 0.344, "PCX1": q.p_cx1, "PDX1": q.p_dx1, "PEX1": q.p_ex1, "PKX1": q.p_kx1,
        "PCY1": q.p_cy1, "PDY1": FRICTION * q.p_dy1, "PEY1": q.p_ey1, "PKY1": STIFFNESS * q.p_ky1,
        "RBY1": q.r_by1, "RBY2": q.r_by2, "RBY3": q.r_by3, "RCY1": q.r_cy1, "REY1": q.r_ey1,
    }  # fmt: skip
    return Tire("mf61", values, effects=("combined_Gyk",))


def main() -> int:
    """Print the error of the curve of each axle over the slip that was reached; return 0 if it is below 5 %."""
    answer = tirefmu.drive(recorded(), vehicle=given_car(), tire=given_tire())
    print(answer)
    worst = 0.0
    for axle in ("front", "rear"):
        alpha, Fz = (answer.estimate.outputs.values[:, OUTPUTS.index(f"{name}_{axle}")] for name in ("alpha", "Fz"))
        slips, load = np.linspace(*np.quantile(alpha, [0.01, 0.99]), 101), float(np.median(Fz))
        true = np.array([formula_lateral(slip, 0.0, load, parameters_vehicle2().tire)[0] for slip in slips])
        estimated = answer.scaled[axle].forces(alpha=slips, Fz=load)["Fy"]
        error = float(np.abs(estimated - true).max() / np.abs(true).max())
        worst = max(worst, error)
        print(f"{axle}: slip to {np.degrees(np.abs(slips).max()):.1f} deg, error of the curve {100 * error:.1f} %")
    return 0 if worst < 0.05 else 1


if __name__ == "__main__":
    sys.exit(main())
