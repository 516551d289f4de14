"""Memory, drift and the order of a program are no reason to doubt a column; a mirrored camber is."""

from __future__ import annotations

from itertools import product

import numpy as np
import pandas as pd
import pytest

from tirefmu.measurements import Recording, column_notes

UP = np.linspace(-0.15, 0.15, 160)
HALF = np.linspace(0.0, 0.15, 120)
SWEEPS = {
    "one way": (UP, UP), "alternating": (UP, -UP), "halves": (HALF, -HALF),
    "there and back": (np.concatenate([UP, -UP]), np.concatenate([UP, -UP])),
}  # fmt: skip
CAMBERS = {"rising": (0.0, 2.0, 4.0), "falling": (4.0, 2.0, 0.0), "both sides": (-4.0, -2.0, 0.0, 2.0, 4.0)}


def recording(effect: str, size: float, thrust: float, sweep: str, cambers: str) -> Recording:
    """Return sweeps of a truck tire of a simple formula, with an effect of a size in shares of the load."""
    random = np.random.default_rng(1)
    rows, state, before, count = [], 0.0, None, 0
    for load in (1e4, 2e4, 2.6e4):
        for number, camber in enumerate(np.radians(CAMBERS[cambers])):
            for alpha in SWEEPS[sweep][number % 2]:
                change = 0.0 if before is None else alpha - before
                state += (1.0 - np.exp(-abs(change) / 0.01)) * (np.sign(change) - state)
                before, count = alpha, count + 1
                share = -0.8 * np.tanh(8.1 * alpha) - 6.5 * thrust * camber + random.normal(0.0, 0.004)
                share += {"memory": -size * state, "drift": size * count / 1500.0, "none": 0.0}[effect]
                rows.append((0.02 * count, alpha, camber, load, load * share))
    return Recording(pd.DataFrame(rows, columns=["t", "alpha", "gamma", "Fz", "Fy"]), "iso", "a.csv")


@pytest.mark.parametrize("effect", ["memory", "drift"])
@pytest.mark.parametrize(("sweep", "cambers"), [*product(SWEEPS, CAMBERS)])
def test_a_tire_with_memory_or_drift_is_not_refused(effect, sweep, cambers):
    for thrust in (0.02, 0.12):
        assert column_notes(recording(effect, 0.03, thrust, sweep, cambers)) == []


@pytest.mark.parametrize("sweep", ["one way", "there and back"])
def test_a_mirrored_camber_is_refused_in_spite_of_memory(sweep):
    made = recording("memory", 0.03, 0.12, sweep, "both sides")
    mirrored = Recording(made.table.assign(gamma=-made.table["gamma"]), "iso", "a.csv")
    assert "--columns gamma=-gamma" in column_notes(mirrored)[0]
