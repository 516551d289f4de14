"""Errors of the form beyond the data: nothing shows that they return, so that they grow with the distance."""

from __future__ import annotations

import numpy as np
import pandas as pd

from tirefmu.fitting.checks import ReadErrors
from tirefmu.fitting.uncertainty import Features


def test_features_grow_beyond_the_rows_only():
    loads = np.linspace(500.0, 1500.0, 200)
    features = Features.of(np.array([loads]), ["Fz"])
    inside = features.growth(np.array([[600.0, 1000.0, 1400.0]]))
    near, far, below = features.growth(np.array([[1600.0, 2000.0, 100.0]]))
    assert not inside.any()
    assert 0.0 < near < below < far


def test_read_errors_grow_in_each_direction_beyond_the_readings():
    conditions = pd.DataFrame(
        [(load, p) for load in (500.0, 1000.0, 1500.0) for p in (70e3, 83e3, 97e3)], columns=["Fz", "p"]
    )
    errors = ReadErrors.of(conditions, [0.02, -0.02, 0.01] * 3, [0.01] * 9)
    asked = pd.DataFrame({"Fz": [900.0, 1800.0, 2500.0, 900.0, 900.0], "p": [80e3, 80e3, 80e3, 110e3, 55e3]})
    between, beyond, far, hard, soft = errors.squares(asked)
    assert between < beyond < far
    assert between < min(hard, soft)


def test_between_readings_the_interval_stays_that_of_their_errors():
    loads = pd.DataFrame({"Fz": np.linspace(400.0, 2000.0, 9)})
    errors = ReadErrors.of(loads, [0.03, -0.03, 0.02, 0.0, 0.01, -0.02, 0.0, 0.03, -0.01], [0.01] * 9)
    within = errors.squares(pd.DataFrame({"Fz": np.linspace(400.0, 2000.0, 50)}))
    assert within.max() ** 0.5 < 0.05
