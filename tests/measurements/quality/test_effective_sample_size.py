"""Correlation length and effective sample size: correlated and repeated rows contain less information."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from tirefmu.measurements import correlation_length, effective_sample_size
from tirefmu.symbolic.errors import DataError


def autoregressive(rho, rows, seed):
    """Return stationary noise of standard deviation 1 with correlation rho of adjacent rows."""
    white = np.random.default_rng(seed).standard_normal(rows)
    white[1:] *= np.sqrt(1.0 - rho**2)
    return lfilter([1.0], [1.0, -rho], white)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8, 0.95])
def test_correlation_length_of_autoregressive_noise(rho):
    true = (1.0 + rho) / (1.0 - rho)
    rows = 200_000
    # Madras and Sokal (1988): relative deviation sqrt(2 (2 M + 1)/rows) if the sums end at about M = 5 lengths.
    deviation = np.sqrt(2.0 * (10.0 * true + 1.0) / rows)
    assert correlation_length(autoregressive(rho, rows, 7)) == pytest.approx(true, rel=4.0 * deviation)


def test_the_variance_of_a_mean_of_correlated_rows_follows_from_the_effective_sample_size():
    rows, rho, seeds = 4000, 0.9, 300
    noise = [autoregressive(rho, rows, seed) for seed in range(seeds)]
    scatter = np.var([values.mean() for values in noise])
    expected = np.mean([1.0 / effective_sample_size(values) for values in noise])
    # The standard deviation of a variance of 300 draws is sqrt(2/300) = 8 %.
    assert expected == pytest.approx(scatter, rel=4.0 * np.sqrt(2.0 / seeds))


@pytest.mark.parametrize("times", [2, 5, 20])
def test_repeated_rows_count_once(times):
    noise = np.random.default_rng(3).standard_normal(50_000)
    assert effective_sample_size(np.repeat(noise, times)) == pytest.approx(len(noise), rel=0.1)


@given(
    values=st.lists(st.floats(-1e3, 1e3).filter(lambda value: abs(value) > 1e-3), min_size=1, max_size=60),
    scale=st.sampled_from([-4.0, 0.25, 1024.0]),
)
def test_scale_and_sign_have_no_influence_and_sizes_are_within_bounds(values, scale):
    length = correlation_length(values)
    assert length >= 1.0
    assert effective_sample_size(values) <= len(values)
    assert correlation_length(scale * np.array(values)) == pytest.approx(length, rel=1e-9)


def test_pairs_do_not_span_segments():
    sweeps = np.repeat(np.random.default_rng(1).standard_normal(400), 25)
    single = [slice(row, row + 1) for row in range(len(sweeps))]
    assert correlation_length(sweeps, single) == 1.0
    assert correlation_length(sweeps, [slice(k, k + 25) for k in range(0, len(sweeps), 25)]) > 20.0


def test_rows_that_were_not_measured_do_not_count():
    noise = autoregressive(0.8, 100_000, 5)
    holes = np.where(np.random.default_rng(6).random(len(noise)) < 0.3, np.nan, noise)
    assert correlation_length(holes) == pytest.approx(correlation_length(noise), rel=0.1)
    assert effective_sample_size(holes) < 0.8 * effective_sample_size(noise)


def test_a_sweep_with_a_constant_error_counts_as_one_row():
    offsets = np.repeat([1.0, -1.0, 1.0, -1.0], 500)
    segments = [slice(500 * k, 500 * (k + 1)) for k in range(4)]
    assert effective_sample_size(offsets, segments) < 8.0


def test_no_finite_residual():
    with pytest.raises(DataError, match="no residual is finite"):
        correlation_length([np.nan])
