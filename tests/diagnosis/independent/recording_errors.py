"""Errors of a recording: noise with heavy tails, 1/f noise, drift, cross-talk, skew, waves, spikes, columns."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy import fft

from .tires import Specimen

FloatArray = npt.NDArray[np.float64]

OUTPUTS = ("Fx", "Fy", "Mz", "Mx", "My")
#: Errors that a recording has or lacks; noise, offsets and quantisation are always there.
ERRORS = ("cross_talk", "skew", "time_wave", "distance_wave", "drift", "spikes", "coarse", "pink", "noisy_inputs",
          "offsets", "columns")  # fmt: skip
#: Largest cross-talk of Fy into Fx and Mz (times the radius), and of Fx into Fy; largest skew, s.
CROSS_TALK, CROSS_TALK_MZ, CROSS_TALK_FY, SKEW = 0.03, 0.003, 0.01, 0.025
#: Least size of a channel in the errors, relative to the nominal load and its moment.
SMALLEST = 0.05
#: Standard deviations of the noise of the inputs; Fz and p relative to the nominal values.
INPUT_NOISE = {"kappa": 4e-4, "alpha": 2e-4, "gamma": 5e-5, "Fz": 0.0025, "p": 0.0015, "V": 0.02, "T": 0.4}


def recorded(
    rng: np.random.Generator, internal: pd.DataFrame, every: int, tire: Specimen, noise: float, errors: Collection[str]
) -> pd.DataFrame:
    """Return the recording of inputs and forces.

    Parameters
    ----------
    rng : numpy.random.Generator
    internal : pandas.DataFrame
        t, inputs, distance and true forces at the internal rate.
    every : int
        A recording has every n-th row.
    tire : Specimen
    noise : float
        Factor on the noise of a typical bench.
    errors : collection of str
        Names of `ERRORS`.
    """
    channels = [name for name in OUTPUTS if name in internal]
    delay = rng.uniform(0.4, 1.0) * SKEW if "skew" in errors else 0.0
    t, true = internal["t"].to_numpy(), internal
    late = {name: np.interp(t - delay, t, true[name])[::every] for name in channels}
    table = internal.iloc[::every].reset_index(drop=True)
    forces = _cross_talk(rng, late, tire) if "cross_talk" in errors else late
    waves = _waves(rng, table, tire, errors)
    degrees = float(rng.uniform(3.0, 6.0))
    for name in channels:
        typical = tire.load * (1.0 if name in ("Fx", "Fy") else 0.1 * tire.radius)
        size = max(float(np.quantile(np.abs(late[name]), 0.995)), SMALLEST * typical)
        deviation = noise * np.hypot(0.004 * size, 0.008 * late[name])
        values = forces[name] + deviation * _heavy(rng, len(table), degrees) + size * rng.uniform(0.3, 1.0) * waves
        values = values + noise * (0.006 if "pink" in errors else 0.001) * size * _pink(rng, len(table))
        values = values + (0.01 if "offsets" in errors else 0.002) * size * rng.standard_normal()
        if "drift" in errors:
            walk = np.cumsum(rng.standard_normal(len(table)))
            values = values + 0.004 * size * (walk - walk.mean()) / walk.std()
        if "spikes" in errors:
            rows = rng.choice(len(table), max(2, len(table) // 600), replace=False)
            values[rows] += rng.choice([-1.0, 1.0], len(rows)) * size * rng.uniform(0.15, 0.6, len(rows))
        step = size / (300.0 if "coarse" in errors else 4000.0)
        table[name] = step * np.round(values / step)
    scale = noise * (2.5 if "noisy_inputs" in errors else 1.0)
    unit = {"Fz": tire.load, "p": tire.pressure}
    for name, size in INPUT_NOISE.items():
        table[name] = table[name] + scale * size * unit.get(name, 1.0) * _heavy(rng, len(table), degrees)
    return table


def with_columns(rng: np.random.Generator, table: pd.DataFrame) -> pd.DataFrame:
    """Return a table with columns that mean nothing for the tire."""
    return table.assign(RunNo=7.0, RoadTempC=24.0 + 0.5 * _pink(rng, len(table)), Hum=rng.integers(40, 60, len(table)))


def _heavy(rng: np.random.Generator, n: int, degrees: float) -> FloatArray:
    """Return noise of Student's t distribution with a standard deviation of 1."""
    return np.asarray(rng.standard_t(degrees, n) / np.sqrt(degrees / (degrees - 2.0)))


def _pink(rng: np.random.Generator, n: int) -> FloatArray:
    """Return noise with a power spectrum of 1/f and a standard deviation of 1."""
    spectrum = fft.rfft(rng.standard_normal(n))
    spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))
    spectrum[0] = 0.0
    values = fft.irfft(spectrum, n)
    return np.asarray(values / values.std())


def _cross_talk(rng: np.random.Generator, force: dict[str, FloatArray], tire: Specimen) -> dict[str, FloatArray]:
    """Return forces of which a part appears in other channels."""
    mixed = dict(force)
    share = rng.uniform(0.3, 1.0, 3) * rng.choice([-1.0, 1.0], 3)
    mixed["Fx"] = force["Fx"] + CROSS_TALK * share[0] * force["Fy"]
    mixed["Fy"] = force["Fy"] + CROSS_TALK_FY * share[1] * force["Fx"]
    mixed["Mz"] = force["Mz"] + CROSS_TALK_MZ * share[2] * tire.radius * force["Fy"]
    return mixed


def _waves(rng: np.random.Generator, table: pd.DataFrame, tire: Specimen, errors: Collection[str]) -> FloatArray:
    """Return periodic disturbances over the size of a channel: of a machine in time, of the road in distance."""
    total = np.zeros(len(table))
    if "time_wave" in errors:
        total += 0.006 * np.sin(2.0 * np.pi * rng.uniform(0.7, 11.0) * table["t"] + rng.uniform(0.0, 6.0))
    if "distance_wave" in errors:
        length = tire.radius * rng.choice([2.0 * np.pi, 4.1, 10.8])
        total += 0.008 * np.sin(2.0 * np.pi * table["distance"] / length + rng.uniform(0.0, 6.0))
    return np.asarray(total)
