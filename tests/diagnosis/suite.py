"""Recordings with a hidden effect: tire, effect size, program and noise depend on the seed.

The true forces are evaluated at transformed inputs (a temperature that saturates, wear that slows down), so that the
functional form of an effect differs from that of the library.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from tirefmu.symbolic.added import library
from tirefmu.tires import Tire, convert_signs

from .case import Case
from .programs import distance_of, operating_range, program, slow

DEFAULT_EFFECTS = ("load_friction", "load_stiffness", "combined_Gyk", "combined_Gxa")

#: Coefficients of each effect, adapted SAE: typical sizes, multiplied by the strength of the case.
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
    "overturning_Mx": {"QSX1": 0.01, "QSX2": 0.6, "QSX3": 0.04},
    "rolling_resistance_My": {"QSY1": 0.012, "QSY2": 0.05},
    "turn_slip": {"PDYP1": 1.0, "PKYP1": 2.0},
}
#: Effects that the true tire has at transformed inputs, so that their coefficients have no true values.
WARPED = ("temp_friction", "temp_stiffness", "wear_drift")
#: Coefficients that the strength does not multiply.
UNSCALED = {"PKY2", "RBX1", "RBX2", "RCX1", "RBY1", "RBY2", "RCY1", "RVY4", "RVY5", "RVY6", "SIGC"}
OUTPUTS = ("Fx", "Fy", "Mz", "Mx", "My")
#: Moments that are recorded only if the tire has the effect.
OF_MOMENT = {"Mx": "overturning_Mx", "My": "rolling_resistance_My"}
EITHER_SIGN = ("plysteer", "conicity", "curvature_asym", "temp_stiffness")


#: Structure that is not in the library, and its variables.
UNKNOWN: Mapping[str, frozenset[str]] = {
    "power": frozenset({"T", "alpha", "V", "Fz"}),
    "hysteresis": frozenset({"dalpha/dt", "memory", "Fz"}),
    "crown": frozenset({"gamma", "p"}),
    "whirl": frozenset({"V", "Fz"}),
}
#: Errors of the functional form of the baseline formula: see `_bend`.
BENT = ("slip", "peak", "load", "shoulder")
#: Disturbances of the recording.
ARTEFACTS = ("ripple", "outliers", "cross_talk", "drift", "coarse", "noisy_inputs", "offsets")


def make_case(
    seed: int, hidden: tuple[str, ...] = (), *, strength: float = 1.0, noise: float = 1.0, extra: tuple[str, ...] = (),
    artefacts: tuple[str, ...] = (), unknown: str = "", rate: float = 50.0, sweeps: int = 30,
    without: tuple[str, ...] = (), kind: str = "full", bent: str = "", signs: str = "adapted-sae",
) -> Case:  # fmt: skip
    """Make a recording.

    Parameters
    ----------
    seed : int
    hidden : tuple of str
        Effects that the baseline model lacks.
    strength, noise : float
        Factors on typical effect sizes and on typical bench noise.
    extra : tuple of str
        Effects of tire and baseline model in addition to the default ones.
    artefacts : tuple of str
        Measurement artefacts: names of `ARTEFACTS`.
    unknown : str
        Structure that is not in the library: a name of `UNKNOWN`.
    rate : float, Hz
    sweeps : int
    without : tuple of str
        Columns that are not recorded.
    kind : str
        Kind of program.
    bent : str
        Form error of the baseline formula: a name of `BENT`.
    signs : str
        Sign convention of the tables.
    """
    rng = np.random.default_rng(seed)
    base = tuple(dict.fromkeys(name for name in (*DEFAULT_EFFECTS, *extra) if name not in hidden))
    tire = _tire(rng, (*base, *hidden), strength)
    nominal = {"Fz0": tire.values["FNOMIN"], "R0": tire.values["UNLOADED_RADIUS"], "p0": 220e3, "V0": 16.7}
    others = kind if kind in ("cornering", "turning") else "full"
    imposed, other = (
        program(np.random.default_rng([seed, part]), tire.values["FNOMIN"], rate, n, which)
        for part, n, which in ((1, sweeps, kind), (2, 10, others))
    )
    truth, test = (_answer(tire, table, unknown, bent) for table in (imposed, other))
    grid = operating_range(np.random.default_rng([seed, 3]), tire.values["FNOMIN"], imposed, kind)
    operating = _answer(tire, grid, unknown, bent)
    recorded = _recorded(rng, truth, noise, artefacts).drop(columns=list(without))
    what = "+".join((*hidden, unknown)).strip("+") or "nothing"
    name = " ".join((f"{seed} {what} x{strength:g} noise {noise:g}", *artefacts, bent)).strip()
    tables = (convert_signs(table, "adapted-sae", signs) for table in (recorded, truth, test, operating))
    return Case(
        name, hidden, base, nominal, *tables, lambda: tire, frozenset(hidden).difference(WARPED), signs, unknown
    )


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
            own = 1.0 if name in UNSCALED or effect in DEFAULT_EFFECTS else strength
            sign = rng.choice([-1.0, 1.0]) if effect in EITHER_SIGN else 1.0
            values[name] = about(size, 0.15) * own * sign
    if "load_stiffness" not in effects:
        values["PKY1"] *= 0.75
    added = tuple(effect for effect in library().values() if effect.detection)  # the model that a diagnosis prints
    return Tire("mf61", values, effects=effects, signs="adapted-sae", added=added)


def _answer(tire: Tire, table: pd.DataFrame, unknown: str, bent: str) -> pd.DataFrame:
    """Return inputs and true forces; effects depend on transformed inputs."""
    warped = table.copy()
    warped["T"] = 50.0 + 40.0 * np.tanh((table["T"] - 50.0) / 40.0)
    distance = table["distance"] if "distance" in table else distance_of(table)
    warped["distance"] = 3000.0 * (1.0 - np.exp(-distance / 3000.0))
    if bent == "slip":
        for name in ("alpha", "kappa"):
            warped[name] = table[name] * (1.0 + 0.12 * np.exp(-((table[name] / 0.06) ** 2)))
    moments = [name for name in ("Mx", "My") if OF_MOMENT[name] in tire.has]
    forces = tire.evaluate(warped, signs="adapted-sae")[["Fx", "Fy", "Mz", *moments]].copy()
    if bent:
        _bend(forces, table, tire.values["FNOMIN"], bent)
    if unknown:
        _add_unknown(forces, table, tire.values["FNOMIN"], unknown)
    return pd.concat([table, forces], axis=1)


def _bend(forces: pd.DataFrame, table: pd.DataFrame, load: float, bent: str) -> None:
    """Change the functional form of the baseline formula: peak, load dependence, or shoulder of the curve."""
    slip = np.hypot(np.tan(table["alpha"]), table["kappa"])
    if bent == "peak":
        forces *= (1.0 - 0.05 * slip**2 / (slip**2 + 0.08**2)).to_numpy()[:, None]
    if bent == "load":
        forces *= (1.0 + 0.08 * (table["Fz"] / load - 1.0) ** 2).to_numpy()[:, None]
    if bent == "shoulder":
        for name, of in (("Fx", "kappa"), ("Fy", "alpha")):
            forces[name] += 0.015 * table["Fz"] * np.sin(np.pi * np.tanh(table[of] / 0.05)) / (1.0 + (slip / 0.1) ** 2)


def _add_unknown(forces: pd.DataFrame, table: pd.DataFrame, load: float, unknown: str) -> None:
    """Add structure that is not in the library."""
    relative = table["Fz"] / load
    if unknown == "power":
        power = np.abs(np.tan(table["alpha"])) * table["V"] / 16.7 * relative
        forces *= (1.0 - 0.35 * power * (table["T"] - 60.0) / 20.0).to_numpy()[:, None]
    if unknown == "hysteresis" and "t" in table:  # it vanishes in steady state
        rate = 1.0 / float(table["t"].iloc[1] - table["t"].iloc[0])
        turning = np.gradient(table["alpha"], table["t"])
        forces["Fy"] += 0.05 * table["Fz"] * slow(np.tanh(turning / 0.05), 0.3 * rate)
    if unknown == "crown":
        lean = np.abs(table["gamma"]) / 0.07
        forces *= (1.0 + 0.3 * lean * (table["p"] / 220e3 - 1.0)).to_numpy()[:, None]
    if unknown == "whirl":
        forces["Mz"] *= 1.0 - 0.3 * (table["V"] / 16.7 - 1.0) * relative


def _recorded(rng: np.random.Generator, truth: pd.DataFrame, noise: float, artefacts: tuple[str, ...]) -> pd.DataFrame:
    """Return the recording of the true forces, with noise and artefacts."""
    n = len(truth)

    def random(memory: float) -> np.ndarray:
        return np.asarray(lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], rng.standard_normal(n)))

    recorded = truth.copy()
    t = truth["t"].to_numpy()
    for name in (name for name in OUTPUTS if name in truth):
        true = truth[name].to_numpy()
        size = float(np.abs(true).max())
        drift = gaussian_filter1d(rng.standard_normal(n + 4000), 800)[2000:-2000]
        drift *= (0.004 if "drift" in artefacts else 0.001) * size / (np.std(drift) + 1e-12)
        deviation = noise * np.hypot(0.004 * size, 0.01 * true)
        offset = (0.01 if "offsets" in artefacts else 0.002) * size * rng.standard_normal()
        recorded[name] = true + deviation * random(0.5) + offset + drift
        if "ripple" in artefacts:
            angle = np.cumsum(truth["V"].to_numpy()) * (t[1] - t[0]) / 0.29
            recorded[name] += 0.005 * size * np.sin(angle + rng.uniform(0.0, 6.0))
        if "outliers" in artefacts:
            recorded.loc[rng.choice(n, 12, replace=False), name] += 0.3 * size * rng.choice([-1.0, 1.0], 12)
        step = size / (400.0 if "coarse" in artefacts else 2500.0)
        recorded[name] = np.round(recorded[name] / step) * step
    if "cross_talk" in artefacts:
        recorded["Fx"] += 0.003 * truth["Fy"]
        recorded["Fy"] -= 0.003 * truth["Fx"]
    sizes = {
        "kappa": 4e-4, "alpha": 2e-4, "gamma": 5e-5, "Fz": 0.0025 * truth["Fz"].mean(), "p": 300.0, "V": 0.02, "T": 0.4,
    }  # fmt: skip
    scale = 2.5 if "noisy_inputs" in artefacts else 1.0
    for name, size in sizes.items():
        recorded[name] = truth[name] + scale * noise * size * random(0.2)
    return recorded
