"""Bench programs as tire benches run them, at an internal rate of 100 Hz or more.

A program is a sequence of segments: alpha sweeps at steps of load, inclination and pressure; kappa sweeps at a held
slip angle; drive and brake ramps; random steering by a sum of sines; spring-rate segments (load steps without slip).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.signal import lfilter

from .tires import Specimen

FloatArray = npt.NDArray[np.float64]

#: Lowest internal rate, Hz; a recording takes every n-th row.
INTERNAL_RATE = 100.0
#: Shares of the segments: alpha sweep, kappa sweep, drive and brake ramps, random steering, spring rate.
SEGMENTS = ("alpha_sweep", "kappa_sweep", "ramps", "steering", "spring_rate")
SHARES: Mapping[str, tuple[float, float, float, float, float]] = {
    "full": (0.4, 0.22, 0.12, 0.2, 0.06),
    "pure": (0.55, 0.35, 0.0, 0.0, 0.1),
    "cornering": (0.65, 0.0, 0.0, 0.25, 0.1),
    "turning": (0.5, 0.25, 0.0, 0.2, 0.05),
    "warming": (0.4, 0.22, 0.12, 0.2, 0.06),
    "one_sided": (0.7, 0.3, 0.0, 0.0, 0.0),
    "small_slip": (1.0, 0.0, 0.0, 0.0, 0.0),
}
#: Steps of the inputs relative to their nominal values, and inclination angles.
LOADS, SPEEDS = (0.35, 0.55, 0.75, 1.0, 1.25, 1.55), (1.0, 1.0, 1.0, 0.55, 1.6)
PRESSURES, INCLINATIONS = (1.0, 0.82, 1.0, 1.2, 1.0, 0.82, 1.2, 1.0), (0.0, 0.035, 0.0, 0.07, 0.0, -0.035, -0.07)
HELD_ANGLES = (0.0, 0.0, 0.05, -0.05, 0.1, -0.1)
#: Largest slip angle (rad) and longitudinal slip.
ANGLE, SLIP = 0.21, 0.17
#: Largest slip angle of a program of small slip, relative to the angle at which slip stiffness alone reaches friction.
SMALL_SHARE = 0.25
#: Conditions of the operating range.
CONDITIONS = 1500


@dataclass(frozen=True)
class Program:
    """Inputs at the internal rate, and what the tire remembers of them."""

    inputs: pd.DataFrame
    every: int

    @property
    def rows(self) -> slice:
        """The recorded rows."""
        return slice(None, None, self.every)


def program(rng: np.random.Generator, tire: Specimen, rate: float, rows: int, kind: str) -> Program:
    """Return a bench program.

    Parameters
    ----------
    rng : numpy.random.Generator
    tire : Specimen
    rate : float, Hz
    rows : int
        Number of recorded rows.
    kind : str
        A name of `SHARES`.
    """
    every = max(1, round(INTERNAL_RATE / rate))
    internal, n = rate * every, rows * every
    seconds = float(np.clip(n / internal / 32.0, 0.8, 8.0))
    length = max(8, round(seconds * internal))
    count = -(-n // length)
    kinds = rng.choice(SEGMENTS, count, p=SHARES[kind])
    order = [rng.permutation(len(LOADS)) for _ in range(-(-count // len(LOADS)))]
    loads = np.asarray(LOADS)[np.concatenate(order)[:count]]
    parts = []
    for i in range(count):
        part = _SEGMENT[str(kinds[i])](rng, np.arange(length) / length, seconds)
        part["Fz"] = tire.load * loads[i] * part["Fz"]
        part["p"] = np.full(length, tire.pressure * PRESSURES[i * len(PRESSURES) // count])
        part["V"] = np.full(length, tire.speed * float(rng.choice(SPEEDS)))
        part["gamma"] = np.full(length, float(rng.choice(INCLINATIONS)))
        part["phit"] = np.full(length, float(rng.choice([0.0, 0.4, -0.4, 0.9])) / tire.radius * 0.3)
        parts.append(part)
    table = pd.DataFrame({name: np.concatenate([part[name] for part in parts])[:n] for name in parts[0]})
    for name in ("Fz", "p", "V", "gamma", "phit"):
        table[name] = smooth(table[name].to_numpy(), 0.1 * internal)
    for name in ("alpha", "kappa"):
        table[name] = smooth(table[name].to_numpy(), 0.02 * internal)
    if kind == "pure":
        table["alpha"] = np.where(np.abs(table["kappa"]) > 0.0, 0.0, table["alpha"])
    if kind == "one_sided":
        table["alpha"] = np.abs(table["alpha"])
    if kind == "small_slip":
        table["alpha"] *= SMALL_SHARE * tire.values["PDY1"] / tire.values["PKY1"] / ANGLE
    if kind != "turning":
        table = table.drop(columns="phit")
    table.insert(0, "t", np.arange(n) / internal)
    _remember(rng, table, tire, kind)
    return Program(table, every)


def operating_range(rng: np.random.Generator, tire: Specimen, recorded: pd.DataFrame) -> pd.DataFrame:
    """Return random conditions: all slips, loads and inclinations of a car, and the recorded range of other inputs.

    Parameters
    ----------
    rng : numpy.random.Generator
    tire : Specimen
    recorded : pandas.DataFrame
        Inputs of the recording, without errors.
    """
    radius, angle = np.sqrt(rng.uniform(size=CONDITIONS)), rng.uniform(0.0, 2.0 * np.pi, CONDITIONS)
    table = pd.DataFrame({
        "kappa": SLIP * radius * np.cos(angle), "alpha": ANGLE * radius * np.sin(angle),
        "gamma": rng.uniform(-0.07, 0.07, CONDITIONS), "Fz": tire.load * rng.uniform(0.35, 1.55, CONDITIONS),
    })  # fmt: skip
    for name in (name for name in ("p", "V", "T", "phit", "distance", "heat", "largest_slip") if name in recorded):
        table[name] = rng.uniform(recorded[name].min(), recorded[name].max(), CONDITIONS)
    table["sliding"] = np.interp(table["distance"], recorded["distance"], recorded["sliding"])
    return table


def smooth(values: FloatArray, rows: float) -> FloatArray:
    """Return a signal averaged over a window, so that steps become ramps."""
    half = max(1, round(rows / 2.0))
    padded = np.concatenate([np.full(half, values[0]), values, np.full(half, values[-1])])
    total = np.cumsum(np.concatenate([[0.0], padded]))
    return np.asarray((total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1))


def _remember(rng: np.random.Generator, table: pd.DataFrame, tire: Specimen, kind: str) -> None:
    """Add what depends on the past: distance, energy of sliding, heat of the contact, largest slip, temperature."""
    step = float(table["t"].iloc[1])
    slip = np.hypot(np.tan(table["alpha"]), table["kappa"]).to_numpy()
    power = slip * (table["V"] * table["Fz"]).to_numpy() / (tire.speed * tire.load)
    table["distance"] = np.concatenate([[0.0], np.cumsum(step * table["V"].to_numpy()[1:])])
    table["sliding"] = np.cumsum(power + 0.01) / np.sum(power + 0.01)
    table["heat"] = _lagged(power, step / 4.0) / 0.1
    table["largest_slip"] = np.maximum.accumulate(slip) / ANGLE
    seconds = len(table) * step
    if kind == "warming":
        table["T"] = 32.0 + 42.0 * (1.0 - np.exp(-1.4 * table["sliding"]))
        return
    warm = _lagged(power, 1.0 / (0.08 * seconds / step))
    ambient = np.sin(np.linspace(0.0, rng.uniform(5.0, 11.0), len(table)) + rng.uniform(0.0, 6.0))
    table["T"] = 42.0 + 30.0 * warm / max(float(warm.max()), 1e-9) + 9.0 * ambient


def _lagged(values: FloatArray, share: float) -> FloatArray:
    """Return the exponential mean of the past, with a share of each new value."""
    keep = float(np.exp(-share))
    return np.asarray(lfilter([1.0 - keep], [1.0, -keep], values))


def _part(n: int, **given: FloatArray) -> dict[str, FloatArray]:
    return {"alpha": np.zeros(n), "kappa": np.zeros(n), "Fz": np.ones(n), **given}


def _triangle(phase: FloatArray) -> FloatArray:
    """Return 0, 1, 0, -1, 0 over one period."""
    return np.asarray(2.0 * np.abs(2.0 * ((phase + 0.25) % 1.0) - 1.0) - 1.0)


def _sines(rng: np.random.Generator, time: FloatArray) -> FloatArray:
    """Return a sum of sines of 0.2 to 2 Hz with a standard deviation of 1."""
    frequency, phase = rng.uniform(0.2, 2.0, 6), rng.uniform(0.0, 2.0 * np.pi, 6)
    return np.asarray(np.sin(2.0 * np.pi * np.outer(time, frequency) + phase).sum(axis=1) / np.sqrt(3.0))


def _alpha_sweep(rng: np.random.Generator, part: FloatArray, seconds: float) -> dict[str, FloatArray]:
    return _part(len(part), alpha=-ANGLE * rng.choice([1.0, 0.6]) * _triangle(part))


def _kappa_sweep(rng: np.random.Generator, part: FloatArray, seconds: float) -> dict[str, FloatArray]:
    return _part(len(part), kappa=SLIP * _triangle(part), alpha=np.full(len(part), rng.choice(HELD_ANGLES)))


def _ramps(rng: np.random.Generator, part: FloatArray, seconds: float) -> dict[str, FloatArray]:
    """Drive or brake with a slow rise and a fast fall while the wheel steers slowly."""
    rise = np.where(part < 0.8, part / 0.8, (1.0 - part) / 0.2)
    steer = 0.06 * np.sin(2.0 * np.pi * (part + rng.uniform()))
    return _part(len(part), kappa=rng.choice([-1.0, 1.0]) * 0.14 * rise, alpha=steer)


def _steering(rng: np.random.Generator, part: FloatArray, seconds: float) -> dict[str, FloatArray]:
    load = 1.0 + 0.15 * np.clip(_sines(rng, part * seconds), -2.0, 2.0)
    return _part(len(part), alpha=np.clip(0.07 * _sines(rng, part * seconds), -ANGLE, ANGLE), Fz=load)


def _spring_rate(rng: np.random.Generator, part: FloatArray, seconds: float) -> dict[str, FloatArray]:
    return _part(len(part), Fz=0.7 + 0.2 * np.floor(4.0 * part))


_SEGMENT = {"alpha_sweep": _alpha_sweep, "kappa_sweep": _kappa_sweep, "ramps": _ramps, "steering": _steering,
            "spring_rate": _spring_rate}  # fmt: skip
