import itertools

import numpy as np
import pytest
from scipy.signal import lfilter

from tirefmu.numerics import autocovariance, block_sums, coloured_covariance, regression


def coloured(rng, n, memory):
    return lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], rng.standard_normal(n))


def test_omitting_a_block_is_a_regression_without_its_rows():
    rng = np.random.default_rng(0)
    columns, residual = rng.standard_normal((2, 120, 3)), rng.standard_normal((2, 120))
    edges = np.array([0, 30, 70, 120])
    fit = regression(block_sums(columns, residual, edges), np.full(3, 0.5))
    for g, (first, last) in enumerate([(0, 30), (30, 70), (70, 120)]):
        others = np.r_[0:first, last:120]
        x, y = columns[:, others].reshape(-1, 3), residual[:, others].ravel()
        expected = np.linalg.solve(x.T @ x + 0.5 * np.eye(3), x.T @ y)
        np.testing.assert_allclose(fit.others[g], expected, rtol=1e-7)
        remaining = residual[:, first:last] - columns[:, first:last] @ expected
        assert fit.loss[g] == pytest.approx(np.sum(remaining**2), rel=1e-9)


def test_the_jackknife_of_a_mean_is_its_variance():
    """The jackknife of a mean is the sample variance over the number of rows, exactly."""
    values = np.random.default_rng(4).standard_normal(30)
    fit = regression(block_sums(np.ones((1, 30, 1)), values[None], np.arange(31)), np.zeros(1))
    assert fit.estimate == pytest.approx([values.mean()], rel=1e-9)
    assert fit.jackknife[0, 0] == pytest.approx(np.var(values, ddof=1) / 30, rel=1e-7)


def test_the_covariance_of_products_with_coloured_noise_is_what_many_draws_have():
    rng = np.random.default_rng(1)
    n, memory = 400, 0.8
    trace = np.sin(np.arange(n) / 15.0)[None, :, None]
    known = memory ** np.arange(120)[None, None, :]
    expected = coloured_covariance(trace, known)[0, 0]
    draws = [trace[0, :, 0] @ coloured(rng, n, memory) for _ in range(3000)]
    # 3000 draws know a variance to 2.6 %; four deviations and the start of the filter are allowed.
    assert expected == pytest.approx(np.var(draws), rel=0.12)
    white = float(np.sum(trace**2))
    assert expected > 4.0 * white


def test_coloured_covariance_is_the_sum_over_all_pairs_of_rows_and_channels():
    """Channel d at row t and channel c at row s have the covariance (c, d) at the lag t - s, (d, c) at its negative."""
    rng = np.random.default_rng(5)
    traces, covariance = rng.standard_normal((3, 12, 2)), rng.standard_normal((3, 3, 5))
    covariance[:, :, 0] += covariance[:, :, 0].T
    expected = np.zeros((2, 2))
    for (c, s), (d, t) in itertools.product(itertools.product(range(3), range(12)), repeat=2):
        if abs(t - s) < 5:
            pair = covariance[c, d, t - s] if t >= s else covariance[d, c, s - t]
            expected += pair * np.outer(traces[d, t], traces[c, s])
    np.testing.assert_allclose(coloured_covariance(traces, covariance), expected, rtol=1e-10)


def test_autocovariance_ignores_unused_rows():
    rng = np.random.default_rng(2)
    noise = coloured(rng, 20000, 0.6)[None, :]
    present = np.ones_like(noise, dtype=bool)
    present[:, ::3] = False
    whole = autocovariance(noise, np.ones_like(present), 40)
    part = autocovariance(np.where(present, noise, 0.0), present, 40)
    np.testing.assert_allclose(part[0, 0, :5], whole[0, 0, :5], atol=0.05)
