"""The correlation length on noise of known correlation: the study behind the choice of the estimator."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from tirefmu.boundary.errors import DataError
from tirefmu.numerics import correlation_length, effective_sample_size


def autoregressive(rho, rows, seed):
    """Return noise of deviation 1 whose neighbors correlate by rho; stationary from the first row."""
    fresh = np.random.default_rng(seed).standard_normal(rows)
    fresh[1:] *= np.sqrt(1.0 - rho**2)
    return lfilter([1.0], [1.0, -rho], fresh)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8, 0.95])
def test_correlation_length_of_autoregressive_noise(rho):
    true = (1.0 + rho) / (1.0 - rho)
    rows = 200_000
    # Madras and Sokal (1988): relative deviation sqrt(2 (2 M + 1)/rows), the sums being cut at about M = 5 lengths.
    deviation = np.sqrt(2.0 * (10.0 * true + 1.0) / rows)
    found = correlation_length(autoregressive(rho, rows, 7)) / true
    # The longest of four estimates; that from the fewest sums is known to 8 %.
    assert 1.0 - 4.0 * deviation < found < 1.0 + max(4.0 * deviation, 0.17)


def test_the_effective_sample_size_predicts_the_variance_of_a_mean():
    rows, rho, seeds = 4000, 0.9, 300
    noise = [autoregressive(rho, rows, seed) for seed in range(seeds)]
    scatter = np.var([values.mean() for values in noise])
    expected = np.mean([1.0 / effective_sample_size(values) for values in noise])
    # A variance of 300 draws deviates by sqrt(2/300) = 8 %.
    assert expected == pytest.approx(scatter, rel=4.0 * np.sqrt(2.0 / seeds))


@pytest.mark.parametrize("times", [2, 5, 20])
def test_repeated_rows_count_once(times):
    noise = np.random.default_rng(3).standard_normal(50_000)
    assert 0.83 * len(noise) < effective_sample_size(np.repeat(noise, times)) < 1.1 * len(noise)


@given(
    values=st.lists(st.floats(-1e3, 1e3).filter(lambda value: abs(value) > 1e-3), min_size=1, max_size=60),
    scale=st.sampled_from([-4.0, 0.25, 1024.0]),
)
def test_scale_and_sign_do_not_matter_and_sizes_stay_in_bounds(values, scale):
    length = correlation_length(values)
    assert length >= 1.0
    assert effective_sample_size(values) <= len(values)
    assert correlation_length(scale * np.array(values)) == pytest.approx(length, rel=1e-9)


def test_pairs_do_not_span_segments():
    sweeps = np.repeat(np.random.default_rng(1).standard_normal(400), 25)
    rows = np.arange(len(sweeps))
    assert correlation_length(sweeps, rows) == 1.0
    assert correlation_length(sweeps, rows // 25) > 20.0


def test_rows_that_were_not_measured_do_not_count():
    noise = autoregressive(0.8, 100_000, 5)
    holes = np.where(np.random.default_rng(6).random(len(noise)) < 0.3, np.nan, noise)
    assert correlation_length(holes) == pytest.approx(correlation_length(noise), rel=0.15)
    assert effective_sample_size(holes) < 0.8 * effective_sample_size(noise)


def test_a_constant_error_of_a_sweep_counts_as_one_row():
    offsets = np.repeat([1.0, -1.0, 1.0, -1.0], 500)
    assert effective_sample_size(offsets, np.arange(2000) // 500) < 8.0


def test_no_finite_residual_is_an_error():
    with pytest.raises(DataError, match="no residual is finite"):
        correlation_length([np.nan])


# ------------------------------------------------------------------ the study: noise of a bench


def log_error(make, true, rows, seeds=12):
    """Return the root mean square of ln(estimated / true) over seeds."""
    found = [correlation_length(make(np.random.default_rng(seed), rows)) for seed in range(seeds)]
    return float(np.sqrt(np.mean(np.log(np.array(found) / true) ** 2)))


def faded(rng, rows, rho):
    return autoregressive(rho, rows, rng.integers(2**32))


@pytest.mark.parametrize(
    ("rows", "rho", "most"), [(2000, 0.9, 0.5), (2000, 0.995, 1.2), (20_000, 0.98, 0.45), (20_000, 0.995, 0.6)]
)
def test_the_length_of_slow_noise_is_not_underestimated(rows, rho, most):
    """Variances of sums over 64 and more batches have errors of 0.7, 3.2, 0.2 and 0.8 in these cases."""
    assert log_error(lambda rng, n: faded(rng, n, rho), (1.0 + rho) / (1.0 - rho), rows) < most


def test_a_slow_drift_below_short_noise_counts():
    """A fifth of the variance is drift: the correlation length is that of the mixture, 83 rows."""

    def mixture(rng, rows):
        return np.sqrt(0.8) * faded(rng, rows, 0.6) + np.sqrt(0.2) * faded(rng, rows, 0.995)

    true = 0.8 * (1.6 / 0.4) + 0.2 * (1.995 / 0.005)
    assert log_error(mixture, true, 20_000) < 0.7


def test_a_ripple_does_not_hide_the_noise_below_it():
    """Sums of autocovariances of rows end within a quarter of a revolution: their error is 0.35."""

    def mixture(rng, rows):
        wave = np.cos(2.0 * np.pi * np.arange(rows) / 7.3 + rng.uniform(0.0, 6.0))
        return np.sqrt(0.8) * faded(rng, rows, 0.9) + np.sqrt(0.4) * wave

    assert log_error(mixture, 0.8 * 19.0, 20_000) < 0.25


def test_the_correlation_length_of_a_ripple_is_at_most_a_third_of_a_revolution():
    """The sum of a cosine's autocorrelation up to its first zero is a period over 2 pi on either side."""
    for period in (7.3, 12.3, 40.0):
        wave = np.cos(2.0 * np.pi * np.arange(20_000) / period)
        assert 1.0 <= correlation_length(wave) <= period / 3.0 + 1.0


def test_noise_of_unbounded_memory_has_no_length():
    """For random walks the estimated correlation length increases with the duration of the recording."""
    walks = [np.cumsum(np.random.default_rng(seed).standard_normal(16_000)) for seed in range(10)]
    short, whole = (np.median([correlation_length(walk[:rows]) for walk in walks]) for rows in (1000, 16_000))
    assert whole > 4.0 * short


def test_a_residual_of_zero_and_segments_in_another_order():
    noise = autoregressive(0.8, 4000, 2)
    segment = np.arange(4000) // 500
    blocks = noise.reshape(8, 500)[::-1].ravel()
    assert correlation_length(np.zeros(500), np.zeros(500, dtype=int)) == 1.0
    assert correlation_length(blocks, segment[::-1]) == pytest.approx(correlation_length(noise, segment), rel=1e-9)
