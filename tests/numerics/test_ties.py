"""Ties are decided by a declared order: what is said of a table does not depend on the last digits of its numbers."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.measurements import Recording, column_notes
from tirefmu.measurements.checks.columns.explanation import explanation
from tirefmu.numerics import BITS, graded

ALPHA = np.linspace(-0.2, 0.2, 99)
KAPPA = np.linspace(-0.25, 0.25, 99)
SIDE, ALONG = 900.0 * np.tanh(15.0 * ALPHA), 900.0 * np.tanh(18.0 * KAPPA)
BOTH = {
    "alpha": np.r_[ALPHA, 0.0 * KAPPA], "kappa": np.r_[0.0 * ALPHA, KAPPA], "Fz": 900.0,
    "Fy": np.r_[SIDE, 0.0 * KAPPA], "Fx": np.r_[0.0 * ALPHA, ALONG],
}  # fmt: skip
#: Tables with a fault that several readings explain equally well, in ISO.
AMBIGUOUS = {
    "sign of a force or of its slip": {"alpha": ALPHA, "Fz": 900.0, "Fy": SIDE},
    "both": {**BOTH, "Fx": -BOTH["Fx"]},
    "sign and unit": {"alpha": np.degrees(ALPHA) / 10.0, "Fz": 900.0, "Fy": 4.448 * SIDE},
    "camber": {
        "alpha": np.tile(ALPHA, 2), "gamma": np.repeat([0.0, 0.07], 99), "Fz": 900.0,
        "Fy": np.r_[-SIDE, -SIDE - 40.0],
    },
}  # fmt: skip


def other_last_digits(table, seed):
    """Return a table with every number changed by a relative 2e-16 to 6e-16, up or down."""
    rng = np.random.default_rng(seed)
    return table * (1.0 + 2.0**-52 * rng.integers(-2, 3, table.shape))


@pytest.mark.parametrize("name", AMBIGUOUS)
def test_the_last_digits_of_a_table_do_not_change_what_is_said_of_its_columns(name):
    table = pd.DataFrame(AMBIGUOUS[name])
    notes = column_notes(Recording(table, "iso", "a.csv"))
    for seed in range(5):
        assert column_notes(Recording(other_last_digits(table, seed), "iso", "a.csv")) == notes


def test_equal_readings_are_listed_in_the_order_of_the_channels():
    table = pd.DataFrame(AMBIGUOUS["sign of a force or of its slip"])
    better = explanation(Recording(table, "iso", "a.csv")).better
    assert [list(reading.hypothesis.interpretation.columns) for reading in better] == [[], ["alpha"], ["Fy"]]


def test_graded_scores_are_equal_below_the_resolution_only():
    rng = np.random.default_rng(3)
    for score in (*rng.integers(-40, 40, 30) / 4.0, *(10.0 ** rng.integers(-8, 9, 30))):
        assert graded(score * (1.0 + 1e-14)) == graded(score)
        assert graded(score) == pytest.approx(score, rel=2.0**-BITS, abs=0.0)
    assert graded(1.0 + 2.0 ** (2 - BITS)) > graded(1.0)


def test_infinite_and_undefined_scores_stay_what_they_are():
    scores = np.array([np.nan, np.inf, -np.inf, 0.0, -2.5])
    np.testing.assert_array_equal(graded(scores), scores)
