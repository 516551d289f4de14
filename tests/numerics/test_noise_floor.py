"""The noise floor and the other parts of an error, on synthetic data with known noise."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from tirefmu.numerics.noise_floor import error_split


def sweeps(n=4000):
    """Return sweeps of alpha at three loads, 50 rows per second."""
    t = np.arange(n) / 50.0
    load = np.repeat([300.0, 700.0, 1100.0], -(-n // 3))[:n]
    return pd.DataFrame({"t": t, "alpha": 0.2 * np.sin(0.9 * t), "Fz": load})


def missing(table):
    """Return a smooth error of a model: another curve at each load."""
    return table["Fz"].to_numpy() * 0.3 * np.sin(15.0 * table["alpha"].to_numpy())


def parts_of(table, residual, segment=None):
    return error_split(table, {"Fy": residual}, np.zeros(len(table), dtype=int) if segment is None else segment)["Fy"]


def coloured(n, correlation, seed=0):
    """Return noise of standard deviation 1 whose rows have this correlation with their neighbors."""
    white = np.random.default_rng(seed).standard_normal(n + 200)
    return lfilter([np.sqrt(1.0 - correlation**2)], [1.0, -correlation], white)[200:]


@settings(max_examples=3, deadline=None)
@given(seed=st.integers(0, 1000), size=st.floats(10.0, 100.0))
def test_it_is_the_noise_whatever_smooth_function_of_the_inputs_a_model_lacks(seed, size):
    table = sweeps()
    noise = np.random.default_rng(seed).normal(0.0, size, len(table))
    for residual in (noise, missing(table) + noise):
        assert parts_of(table, residual).floor == pytest.approx(size, rel=0.1)


@pytest.mark.parametrize("correlation", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("timed", [True, False])
def test_correlated_noise_is_noise(correlation, timed):
    """A cubic over 12 rows follows 60 % of the variance at a correlation of 0.6."""
    table, noise = sweeps(), coloured(4000, correlation)
    found = parts_of(table if timed else table.drop(columns="t"), missing(table) + 10.0 * noise)
    assert found.floor == pytest.approx(10.0, rel=0.1)


@pytest.mark.parametrize("correlation", [0.0, 0.5])
def test_noise_of_one_tire_is_no_difference_of_two(correlation):
    assert parts_of(sweeps(), coloured(4000, correlation, 1)).repeats == 0.0


def test_the_difference_of_alternating_tires_is_not_in_the_floor():
    table, noise = sweeps(), coloured(4000, 0.3, 2)
    found = parts_of(table, 10.0 * noise + 30.0 * (-1.0) ** np.arange(4000))
    assert found.floor == pytest.approx(10.0, rel=0.15)
    assert found.repeats == pytest.approx(30.0, rel=0.1)


@pytest.mark.parametrize("seed", range(4))
def test_noise_is_not_explained_by_the_rows_that_have_it(seed):
    """A regression that used the same 400 rows would explain 2 to 5 % of white noise."""
    noise = np.random.default_rng(seed).normal(0.0, 10.0, 400)
    found = parts_of(sweeps(400).drop(columns="t"), noise)
    assert found.floor == pytest.approx(np.sqrt(np.mean(noise**2)), rel=0.01)


def test_the_parts_are_plain_numbers_whose_squares_add_up_to_that_of_the_error():
    table = sweeps()
    residual = missing(table) + 10.0 * coloured(4000, 0.4) + 20.0 * np.sin(0.9 * table["t"].to_numpy() + 1.0)
    found = parts_of(table, residual)
    parts = (found.floor, found.inputs, found.time, found.repeats)
    assert {type(part) for part in parts} == {float}
    assert np.linalg.norm(parts) == pytest.approx(np.sqrt(np.mean(residual**2)))


def test_without_noise_little_of_a_smooth_function_remains():
    table = sweeps()
    assert parts_of(table, missing(table)).floor < 0.02 * missing(table).std()


def test_it_is_at_most_the_residual():
    table = sweeps()
    noise = np.random.default_rng(3).normal(0.0, 5.0, len(table))
    assert parts_of(table, noise).floor <= np.sqrt(np.mean(noise**2))


def test_a_difference_between_directions_depends_on_the_past():
    table = sweeps()
    direction = np.sign(np.cos(0.9 * table["t"].to_numpy()))
    noise = np.random.default_rng(1).normal(0.0, 5.0, len(table))
    found = parts_of(table, 60.0 * direction + noise)
    assert found.time == pytest.approx(60.0, rel=0.1)
    assert found.floor < 10.0


def test_slow_change_depends_on_time():
    table = sweeps().assign(Fz=700.0)  # loads in a sequence would be confounded with time
    noise = np.random.default_rng(1).normal(0.0, 5.0, len(table))
    fading = np.exp(-table["t"].to_numpy() / 20.0) * 80.0 * np.sin(10.0 * table["alpha"].to_numpy())
    found = parts_of(table, fading + noise)
    assert found.floor == pytest.approx(5.0, rel=0.1)
    assert found.time > 10.0


def test_the_ripple_of_a_wheel_is_in_the_floor():
    """Ten turns in a second: 2.5 turns in a piece, which no cubic follows."""
    table = sweeps()
    wave = 40.0 * np.sin(2.0 * np.pi * 10.0 * table["t"].to_numpy())
    assert parts_of(table, wave).floor == pytest.approx(40.0 / np.sqrt(2.0), rel=0.15)


def test_rows_that_are_not_used_are_ignored():
    table = sweeps()
    residual = np.random.default_rng(2).normal(0.0, 20.0, len(table))
    residual[::3] = np.nan
    assert parts_of(table, residual).floor == pytest.approx(20.0, rel=0.1)


def test_rows_that_are_absent_are_no_scatter():
    """Each stretch of rows has a residual of its own; a piece over two of them would contain the difference."""
    table = sweeps()
    residual = 50.0 * np.sin(np.arange(len(table)) // 40) + coloured(4000, 0.0, 3)
    kept = np.arange(len(table)) % 40 < 30
    found = parts_of(table[kept], residual[kept])
    assert found.floor == pytest.approx(1.0, rel=0.1)


def test_without_used_rows_it_is_unknown():
    assert np.isnan(parts_of(sweeps(30), np.full(30, np.nan)).floor)


def test_an_input_that_varies_by_its_noise_only_is_ignored():
    """Otherwise the features of such inputs hide the curve over the others."""
    table = sweeps()
    rng = np.random.default_rng(5)
    noise = rng.normal(0.0, 10.0, len(table))
    noisy = table.assign(V=16.0 + rng.normal(0.0, 0.5, len(table)), p=80e3 + rng.normal(0.0, 400.0, len(table)))
    assert parts_of(noisy, missing(table) + noise) == parts_of(table, missing(table) + noise)
