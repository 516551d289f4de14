"""Recordings with a hidden effect: other tires, strengths, programs and noise at every seed.

The truth is evaluated at warped inputs (a temperature that saturates, a wear that slows down), so that an effect's
form is never quite the library's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from tirefmu.symbolic.added import library
from tirefmu.tires.tire import Tire

USUAL = ("load_friction", "load_stiffness", "combined_Gyk", "combined_Gxa")

#: Coefficients that switch each effect on, adapted SAE; sizes as in nature, times the case's strength.
SIZES: Mapping[str, Mapping[str, float]] = {
    "load_friction": {"PDY2": -0.15, "PDX2": -0.12},
    "load_stiffness": {"PKY2": 1.8},
    "load_curvature": {"PEY2": -0.6, "PEX2": 0.5},
    "camber_thrust": {"PKY6": 1.0, "PVY3": 0.2},
    "camber_stiffness": {"PKY3": 1.2},
    "camber_friction": {"PDY3": 7.0, "PDX3": 6.0},
    "pressure_stiffness": {"PPY1": 0.5, "PPX1": -0.4},
    "pressure_friction": {"PPY3": -0.15, "PPX3": -0.12},
    "combined_Gxa": {"RBX1": 12.0, "RBX2": 9.0, "RCX1": 1.1},
    "combined_Gyk": {"RBY1": 11.0, "RBY2": 9.0, "RCY1": 1.05},
    "kappa_sideforce_SVyk": {"RVY1": 0.04, "RVY4": 10.0, "RVY5": 1.9, "RVY6": 12.0},
    "relax_lat": {"SIGY": 0.4},
    "relax_lon": {"SIGX": 0.15},
    "relax_load": {"SIGY": 0.35, "SIGC": 0.5},
    "plysteer": {"PHY1": 0.003},
    "conicity": {"PVY1": 0.02},
    "curvature_asym": {"PEY3": 0.25, "PEX4": 0.2},
    "temp_friction": {"TMU1": 0.003, "TMU2": -0.00012},
    "temp_stiffness": {"TK1": -0.004},
    "speed_friction": {"VMU1": -0.08},
    "wear_drift": {"WMU1": -5e-5, "WK1": 3e-5},
    "residual_torque_Mzr": {"QDZ6": 0.006, "QDZ7": 0.003},
    "trail_load": {"QDZ2": -0.02, "QBZ2": -2.0},
    "Mz_from_Fx": {"SSZ1": 0.015, "SSZ2": 0.02},
}
#: Coefficients that a strength multiplies as it is; of the others only the effect's size is meant.
UNSCALED = {"PKY2", "RBX1", "RBX2", "RCX1", "RBY1", "RBY2", "RCY1", "RVY4", "RVY5", "RVY6", "SIGC"}
EITHER_SIGN = ("plysteer", "conicity", "curvature_asym", "temp_stiffness")


@dataclass(frozen=True)
class Case:
    """A recording and what is hidden in it."""

    name: str
    hidden: tuple[str, ...]
    effects: tuple[str, ...]
    nominal: Mapping[str, float]
    table: pd.DataFrame
    truth: pd.DataFrame
    test: pd.DataFrame
    signs: str = "adapted-sae"


def make_case(
    seed: int, hidden: tuple[str, ...] = (), *, strength: float = 1.0, noise: float = 1.0, extra: tuple[str, ...] = (),
    trouble: tuple[str, ...] = (), unknown: str = "", rate: float = 50.0, sweeps: int = 30,
    without: tuple[str, ...] = (),
) -> Case:  # fmt: skip
    """Make a recording.

    Parameters
    ----------
    seed : int
    hidden : tuple of str
        Effects that the start model lacks.
    strength, noise : float
        1: as in nature, as on a bench.
    extra : tuple of str
        Effects that tire and start model have beside the usual ones.
    trouble : tuple of str
        Of the recording: ripple, outliers, cross_talk, drift.
    unknown : str
        Structure that no library knows: "power" or "hysteresis".
    rate : float, Hz
    sweeps : int
    without : tuple of str
        Columns that were not recorded.
    """
    rng = np.random.default_rng(seed)
    base = tuple(dict.fromkeys(name for name in (*USUAL, *extra) if name not in hidden))
    tire = _tire(rng, (*base, *hidden), strength)
    nominal = {"Fz0": tire.values["FNOMIN"], "R0": tire.values["UNLOADED_RADIUS"], "p0": 220e3, "V0": 16.7}
    imposed, other = (
        _program(np.random.default_rng([seed, part]), tire, rate, n) for part, n in ((1, sweeps), (2, 10))
    )
    truth, test = (_answer(tire, table, unknown) for table in (imposed, other))
    recorded = _recorded(rng, truth, noise, trouble)
    what = "+".join((*hidden, unknown)).strip("+") or "nothing"
    name = f"{seed} {what} x{strength:g} noise {noise:g} {' '.join(trouble)}"
    drop = list(without)
    return Case(name, hidden, base, nominal, recorded.drop(columns=drop), truth, test)


def _tire(rng: np.random.Generator, effects: tuple[str, ...], strength: float) -> Tire:
    def about(value: float, spread: float = 0.12) -> float:
        return float(value * (1.0 + spread * rng.uniform(-1.0, 1.0)))

    values = {
        "FNOMIN": float(rng.choice([1100.0, 3000.0, 4000.0, 5500.0])), "UNLOADED_RADIUS": about(0.3),
        "NOMPRES": 220e3, "INFLPRES": 220e3, "LONGVL": 16.7,
        "PCX1": about(1.6, 0.08), "PDX1": about(1.2), "PEX1": about(-0.2, 2.0), "PKX1": about(22.0, 0.25),
        "PCY1": about(1.4, 0.08), "PDY1": about(1.1), "PEY1": about(-0.5, 0.8), "PKY1": about(21.0, 0.25),
        "QBZ1": about(8.0, 0.2), "QCZ1": about(1.12, 0.05), "QDZ1": about(0.11, 0.2),
    }  # fmt: skip
    for effect in effects:
        for name, size in SIZES[effect].items():
            own = 1.0 if name in UNSCALED or effect in USUAL else strength
            sign = (
                rng.choice([-1.0, 1.0])
                if effect in ("plysteer", "conicity", "curvature_asym", "temp_stiffness")
                else 1.0
            )
            values[name] = about(size, 0.15) * own * sign
    if "load_stiffness" not in effects:
        values["PKY1"] *= 0.75
    return Tire("mf61", values, effects=effects, signs="adapted-sae", added=tuple(library().values()))


def _program(rng: np.random.Generator, tire: Tire, rate: float, sweeps: int) -> pd.DataFrame:
    """Return inputs: sweeps of either slip at steps of load, camber, pressure and speed, some of everything."""
    load, reach = tire.values["FNOMIN"], rng.uniform(0.15, 0.2)
    parts = []
    rows = int(3.0 * rate)
    wave = 2.0 * np.abs(2.0 * ((np.arange(rows) / rows + 0.25) % 1.0) - 1.0) - 1.0
    for _ in range(sweeps):
        kind = rng.choice(["alpha", "kappa", "both", "mixed"], p=[0.45, 0.3, 0.15, 0.1])
        part = dict.fromkeys(("kappa", "alpha", "gamma"), np.zeros(rows))
        if kind == "alpha":
            part["alpha"] = reach * wave
        elif kind == "mixed":
            for name, size in (("kappa", 0.06), ("alpha", 0.08), ("gamma", 0.05)):
                raw = gaussian_filter1d(rng.standard_normal(rows + 200), 0.3 * rate)[100:-100]
                part[name] = size * raw / (np.std(raw) + 1e-9) * 0.7
        else:
            part["kappa"] = 0.15 * wave
            part["alpha"] = np.full(rows, rng.choice([-0.09, -0.045, 0.045, 0.09]) if kind == "both" else 0.0)
        if kind != "mixed":
            part["gamma"] = np.full(rows, rng.choice([0.0, 0.07, -0.07, 0.035], p=[0.6, 0.17, 0.15, 0.08]))
        part["Fz"] = np.full(rows, load * rng.choice([0.45, 0.65, 0.75, 1.0, 1.25, 1.5]))
        part["p"] = np.full(rows, rng.choice([220e3, 180e3, 265e3], p=[0.6, 0.2, 0.2]))
        part["V"] = np.full(rows, rng.choice([16.7, 9.0, 28.0], p=[0.65, 0.18, 0.17]))
        parts.append(pd.DataFrame(part))
    table = pd.concat(parts, ignore_index=True)
    for name, seconds in (("gamma", 0.1), ("Fz", 0.1), ("p", 0.5), ("V", 0.5)):
        table[name] = _slow(table[name].to_numpy(), seconds * rate)
    table["alpha"], table["kappa"] = (_slow(table[name].to_numpy(), 0.02 * rate) for name in ("alpha", "kappa"))
    slide = np.abs(table["alpha"]) + np.abs(table["kappa"])
    heat = _slow((slide * table["V"] * table["Fz"] / load).to_numpy(), 15.0 * rate)
    table["T"] = 45.0 + 25.0 * heat / heat.max() + 12.0 * np.sin(np.linspace(0.0, rng.uniform(4.0, 9.0), len(table)))
    table.insert(0, "t", np.arange(len(table)) / rate)
    return table


def _slow(values: np.ndarray, rows: float) -> np.ndarray:
    kept = float(np.exp(-1.0 / max(rows, 1e-3)))
    return np.asarray(lfilter([1.0 - kept], [1.0, -kept], values, zi=[kept * values[0]])[0])


def _answer(tire: Tire, table: pd.DataFrame, unknown: str) -> pd.DataFrame:
    """Return inputs and true forces; effects act by warped inputs."""
    warped = table.copy()
    warped["T"] = 50.0 + 40.0 * np.tanh((table["T"] - 50.0) / 40.0)
    distance = np.concatenate([[0.0], np.cumsum(np.diff(table["t"]) * table["V"].to_numpy()[1:])])
    warped["distance"] = 3000.0 * (1.0 - np.exp(-distance / 3000.0))
    forces = tire.evaluate(warped, signs="adapted-sae", code="c")[["Fx", "Fy", "Mz"]]
    if unknown == "power":
        power = np.abs(np.tan(table["alpha"])) * table["V"] * table["Fz"] / 16.7 / tire.values["FNOMIN"]
        share = 1.0 - 0.35 * power * (table["T"] - 60.0) / 20.0
        forces = forces.mul(share, axis=0)
    if unknown == "hysteresis":
        turning = np.gradient(table["alpha"], table["t"])
        memory = _slow(np.tanh(turning / 0.05), 15.0)
        forces["Fy"] += 0.05 * table["Fz"] * memory
    return pd.concat([table, forces], axis=1)


def _recorded(rng: np.random.Generator, truth: pd.DataFrame, noise: float, trouble: tuple[str, ...]) -> pd.DataFrame:
    """Return what the bench records of the truth."""
    n = len(truth)

    def random(memory: float) -> np.ndarray:
        return np.asarray(lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], rng.standard_normal(n)))

    recorded = truth.copy()
    t = truth["t"].to_numpy()
    for name in ("Fx", "Fy", "Mz"):
        true = truth[name].to_numpy()
        size = float(np.abs(true).max())
        drift = gaussian_filter1d(rng.standard_normal(n + 4000), 800)[2000:-2000]
        drift *= (0.004 if "drift" in trouble else 0.001) * size / (np.std(drift) + 1e-12)
        deviation = noise * np.hypot(0.004 * size, 0.01 * true)
        recorded[name] = true + deviation * random(0.5) + 0.002 * size * rng.standard_normal() + drift
        if "ripple" in trouble:
            angle = np.cumsum(truth["V"].to_numpy()) * (t[1] - t[0]) / 0.29
            recorded[name] += 0.005 * size * np.sin(angle + rng.uniform(0.0, 6.0))
        if "outliers" in trouble:
            recorded.loc[rng.choice(n, 12, replace=False), name] += 0.3 * size * rng.choice([-1.0, 1.0], 12)
        step = size / 2500.0
        recorded[name] = np.round(recorded[name] / step) * step
    if "cross_talk" in trouble:
        recorded["Fx"] += 0.003 * truth["Fy"]
        recorded["Fy"] -= 0.003 * truth["Fx"]
    sizes = {
        "kappa": 4e-4,
        "alpha": 2e-4,
        "gamma": 5e-5,
        "Fz": 0.0025 * truth["Fz"].mean(),
        "p": 300.0,
        "V": 0.02,
        "T": 0.4,
    }
    for name, size in sizes.items():
        recorded[name] = truth[name] + noise * size * random(0.2)
    return recorded
