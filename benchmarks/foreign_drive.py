"""Drives of a third-party multi-body car: names, intervals and lateral curves of `tirefmu drive`, and the car's own.

    python benchmarks/foreign_drive.py [--drives N] [--seed N] [--shifts]

The car is the BMW 320i of commonroad-vehicle-models (extra foreign-car): 29 states with suspension and compliance, its
own tires. Its program gives both shifts of Fy the sign of the camber: the forces jump by 4 % of the load and more with
the sign of the roll, as those of no tire do. The shifts are 0, but for --shifts. In the first drive, peak friction of
the given tire file is 25 % too high, its cornering stiffness 20 % too low. Further drives have another speed and
steering, drawn at random as are the errors of the tire file; one of three has none.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from vehiclemodels.init_mb import init_mb
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
from vehiclemodels.utils.tire_model import formula_lateral
from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb

import tirefmu
from tirefmu import Tire
from tirefmu.applications.driving.inputs.car import Car
from tirefmu.applications.driving.inputs.unknowns import SAME
from tirefmu.applications.driving.interval import OUTPUTS
from tirefmu.applications.driving.result import Drive

STEP, SECONDS = 0.001, 30.0
#: Yaw rate of a car that spins, rad/s: that is no drive.
SPINS = 1.5
AXLES = ("front", "rear")


@dataclass(frozen=True)
class Case:
    """A drive: `speed`, m/s, `period` of the turns, s, relative `size` of the steering, `seed` of the noise.

    `friction`, `stiffness`: peak friction and cornering stiffness of the file relative to those of the car.
    """

    speed: float = 17.0
    period: float = 5.0
    size: float = 1.0
    friction: float = 1.25
    stiffness: float = 0.8
    seed: int = 0

    def steer(self, t: float) -> float:
        """Return the wanted angle of the front wheels: turns of growing size, up to the limit."""
        return self.size * (0.02 + 0.0022 * t) * float(np.tanh(3.0 * np.sin(2.0 * np.pi * t / self.period)))


def cases(n: int, seed: int) -> list[Case]:
    """Return the first drive and drawn ones."""
    rng, drives = np.random.default_rng(seed), [Case()]
    for i in range(1, n):
        friction, stiffness = (1.0, 1.0) if i % 3 == 1 else rng.uniform(0.75, 1.3, 2).tolist()
        speed = rng.uniform(14.0, 19.0)
        size = (drives[0].speed / speed) ** 2 * rng.uniform(0.8, 1.0)
        drives.append(Case(speed, rng.uniform(4.0, 6.0), size, friction, stiffness, i))
    return drives


def without_shifts() -> Any:
    """Return the parameters of the car, shifts of the tires 0."""
    p = parameters_vehicle2()
    for name in ("p_hx1", "p_vx1", "p_hy1", "p_hy3", "p_vy1", "p_vy3"):
        setattr(p.tire, name, 0.0)
    return p


def recorded(case: Case, p: Any) -> pd.DataFrame:
    """Return the log of a drive, which ends where the car spins: 100 Hz, noise of a consumer IMU."""
    state = np.array(init_mb([0.0, 0.0, 0.0, case.speed, 0.0, 0.0, 0.0], p), dtype=np.float64)
    rows = []
    for i in range(round(SECONDS / STEP)):
        t = i * STEP
        inputs = [(case.steer(t) - state[2]) / 0.01, 2.0 * (case.speed - state[3])]
        k1 = np.array(vehicle_dynamics_mb(list(state), inputs, p))
        k2 = np.array(vehicle_dynamics_mb(list(state + STEP * k1), inputs, p))
        if abs(state[5]) > SPINS:
            break
        if i % 10 == 0:
            rows.append([t, state[2], state[3], state[5], k1[3] - state[10] * state[5], k1[10] + state[3] * state[5],
                         *state[23:27]])  # fmt: skip
        state = state + STEP / 2 * (k1 + k2)
    # Its wheels L are the outer ones of a turn to its left: the faster and the loaded ones.
    names = ["t", "steer", "speed", "yaw_rate", "ax", "ay", *(f"omega_{corner}" for corner in ("fr", "fl", "rr", "rl"))]
    log = pd.DataFrame(rows, columns=names)
    noise = {"steer": 1e-4, "speed": 0.05, "yaw_rate": 0.005, "ax": 0.1, "ay": 0.1}
    rng = np.random.default_rng(case.seed)
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


def given_tire(case: Case) -> Tire:
    """Return the tire of the file."""
    q = parameters_vehicle2().tire
    values = {
        "FNOMIN": 2700.0, "UNLOADED_RADIUS": 0.344, "PCX1": q.p_cx1, "PDX1": q.p_dx1, "PEX1": q.p_ex1, "PKX1": q.p_kx1,
        "PCY1": q.p_cy1, "PDY1": case.friction * q.p_dy1, "PEY1": q.p_ey1, "PKY1": case.stiffness * q.p_ky1,
        "RBY1": q.r_by1, "RBY2": q.r_by2, "RBY3": q.r_by3, "RCY1": q.r_cy1, "REY1": q.r_ey1,
    }  # fmt: skip
    return Tire("mf61", values, effects=("combined_Gyk",))


def curve_error(answer: Drive, axle: str) -> float:
    """Return the largest error of the curve of an axle over the slip that was reached, per largest force."""
    alpha, Fz = (answer.estimate.outputs[:, OUTPUTS.index(f"{name}_{axle}")] for name in ("alpha", "Fz"))
    slips, load = np.linspace(*np.quantile(alpha, [0.01, 0.99]), 101), float(np.median(Fz))
    true = np.array([formula_lateral(slip, 0.0, load, parameters_vehicle2().tire)[0] for slip in slips])
    estimated = answer.scaled[axle].forces(alpha=slips, Fz=load)["Fy"]
    return float(np.abs(estimated - true).max() / np.abs(true).max())


def main() -> int:
    """Print the answers and what they name; return 0 if the curves of the first drive are right within 5 %."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", type=int, default=1)
    parser.add_argument("--seed", type=int, default=36)
    parser.add_argument("--shifts", action="store_true", help="tires as in the program of the car")
    options = parser.parse_args()
    p = parameters_vehicle2() if options.shifts else without_shifts()
    counts = dict.fromkeys(
        ("drives", "spun", "to_name", "right_names", "wrong_names", "effects", "determined", "inside"), 0
    )
    worst = []
    for case in cases(options.drives, options.seed):
        log, start = recorded(case, p), time.process_time()
        if log["t"].iloc[-1] < SECONDS - 0.1:
            counts["spun"] += 1
            continue
        answer = tirefmu.drive(log, vehicle=given_car(), tire=given_tire(case))
        errors = [curve_error(answer, axle) for axle in AXLES]
        worst.append(max(errors))
        print(f"{case}: {time.process_time() - start:.0f} CPU s, errors of the curves {errors}\n{answer}", flush=True)
        counts["drives"] += 1
        counts["effects"] += bool(answer.verdict.effect)
        found = {(finding.axle, finding.name) for finding in answer.verdict.tires}
        for axle in AXLES:
            for name, true in (("LMUY", 1.0 / case.friction), ("LKY", 1.0 / case.stiffness)):
                factor, changed = answer.factors[axle][name], abs(true - 1.0) > SAME
                right = (axle, name) in found and changed and (factor.value > 1.0) == (true > 1.0)
                counts["to_name"] += changed
                counts["right_names"] += right
                counts["wrong_names"] += (axle, name) in found and not right
                counts["determined"] += factor.determined
                counts["inside"] += factor.determined and factor.low <= true <= factor.high
    print(json.dumps(counts))
    return 0 if worst[0] < 0.05 else 1


if __name__ == "__main__":
    sys.exit(main())
