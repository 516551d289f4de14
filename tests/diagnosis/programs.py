"""Bench programs: sweeps of either slip at steps of load, camber, pressure and speed."""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

#: Probabilities of the kinds of sweep: alpha, kappa, kappa at a slip angle, all inputs simultaneously.
KINDS = {
    "full": (0.45, 0.3, 0.15, 0.1),
    "cornering": (1.0, 0.0, 0.0, 0.0),
    "warming": (0.45, 0.3, 0.15, 0.1),
    "one_sided": (0.7, 0.3, 0.0, 0.0),
    "small_slip": (1.0, 0.0, 0.0, 0.0),
    "turning": (0.6, 0.4, 0.0, 0.0),
}
#: Conditions of the operating range.
CONDITIONS = 1500


def program(rng: np.random.Generator, load: float, rate: float, sweeps: int, kind: str = "full") -> pd.DataFrame:
    """Return the inputs of a bench program.

    Parameters
    ----------
    rng : numpy.random.Generator
    load : float, N
        Nominal load.
    rate : float, Hz
    sweeps : int
        Number of sweeps of 3 s.
    kind : str
        "full"; "cornering" (no longitudinal slip), "warming" (the tread only warms up), "one_sided" (slip angles
        of one sign), "small_slip" (pure slip angles below the peak), "turning" (with a turn slip).
    """
    reach = 0.055 if kind == "small_slip" else rng.uniform(0.15, 0.2)
    rows = int(3.0 * rate)
    wave = 2.0 * np.abs(2.0 * ((np.arange(rows) / rows + 0.25) % 1.0) - 1.0) - 1.0
    if kind == "one_sided":
        wave = np.abs(wave)
    table = pd.concat([_sweep(rng, load, rate, wave, reach, kind) for _ in range(sweeps)], ignore_index=True)
    for name, seconds in (("gamma", 0.1), ("Fz", 0.1), ("p", 0.5), ("V", 0.5)):
        table[name] = slow(table[name].to_numpy(), seconds * rate)
    table["alpha"], table["kappa"] = (slow(table[name].to_numpy(), 0.02 * rate) for name in ("alpha", "kappa"))
    slide = np.abs(table["alpha"]) + np.abs(table["kappa"])
    warmth = slow((slide * table["V"] * table["Fz"] / load).to_numpy(), 15.0 * rate)
    sway = np.linspace(0.0, rng.uniform(4.0, 9.0), len(table))
    table["T"] = 45.0 + 25.0 * warmth / warmth.max() + 12.0 * np.sin(sway)
    if kind == "warming":
        table["T"] = 30.0 + 45.0 * (1.0 - np.exp(-np.linspace(0.0, 1.5, len(table))))
    if kind == "turning":
        table["phit"] = slow(np.repeat(rng.choice([0.0, 0.6, -0.6, 1.2], sweeps), rows), 0.2 * rate)
    table.insert(0, "t", np.arange(len(table)) / rate)
    return table


def _sweep(
    rng: np.random.Generator, load: float, rate: float, wave: np.ndarray, reach: float, program_kind: str
) -> pd.DataFrame:
    """Return one sweep of 3 s."""
    rows = len(wave)
    kind = rng.choice(["alpha", "kappa", "both", "mixed"], p=KINDS[program_kind])
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
    return pd.DataFrame(part)


def operating_range(rng: np.random.Generator, load: float, recorded: pd.DataFrame, kind: str) -> pd.DataFrame:
    """Return random operating conditions: all slips, loads and inclinations, and the recorded range of other inputs.

    Parameters
    ----------
    rng : numpy.random.Generator
    load : float, N
        Nominal load.
    recorded : pandas.DataFrame
        Inputs of the recording.
    kind : str
        Kind of program; "cornering" has no longitudinal slip.
    """
    n = CONDITIONS
    size, angle = np.sqrt(rng.uniform(size=n)), rng.uniform(0.0, 2.0 * np.pi, n)
    table = pd.DataFrame({
        "kappa": (0.0 if kind == "cornering" else 0.15) * size * np.cos(angle), "alpha": 0.18 * size * np.sin(angle),
        "gamma": rng.uniform(-0.07, 0.07, n), "Fz": load * rng.uniform(0.45, 1.5, n),
    })  # fmt: skip
    with_distance = recorded.assign(distance=distance_of(recorded))
    for name in (name for name in ("p", "V", "T", "phit", "distance") if name in with_distance):
        table[name] = rng.uniform(with_distance[name].min(), with_distance[name].max(), n)
    return table


def distance_of(table: pd.DataFrame) -> np.ndarray:
    """Return the distance rolled since the start, m."""
    return np.concatenate([[0.0], np.cumsum(np.diff(table["t"]) * table["V"].to_numpy()[1:])])


def slow(values: np.ndarray, rows: float) -> np.ndarray:
    """Return a signal behind a first-order lag with a time constant in rows."""
    decay = float(np.exp(-1.0 / max(rows, 1e-3)))
    return np.asarray(lfilter([1.0 - decay], [1.0, -decay], values, zi=[decay * values[0]])[0])
