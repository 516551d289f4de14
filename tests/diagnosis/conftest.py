"""A small recording of a known tire, and the intermediate results of a diagnosis of it, without a fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.diagnosis import LeastSquares
from tirefmu.diagnosis.probing.effect_probing import Screen
from tirefmu.diagnosis.signals import Simulator, disturbances_of, signals_of, simulation
from tirefmu.tires import Tire
from tirefmu.tires.code import code_for

VALUES = {
    "FNOMIN": 1000.0, "UNLOADED_RADIUS": 0.3, "PCX1": 1.6, "PDX1": 1.6, "PKX1": 30.0, "PCY1": 1.4, "PDY1": 1.7,
    "PEY1": -0.3, "PKY1": 40.0, "PKY2": 2.0, "QBZ1": 7.0, "QCZ1": 1.2, "QDZ1": 0.1, "PDY2": -0.2, "PHY1": 0.003,
}  # fmt: skip
EFFECTS = ("load_friction", "load_stiffness", "plysteer", "camber_thrust")
#: Standard deviations of white noise, N and N m.
NOISE = {"Fx": 5.0, "Fy": 5.0, "Mz": 0.5}
FREE = ("PDX1", "PKX1", "PDY1", "PDY2", "PKY1", "PHY1", "QDZ1")


def sweeps(n=2400, rate=50.0):
    """Return bench inputs in which all channels vary."""
    t = np.arange(n) / rate
    return pd.DataFrame({
        "t": t, "alpha": 0.15 * np.sin(1.9 * t), "kappa": 0.12 * np.sin(1.1 * t + 0.5),
        "gamma": 0.05 * np.sin(0.31 * t), "Fz": 1000.0 + 400.0 * np.sin(0.7 * t), "V": np.full(n, 10.0),
    })  # fmt: skip


def measured(tire, inputs, seed=0):
    """Return the inputs with the noisy forces of a tire, in adapted SAE."""
    rng = np.random.default_rng(seed)
    forces = tire.evaluate(inputs.drop(columns="t"), signs="adapted-sae", code="numpy")
    return inputs.assign(**{name: forces[name] + size * rng.normal(size=len(inputs)) for name, size in NOISE.items()})


@pytest.fixture(scope="session")
def tire():
    return Tire("mf96", VALUES, effects=EFFECTS, signs="adapted-sae")


@pytest.fixture(scope="session")
def table(tire):
    return measured(tire, sweeps())


@pytest.fixture(scope="session")
def problem(tire, table):
    """Return the least-squares problem of the recording, with the true noise."""
    signals = signals_of(table, tire, "adapted-sae", smooth=False)
    noise = np.array([NOISE[name] for name in signals.channels])
    inverse_noise = np.where(signals.present & ~signals.holdout, 1.0 / noise[:, None], 0.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulation, "fastest_code", lambda model: code_for(model, "numpy"))  # no compilation
        simulator = Simulator(tire, signals)
    return LeastSquares(
        simulator,
        inverse_noise,
        disturbances_of(signals, noise, VALUES["UNLOADED_RADIUS"]),
        tire.symbolic_model.prior_center | VALUES,
    )


@pytest.fixture(scope="session")
def at_true_values(problem, tire):
    """Return a screen at the true coefficients."""
    screen = Screen(problem, problem.at(tire.parameters(), FREE))
    return screen


@pytest.fixture(scope="session")
def without_camber(problem, tire):
    """Return a screen at a tire that lacks camber thrust and is otherwise true."""
    made = replace(tire, values={**tire.values, "PVY3": 0.3})
    rows = measured(made, sweeps())
    signals = signals_of(rows, tire, "adapted-sae", smooth=False)
    other = replace(problem, simulator=problem.simulator.with_signals(signals))
    screen = Screen(other, other.at(tire.parameters(), FREE))
    return screen
