"""A tire with known coefficients on a small virtual bench without noise, and its fit."""

from __future__ import annotations

from math import radians
from types import SimpleNamespace

import numpy as np
import pytest

from tirefmu.fitting import fit
from tirefmu.fitting.problem import Problem, Rows, equal_weights
from tirefmu.measurements import Noise, Recording, VirtualBench, alpha_sweeps, concatenate, kappa_sweeps
from tirefmu.tires import Tire

EFFECTS = (
    "load_friction", "load_stiffness", "load_curvature", "camber_thrust", "camber_friction", "plysteer",
    "conicity", "combined_Gxa", "combined_Gyk", "residual_torque_Mzr", "trail_load",
)  # fmt: skip
#: A typical tire, in adapted SAE.
KNOWN = {
    "FNOMIN": 700.0, "UNLOADED_RADIUS": 0.23,
    "PCX1": 1.6, "PDX1": 1.8, "PDX2": -0.15, "PDX3": 2.0, "PEX1": 0.2, "PEX2": 0.1, "PEX3": -0.05,
    "PKX1": 35.0, "PKX2": 2.0, "PKX3": 0.2, "RBX1": 12.0, "RBX2": 9.0, "RCX1": 1.05, "RHX1": 0.002,
    "PCY1": 1.4, "PDY1": 1.9, "PDY2": -0.2, "PDY3": 3.0, "PEY1": -0.2, "PEY2": -0.3, "PKY1": 45.0, "PKY2": 2.2,
    "PHY1": 0.003, "PHY2": 0.001, "PHY3": 0.03, "PVY1": 0.02, "PVY2": 0.01, "PVY3": 0.3, "PVY4": 0.1,
    "RBY1": 11.0, "RBY2": 7.0, "RBY3": 0.01, "RCY1": 1.03, "RHY1": 0.01,
    "QBZ1": 7.0, "QBZ2": -1.0, "QBZ3": -0.2, "QBZ9": 12.0, "QBZ10": 0.1, "QCZ1": 1.2, "QDZ1": 0.11, "QDZ2": -0.01,
    "QDZ6": 0.003, "QDZ7": 0.001, "QDZ8": 0.2, "QDZ9": 0.05,
}  # fmt: skip
NOMINAL = {"Fz0": 700.0, "R0": 0.23}


def bench(tire, loads=(220.0, 500.0, 800.0, 1120.0), cambers=(0.0, 2.0, 4.0), *, kappa=True, noise=None):
    """Return a recording of few rows; by default without noise."""
    inclined = [radians(angle) for angle in cambers]
    programs = [alpha_sweeps(loads, inclined, sample_rate=3.0)]
    if kappa:
        slip_angles = [radians(angle) for angle in (0, 3, 6)]
        programs.append(kappa_sweeps(loads, slip_angles, inclined[::2], sample_rate=3.0))
    return VirtualBench(tire, noise or Noise.none(), seed=1).run(concatenate(programs))


def sideways(tire, **program):
    """Return a recording of the side force only, which is fitted in a second."""
    recording = bench(tire, kappa=False, **program)
    return Recording(recording.table.drop(columns=["Fx", "Mz"]), recording.signs, "sideways")


def anywhere(n=4000, seed=1):
    """Return random inputs in the range of the bench."""
    rng = np.random.default_rng(seed)
    return {
        "kappa": rng.uniform(-0.3, 0.3, n),
        "alpha": rng.uniform(-0.2, 0.2, n),
        "gamma": rng.uniform(0.0, 0.07, n),
        "Fz": rng.uniform(220.0, 1120.0, n),
    }


def other_tire(seed):
    """Return the known tire with every coefficient changed at random."""
    rng = np.random.default_rng(seed)
    unchanged = ("FNOMIN", "UNLOADED_RADIUS", "PCY1", "RCX1", "RCY1")  # these are near their bounds
    values = {name: value * (1.0 if name in unchanged else rng.uniform(0.6, 1.4)) for name, value in KNOWN.items()}
    return Tire("mf96", values, effects=EFFECTS, signs="adapted-sae")


def coefficients(result):
    """Return the coefficients of a result by name, in the signs of the known tire and of recipes."""
    return {coefficient.name: coefficient for coefficient in result.in_signs("adapted-sae").coefficients}


def fitted(tables, **options):
    """Return a fit of recordings with the effects of the known tire."""
    return fit(tables, "mf96", **{"effects": EFFECTS, "nominal": NOMINAL, **options})


def problem(table, tire, free, **settings):
    """Return the problem of the side force with equal weights, in scaled coefficients."""
    rows = Rows.of(table, tire, ["Fy"])
    scale = np.array([max(abs(tire.values[name]), 0.1) for name in free])
    return Problem(tire, rows, free, equal_weights(rows), scale, **settings)


def recipe(folder, text):
    """Write a recipe and return its path."""
    path = folder / "own.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


@pytest.fixture(scope="session")
def known():
    return Tire("mf96", KNOWN, effects=EFFECTS, signs="adapted-sae", name="known")


@pytest.fixture(scope="session")
def make():
    """Return functions and constants that the tests share."""
    return SimpleNamespace(
        bench=bench, sideways=sideways, anywhere=anywhere, other_tire=other_tire,
        coefficients=coefficients, fit=fitted, problem=problem, recipe=recipe, effects=EFFECTS, nominal=NOMINAL,
    )  # fmt: skip


@pytest.fixture(scope="session")
def noisy_table(known):
    """Return a side force with noise of 20 N, which the known tire cannot fit exactly."""
    table = sideways(known).table
    return table.assign(Fy=table["Fy"] + np.random.default_rng(3).normal(0.0, 20.0, len(table)))


@pytest.fixture(scope="session")
def side_fit(known):
    """Return a fit of the side force at several inclinations and loads, and its recording."""
    recording = sideways(known)
    return fitted(recording), recording
