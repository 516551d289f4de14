"""The covariance of weighted sums of correlated noise, of which the rows are added a part at a time."""

from __future__ import annotations

import numpy as np
import pytest

from tirefmu.fitting.uncertainty import CorrelatedSums, NoiseCorrelation

SEGMENT = np.repeat(np.arange(12), [50, 1, 40, 60, 9, 100, 40, 70, 30, 50, 20, 30])
WEIGHTS = np.random.default_rng(0).normal(size=(4, len(SEGMENT)))


def by_the_matrix(noise):
    """Return the covariance from the matrix of all correlations."""
    number = np.arange(len(SEGMENT))
    lag = np.abs(np.subtract.outer(number, number))
    matrix = np.where(np.equal.outer(SEGMENT, SEGMENT), noise.share * noise.decay**lag, 0.0)
    np.fill_diagonal(matrix, 1.0)
    return WEIGHTS @ matrix @ WEIGHTS.T


@pytest.mark.parametrize(
    "noise", [NoiseCorrelation(0.6, 0.9), NoiseCorrelation(1.0, 0.998), NoiseCorrelation(0.0, 0.0)]
)
@pytest.mark.parametrize("size", [1, 33, 50, 1000])
def test_the_parts_are_correlated_with_each_other(noise, size):
    sums = CorrelatedSums(noise, len(WEIGHTS))
    for start in range(0, len(SEGMENT), size):
        rows = slice(start, start + size)
        sums.add(WEIGHTS[:, rows].copy(), SEGMENT[rows])
    np.testing.assert_allclose(sums.covariance, by_the_matrix(noise), rtol=1e-11, atol=1e-9)


def test_the_last_row_of_a_segment_is_no_neighbor_of_the_next_one():
    """Segments with equal residuals of either sign: their rows agree within a segment, and never across two."""
    residual, segment = np.array([1.0, 1.0, -1.0, -1.0, 1.0, 1.0]), np.array([0, 0, 1, 1, 2, 2])
    # Three pairs of neighbors of six rows: share * decay = 1/2, and 3 = 1 + 2 share decay / (1 - decay).
    found = NoiseCorrelation.of(residual, segment, 3.0)
    assert found.share * found.decay == pytest.approx(0.5)
    assert found.decay == pytest.approx(0.5)


def test_weights_stay_as_they_are():
    before = WEIGHTS.copy()
    NoiseCorrelation(0.6, 0.9).covariance(WEIGHTS, SEGMENT)
    np.testing.assert_array_equal(WEIGHTS, before)
