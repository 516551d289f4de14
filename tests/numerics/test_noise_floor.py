"""The noise floor on synthetic data with known noise."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tirefmu.numerics.noise_floor import noise_floor


def sweeps(n=4000):
    """Return sweeps of alpha at three loads, 50 rows per second."""
    t = np.arange(n) / 50.0
    load = np.repeat([300.0, 700.0, 1100.0], -(-n // 3))[:n]
    return pd.DataFrame({"t": t, "alpha": 0.2 * np.sin(0.9 * t), "Fz": load})


def missing(table):
    """Return a smooth error of a model: another curve at each load."""
    return table["Fz"].to_numpy() * 0.3 * np.sin(15.0 * table["alpha"].to_numpy())


def floor_of(table, residual):
    return noise_floor(table, {"Fy": residual})["Fy"]


@settings(max_examples=3, deadline=None)
@given(seed=st.integers(0, 1000), size=st.floats(10.0, 100.0))
def test_it_is_the_noise_whatever_smooth_function_of_the_inputs_a_model_lacks(seed, size):
    table = sweeps()
    noise = np.random.default_rng(seed).normal(0.0, size, len(table))
    for residual in (noise, missing(table) + noise):
        assert floor_of(table, residual).floor == pytest.approx(size, rel=0.1)


@pytest.mark.parametrize("seed", range(4))
def test_noise_is_not_explained_by_the_rows_that_have_it(seed):
    """A regression that used the same 400 rows would explain 2 to 5 % of white noise."""
    noise = np.random.default_rng(seed).normal(0.0, 10.0, 400)
    assert floor_of(sweeps(400), noise).floor == pytest.approx(np.sqrt(np.mean(noise**2)), rel=0.01)


def test_the_floors_are_plain_numbers():
    floors = floor_of(sweeps(), missing(sweeps()))
    assert {type(floors.floor), type(floors.with_history)} == {float}


def test_without_noise_little_of_a_smooth_function_remains():
    table = sweeps()
    assert floor_of(table, missing(table)).floor < 0.02 * missing(table).std()


def test_it_is_at_most_the_residual():
    table = sweeps()
    noise = np.random.default_rng(3).normal(0.0, 5.0, len(table))
    assert floor_of(table, noise).floor <= np.sqrt(np.mean(noise**2))


def test_differences_between_directions_are_in_the_floor_of_the_inputs_only():
    table = sweeps()
    direction = np.sign(np.cos(0.9 * table["t"].to_numpy()))
    noise = np.random.default_rng(1).normal(0.0, 5.0, len(table))
    found = floor_of(table, 60.0 * direction + noise)
    assert found.floor == pytest.approx(60.0, rel=0.1)
    assert found.with_history < 20.0


def test_slow_change_is_in_the_floor_of_the_inputs_only():
    table = sweeps().assign(Fz=700.0)  # loads in a sequence would be confounded with time
    noise = np.random.default_rng(1).normal(0.0, 5.0, len(table))
    fading = np.exp(-table["t"].to_numpy() / 20.0) * 80.0 * np.sin(10.0 * table["alpha"].to_numpy())
    found = floor_of(table, fading + noise)
    assert found.with_history < 8.0 < 0.5 * found.floor


def test_waves_are_not_removed():
    """A wave of 3 Hz is no function of inputs that change within seconds."""
    table = sweeps()
    wave = 40.0 * np.sin(2.0 * np.pi * 3.0 * table["t"].to_numpy())
    assert floor_of(table, wave).with_history == pytest.approx(40.0 / np.sqrt(2.0), rel=0.15)


def test_rows_that_are_not_used_are_ignored():
    table = sweeps()
    residual = np.random.default_rng(2).normal(0.0, 20.0, len(table))
    residual[::3] = np.nan
    assert floor_of(table, residual).floor == pytest.approx(20.0, rel=0.1)


def test_with_few_rows_it_is_unknown():
    table = sweeps(30)
    assert np.isnan(floor_of(table, np.ones(30)).floor)


def test_an_input_that_varies_by_its_noise_only_is_ignored():
    """Otherwise the features of such inputs hide the curve over the others."""
    table = sweeps()
    rng = np.random.default_rng(5)
    noise = rng.normal(0.0, 10.0, len(table))
    noisy = table.assign(V=16.0 + rng.normal(0.0, 0.5, len(table)), p=80e3 + rng.normal(0.0, 400.0, len(table)))
    assert floor_of(noisy, missing(table) + noise).floor == floor_of(table, missing(table) + noise).floor


def test_the_second_floor_can_be_omitted():
    rng = np.random.default_rng(0)
    table = pd.DataFrame({"t": np.arange(2000) / 50.0, "alpha": 0.2 * np.sin(np.linspace(0.0, 40.0, 2000))})
    residuals = {"Fy": 50.0 * np.cos(20.0 * table["alpha"].to_numpy()) + rng.normal(0.0, 10.0, 2000)}
    both, first = noise_floor(table, residuals)["Fy"], noise_floor(table, residuals, with_history=False)["Fy"]
    assert first.floor == both.floor
    assert np.isnan(first.with_history)
    assert both.with_history <= both.floor
