"""Levels are found where a channel was held, and only there."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import find_peaks

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import level_tolerance, levels
from tirefmu.measurements.operating_conditions.levels import local_maxima, prominences_of


def test_a_tolerance_is_positive():
    with pytest.raises(DataError, match="positive tolerance"):
        levels([1.0, 2.0], tolerance=0.0)


@given(
    held=st.lists(st.integers(1, 12), min_size=1, max_size=6, unique=True),
    shares=st.lists(st.integers(1, 5), min_size=6, max_size=6),
    seed=st.integers(0, 1000),
)
def test_levels_are_found_for_any_shares(held, shares, seed):
    rng = np.random.default_rng(seed)
    true = sorted(250.0 * step for step in held)
    rows = [rng.normal(level, 25.0, 400 * share) for level, share in zip(true, shares, strict=False)]
    assert levels(np.concatenate(rows), tolerance=75.0) == pytest.approx(true, abs=8.0)


@given(st.permutations(range(200)), st.floats(-1e4, 1e4))
def test_levels_do_not_depend_on_order_and_move_with_the_data(order, shift):
    rng = np.random.default_rng(3)
    values = np.concatenate([rng.normal(0.0, 1.0, 100), rng.normal(30.0, 1.0, 100)])
    found = levels(values, tolerance=4.0)
    assert len(found) == 2
    assert levels(values[list(order)], tolerance=4.0) == found
    assert levels(values + shift, tolerance=4.0) == pytest.approx([level + shift for level in found], abs=1e-6)


def test_a_transition_is_no_level():
    ramp = np.linspace(900.0, 1800.0, 150)
    values = np.concatenate([np.full(3000, 900.0), ramp, np.full(3000, 1800.0)])
    assert levels(pd.Series(values, name="Fz")) == pytest.approx([900.0, 1800.0], abs=5.0)


def test_swept_channels_have_no_levels():
    time = np.linspace(0.0, 10.0, 20001)
    triangle = 0.2 * (2.0 / np.pi) * np.arcsin(np.sin(2.0 * np.pi * time))
    noisy = triangle + np.random.default_rng(5).normal(0.0, 3e-4, len(time))
    assert levels(pd.Series(noisy, name="alpha")) == []


@given(rows=st.integers(40, 3000), width=st.floats(0.2, 3.0))
def test_an_even_sweep_has_no_levels_for_any_step(rows, width):
    tolerance = width / 20.0
    assert levels(np.linspace(-width, width, rows), tolerance=tolerance) == []


def test_little_data():
    assert levels([]) == []
    assert levels([np.nan]) == []
    assert levels([3.0]) == [3.0]
    assert levels([0.0, 0.0]) == [0.0]


def test_tolerance_comes_from_the_columns_name():
    assert level_tolerance([-900.0, 100.0], "Fz") == pytest.approx(36.0)
    assert level_tolerance([0.1], "gamma") == pytest.approx(np.radians(0.5))


@given(values=st.lists(st.integers(0, 6), min_size=1, max_size=40))
def test_peaks_and_prominences_are_those_of_scipy(values):
    density = np.array(values, dtype=np.float64)
    peaks, properties = find_peaks(density, prominence=0.0)
    np.testing.assert_array_equal(local_maxima(density), peaks)
    np.testing.assert_array_equal(prominences_of(density, peaks), properties["prominences"])
