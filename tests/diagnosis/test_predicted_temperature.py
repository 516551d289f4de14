"""Friction that follows the temperature of the tread, in made recordings with and without it."""

from __future__ import annotations

import pytest

from tirefmu.diagnosis import diagnose, export_and_simulate

from ..fitting.thermal_generator import recording

NOMINAL = {"Fz0": 1500.0, "R0": 0.25}


def diagnosed(table):
    return diagnose(table, nominal=NOMINAL, effects=["load_friction", "load_stiffness"], model="mf96")


@pytest.fixture(scope="module")
def table():
    """Return a recording whose friction falls with temperature, with the temperatures of air and road."""
    return recording(seed=0, friction=1e-4, optimum=30.0, duration=180.0)


@pytest.fixture(scope="module")
def predicted(table):
    return diagnosed(table.drop(columns="T"))


@pytest.mark.slow
def test_a_temperature_that_was_not_recorded_is_predicted(predicted):
    assert [one.effect for one in predicted.found] == ["temp_friction"]
    assert "heat_friction" in predicted.confounded_with["temp_friction"]  # without kelvin, nearly the same
    assert "Temperature of temp_friction: predicted by the effect temperature" in predicted.verdict
    assert predicted.recording["derived_columns"] == ["T"]
    assert predicted.recording["ignored_columns"] == []


@pytest.mark.slow
def test_the_improved_tire_predicts_its_temperature(predicted, table, tmp_path):
    """Its FMU and its evaluation need no temperature of the tread, and its error is that of the diagnosis."""
    simulated = export_and_simulate(predicted, table.drop(columns="T"), tmp_path)
    assert simulated["ok"]
    assert simulated["after"]["rmse"]["Fy"] < 1.05 * predicted.gap["train"]["Fy"]["after"]
    assert simulated["after"]["rmse"]["Fy"] < 0.8 * simulated["before"]["rmse"]["Fy"]


@pytest.mark.slow
def test_a_recorded_temperature_is_used(table):
    result = diagnosed(table)
    assert [one.effect for one in result.found] == ["temp_friction"]
    assert "Temperature of temp_friction: recorded (T)" in result.verdict
    assert result.recording["derived_columns"] == []
    assert "temperature" not in result.tire.has


@pytest.mark.slow
def test_no_effect_of_a_predicted_temperature_is_found_without_one():
    result = diagnosed(recording(seed=1, duration=120.0).drop(columns="T"))
    assert result.found == ()
    assert "temperature of" not in result.verdict.lower()
