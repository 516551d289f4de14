"""Start values of states that are fitted to each segment of a recording."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.diagnosis.diagnose import with_library
from tirefmu.diagnosis.signals import Simulator, signals_of
from tirefmu.fitting import fit
from tirefmu.fmu.description.interface import interface
from tirefmu.measurements import Recording, with_fitted_starts
from tirefmu.symbolic.added import effect_text, read_effect
from tirefmu.tires import Tire

#: Friction falls with the heat of the tread, with which a sweep begins.
WARM = """
name = "warm"
physics = "friction falls with the heat of the tread"
[coefficients]
WARMMU = {description = "friction", unit = "1", lower = -1.0, upper = 1.0}
[states.warmth]
kind = "heat"
drive = "sliding_power/FNOMIN/4"
rate = "1/4"
start = "fitted"
[[acts]]
on = "friction_y"
factor = "exp(-WARMMU*warmth)"
"""
EFFECT = read_effect(WARM, "warm.toml")
VALUES = {
    "FNOMIN": 4000.0,
    "UNLOADED_RADIUS": 0.3,
    "WIDTH": 0.2,
    "VERTICAL_STIFFNESS": 2e5,
    "CSLIP": 8e4,
    "CALPHA": 8e4,
    "UMIN": 1.0,
    "UMAX": 1.2,
}
STARTS = np.array([1.5, 0.2, 0.8])


def tire(**values):
    return Tire("fiala", {**VALUES, "WARMMU": 0.15, **values}, effects={"warm"}, added=(EFFECT,))


@pytest.fixture(scope="module")
def recording():
    """Return three sweeps with a pause of a minute between them, each of which begins with its own heat."""
    t = np.linspace(0.0, 6.0, 150)
    sweep = pd.DataFrame({"alpha": 0.2 * np.sin(t), "Fz": 4000.0, "V": 15.0})
    table = pd.concat([sweep.assign(t=t + 60.0 * k, warmth=start) for k, start in enumerate(STARTS)], ignore_index=True)
    noise = np.random.default_rng(2).normal(0.0, 5.0, len(table))
    table["Fy"] = tire().evaluate(table)["Fy"] + noise
    return Recording(table.drop(columns="warmth"), "iso", "three sweeps")


def test_a_column_of_the_table_is_the_start_of_each_segment(recording):
    table = recording.table
    begins = np.array([0, 150, 300])
    course = tire().evaluate(table.assign(warmth=np.repeat(STARTS, 150)))["warmth"].to_numpy()
    np.testing.assert_array_equal(course[begins], STARTS)
    equilibrium = tire().evaluate(table)["warmth"].to_numpy()
    assert equilibrium[0] == 0.0
    assert equilibrium[150] < 0.5 * STARTS[1]  # it has cooled in the pause
    again = tire().evaluate(tire().evaluate(table.assign(warmth=course)))
    np.testing.assert_allclose(again["warmth"], course, rtol=1e-12)


def test_the_measured_forces_determine_the_starts(recording):
    found = with_fitted_starts(tire(), recording).table["warmth"].iloc[[0, 150, 300]]
    np.testing.assert_allclose(found, STARTS, atol=0.05)


@pytest.mark.slow
def test_a_fit_estimates_the_starts_and_the_coefficient(recording):
    fitted = fit([recording], start=tire(WARMMU=0.05)).tire
    assert fitted.values["WARMMU"] == pytest.approx(0.15, rel=0.1)


def test_a_diagnosis_simulates_with_fitted_starts(recording):
    start = with_library(tire())
    simulator = Simulator(start, signals_of(recording.table, start, recording.signs))
    residual = simulator.signals.measured - simulator.forces(start.parameters())
    assert np.sqrt(np.mean(residual**2)) < 6.0  # the noise; from equilibrium it is 60 N
    equilibrium = tire().evaluate(recording.table)["Fy"]
    assert np.sqrt(np.mean((recording.table["Fy"] - equilibrium) ** 2)) > 30.0


def test_the_fmu_starts_in_equilibrium():
    (state,) = [v for v in interface(tire()).variables if v.name == "warmth"]
    assert state.start is None


def test_the_file_contains_it():
    assert 'start = "fitted"' in effect_text(EFFECT)
