"""Fit of the heat balance: recordings from an independent generator, messages, and the content of the result."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from tirefmu import fit
from tirefmu.boundary.errors import DataError
from tirefmu.fitting.temperature import STARTS, fit_temperature, optimum_temperature
from tirefmu.measurements import Recording
from tirefmu.tires import Tire

from .thermal_generator import recording

NOISE = 0.3
NOMINAL = {"Fz0": 1500.0, "R0": 0.25}
EFFECTS = ("load_friction", "load_stiffness", "temperature")


@pytest.fixture(scope="module")
def table():
    return recording(seed=3, noise=NOISE, duration=150.0)


@pytest.fixture(scope="module")
def result(table):
    return fit(table, "mf96", effects=EFFECTS, nominal=NOMINAL)


@pytest.mark.slow
def test_the_temperature_of_another_law_is_predicted(result):
    """The generator has four nodes and other laws of cooling; 0.3 K of sensor noise."""
    assert result.temperature.holdout_rmse < 0.25 * result.temperature.constant_rmse
    assert result.temperature.holdout_rmse < 2.0 * NOISE
    assert {"THCAPS", "THCONS"} <= set(result.temperature.determined)
    assert result.tire.values["THACT"] == 1.0
    assert "temperature" in result.tire.has


def test_the_result_has_the_errors_for_a_machine(result):
    content = json.loads(json.dumps(result.to_json()))["temperature"]
    assert content["rmse"] > 0.0
    assert content["holdout_rmse"] == result.temperature.holdout_rmse
    assert content["column"] == "T"


def test_the_tire_predicts_the_recording_on_its_own(result, table):
    surface = result.tire.evaluate(table)["T_surface"] - 273.15
    error = np.interp(table["t"] - result.temperature.delay[0], table["t"], surface) - table["T"]
    assert np.sqrt(np.mean(error**2)) < 1.5 * NOISE


@pytest.mark.slow
def test_coefficients_are_recovered_with_their_intervals():
    """A recording of the model itself: the true values are within 1.5 times the intervals."""
    truth = {"THCAPS": 200.0, "THCONS": 90.0, "THROLL": 0.015, "THROAD": 25.0, "THCAPC": 1300.0}
    tire = Tire("mf96", {"FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25, **truth, "THSTARTS": 310.0, "THSTARTB": 308.0,
                         "THSTARTC": 305.0, "THSTARTG": 302.0}, effects={"temperature"})  # fmt: skip
    table = recording(seed=5, duration=300.0)
    evaluated = tire.evaluate(table.drop(columns=["T", "Fx", "Fy"]))
    noise = np.random.default_rng(0).normal(0.0, 0.1, len(table))
    shown = np.interp(table["t"] - 0.3, table["t"], evaluated["T_surface"] - 273.15)  # a sensor that is late
    known = table.assign(Fx=evaluated["Fx"], Fy=evaluated["Fy"], T=shown + noise)
    _, found = fit_temperature(tire, [Recording(known, "iso", "known")])
    assert found.rmse < 0.1
    assert found.holdout_rmse < 1.5 * 0.1  # the noise; a slow node is hardly determined by five minutes
    assert abs(found.delay[0] - 0.3) < 0.02
    for name in ("THCAPS", "THCONS"):
        assert abs(np.log(found.values[name] / truth[name])) < 1.5 * np.log(found.intervals[name]) + 0.01


def test_time_that_goes_backward_begins_with_other_temperatures(table):
    """Two runs in one table, the second one on a cold tire."""
    drive = table[table["t"] < 60.0].drop(columns=["T", "Fx", "Fy"])
    runs = []
    for start in (330.0, 300.0):
        starts = dict.fromkeys(STARTS, start)
        tire = Tire("mf96", {"FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25, **starts}, effects={"temperature"})
        run = tire.evaluate(drive)
        runs.append(run.assign(T=run["T_surface"] - 273.15))
    both = Recording(pd.concat(runs, ignore_index=True), "iso", "two runs")
    _, found = fit_temperature(tire, [both])
    np.testing.assert_allclose([start[0] for start in found.starts], [330.0, 300.0], rtol=0, atol=1.0)
    assert found.rmse < 0.1


@pytest.mark.parametrize(
    ("optimum", "curvature"), [pytest.param(55.0, 2e-4, marks=pytest.mark.slow), (140.0, 2e-5), (60.0, 0.0)]
)
def test_an_optimum_is_determined_only_within_the_recorded_temperatures(optimum, curvature):
    table = recording(seed=0, friction=curvature, optimum=optimum, duration=180.0)
    forces = fit(table, "mf96", effects=["load_friction", "load_stiffness", "temp_friction"], nominal=NOMINAL)
    found = optimum_temperature(forces.tire, [Recording(table, "iso", "made")])
    assert found.determined == (optimum == 55.0)
    if found.determined:
        assert abs(found.value - optimum) < min(3.0, 2.0 * found.half)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table.drop(columns="T"), "needs the column 'T'"),
        (lambda table: table.assign(T=2000.0), "T reaches 2000 deg C: in another unit"),
        (lambda table: table.assign(T=-273.15), "T reaches -273.1 deg C"),
        (lambda table: table.assign(T_road=0.0), "T_road reaches 0 K: in deg C"),
        (lambda table: table.assign(T=1.8 * table["T"] + 32.0), "in deg F"),
    ],
)
def test_impossible_temperatures_are_refused(table, change, message):
    tire = Tire("mf96", {"FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25})
    with pytest.raises(DataError, match=message):
        fit(Recording(change(table), "iso", "x.csv"), "mf96", start=tire, effects=EFFECTS)


def test_a_tread_temperature_column_by_name(table):
    renamed = table[table["t"] < 60.0].rename(columns={"T": "inner"})
    tire = Tire("mf96", {"FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25}, effects={"temperature"})
    _, found = fit_temperature(tire, [Recording(renamed, "iso", "x")], "inner")
    assert found.column == "inner"
    with pytest.raises(DataError, match="row 1: inner is 500, but a tread has -80 to 250 deg C"):
        fit_temperature(tire, [Recording(renamed.assign(inner=500.0), "iso", "x")], "inner")
