"""Slopes at zero slip: the standard error is that of repeated measurements, and a hole near zero is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from tirefmu.numerics import read_slope

WINDOW = 0.035


def sweep(stiffness, n=200):
    """Return a slip that is swept up and down, and the force of a tire with this stiffness."""
    half = np.linspace(-0.1, 0.1, n)
    slip = np.concatenate([half, half[::-1]])
    return slip, 1000.0 * np.tanh(stiffness / 1000.0 * slip)


@pytest.mark.parametrize("correlation", [0.0, 0.8, 0.9])
def test_the_standard_error_is_the_scatter_of_repeated_measurements(correlation):
    """With the largest correlation, a pass of 70 rows has the information of four."""
    slip, force = sweep(2e4)
    rng, found = np.random.default_rng(3), []
    for _ in range(200):
        white = rng.normal(0.0, 20.0, 200 + len(slip))
        noise = lfilter([np.sqrt(1.0 - correlation**2)], [1.0, -correlation], white)[200:]
        found.append(read_slope(slip, force + noise, WINDOW))
    values, errors = (np.array([getattr(each, name) for each in found]) for name in ("value", "error"))
    covered = np.mean(np.abs(values - 2e4) < 2.0 * errors)
    assert 0.92 <= covered < 1.0
    assert 0.9 < np.median(errors) / np.std(values) < 1.2  # the larger of two estimates is above by a tenth


@pytest.mark.parametrize("hole", [(-0.0175, 0.0175), (0.0, 0.0175), (-0.035, 0.0)])
def test_a_slope_is_refused_without_rows_near_zero_slip(hole):
    slip, force = sweep(2e4)
    rows = (slip < hole[0]) | (slip > hole[1])
    assert np.isnan(read_slope(slip[rows], force[rows], WINDOW).value)
