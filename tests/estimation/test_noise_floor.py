"""The noise floor on synthetic data with known noise."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tirefmu.estimation.noise_floor import noise_floor


def sweeps(seed, noise, *, hysteresis=0.0, n=6000):
    """Return up and down sweeps at three loads, twice, as a smooth force with noise, offset by direction."""
    rng = np.random.default_rng(seed)
    phase = np.linspace(0, 4 * np.pi, n // 3)
    alpha = np.tile(0.2 * np.sin(phase), 3)
    load = np.repeat([300.0, 700.0, 1100.0], n // 3) + rng.normal(0, 5.0, n)
    force = 2.0 * load * np.sin(1.4 * np.arctan(9.0 * alpha)) + hysteresis * np.sign(np.tile(np.cos(phase), 3))
    return pd.DataFrame({"alpha": alpha, "Fz": load, "Fy": force + rng.normal(0, noise, n)})


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 1000), noise=st.floats(30.0, 200.0))
def test_it_is_the_noise(seed, noise):
    floor, share = noise_floor(sweeps(seed, noise), ["Fy"])["Fy"]
    assert floor == pytest.approx(noise, rel=0.1)
    assert share > 0.95


def test_differences_between_directions_are_part_of_the_floor():
    assert noise_floor(sweeps(0, 1.0, hysteresis=80.0), ["Fy"])["Fy"][0] == pytest.approx(80.0, rel=0.15)


def test_without_noise_the_floor_is_small():
    table = sweeps(0, 0.0)
    assert noise_floor(table, ["Fy"])["Fy"][0] < 0.02 * table["Fy"].std()


def test_without_repeated_conditions_the_floor_is_nan():
    rng = np.random.default_rng(0)
    n = 300
    table = pd.DataFrame({name: rng.uniform(-1, 1, n) for name in ("kappa", "alpha", "gamma", "Fz")})
    floor, share = noise_floor(table.assign(Fy=rng.normal(size=n)), ["Fy"])["Fy"]
    assert np.isnan(floor)
    assert share == 0.0


def test_missing_values_are_ignored():
    table = sweeps(0, 50.0)
    holes = table.assign(Fy=table["Fy"].where(np.arange(len(table)) % 3 > 0))
    floor, share = noise_floor(holes, ["Fy"])["Fy"]
    assert floor == pytest.approx(50.0, rel=0.1)
    assert 0.5 < share <= 1.0


def test_a_plane_through_few_rows_does_not_hide_their_noise():
    """Six rows per cell and a plane with two coefficients leave four degrees of freedom for the variance."""
    alpha = np.linspace(-0.2, 0.2, 120)
    rng = np.random.default_rng(0)
    tables = [pd.DataFrame({"alpha": alpha, "Fy": rng.normal(size=120)}) for _ in range(50)]
    squares = [noise_floor(table, ["Fy"])["Fy"][0] ** 2 for table in tables]
    assert np.mean(squares) == pytest.approx(1.0, abs=0.1)  # 4000 free rows know a variance to 2 %
