"""Intervals of stiffness and friction follow the readings near them, and grow with the distance from them."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.fitting.checks.read_errors import MODEL_ERROR, ROUGH, ReadErrors

LOADS = np.linspace(500.0, 2500.0, 9)
NOISE = 0.03


def conditions(loads, camber=0.0):
    return pd.DataFrame({"Fz": loads, "gamma": camber, "p": 2e5})


def test_readings_narrow_the_interval_and_distance_widens_it():
    errors = ReadErrors.of(conditions(LOADS), np.zeros(9), [NOISE] * 9)
    at = np.array([1500.0, 2500.0, 3500.0, 6000.0, 20000.0])
    deviation = np.sqrt(errors.squares(conditions(at)))
    assert (np.diff(deviation) > 0.0).all()
    assert deviation[0] < NOISE
    more = ReadErrors.of(pd.concat([conditions(LOADS)] * 4), np.zeros(36), [NOISE] * 36)
    assert (more.squares(conditions(at[:2])) < errors.squares(conditions(at[:2]))).all()


def test_an_error_that_the_readings_show_is_in_the_interval():
    off = ReadErrors.of(conditions(LOADS), np.where(LOADS > 1800.0, 0.2, 0.0), [NOISE] * 9)
    near, far = np.sqrt(off.squares(conditions(np.array([2250.0, 750.0]))))
    assert near > 0.15
    assert far < 0.1
    (cambered,) = np.sqrt(off.squares(conditions(np.array([2250.0]), camber=0.5)))
    assert cambered > 0.05


def test_between_readings_their_errors_count_and_beyond_them_the_prior_of_the_form():
    """Readings that agree with the tire narrow what is between them only."""
    exact = ReadErrors.of(conditions(LOADS), np.zeros(9), [0.0] * 9)
    between, outside = np.sqrt(exact.squares(conditions(np.array([1375.0, 5000.0]))))
    assert between < 0.5 * MODEL_ERROR
    slope = np.sqrt(0.5 * (1.0 + ROUGH**-2))  # of the process, in its standard deviation per length scale
    assert outside == pytest.approx(MODEL_ERROR * slope * 2500.0 / 1000.0, rel=0.02)


def test_few_readings_say_nothing():
    assert ReadErrors.of(conditions(LOADS[:2]), [0.0, 0.0], [NOISE] * 2) is None


def test_the_intervals_contain_smooth_errors_between_readings():
    """Smooth errors, without the part that differs between levels: the intervals may be too wide."""
    rng = np.random.default_rng(0)
    dense = np.linspace(500.0, 2500.0, 41)
    kernel = np.exp(-0.5 * ((dense[:, None] - dense) / 1000.0) ** 2)
    root = np.linalg.cholesky(kernel + 1e-9 * np.eye(41))
    inside = []
    for _ in range(200):
        true = 0.05 * root @ rng.standard_normal(41)
        read = true[::5] + rng.normal(0.0, NOISE, 9)
        half = 1.96 * np.sqrt(ReadErrors.of(conditions(LOADS), read, [NOISE] * 9).squares(conditions(dense)))
        inside.append(np.mean(np.abs(true) < half))
    assert 0.9 < np.mean(inside) <= 1.0
