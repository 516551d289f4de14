"""Turn slip begins continuously, also with inclination, and acts in full on every path that is not almost straight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

CONVENTIONS = ("tno", "book")
#: Turn slip from which it acts in full, 1/m.
FULL = 1e-6


@pytest.fixture(params=["mf52", "mf61", "mf62"])
def turning(request, made):
    return made(request.param, 0)


def forces(tire, scale_of, phit, convention):
    """Return the forces at an inclination by turn slip, relative to their sizes; shape (n_forces, n)."""
    at = {"kappa": 0.02, "alpha": 0.05, "gamma": 0.1, "Fz": tire.values["FNOMIN"], "V": 20.0}
    table = pd.DataFrame({"phit": np.asarray(phit, dtype=float)}).assign(**at)
    values = tire.evaluate(table, signs=tire.signs, convention=convention)
    return values[list(tire.outputs)].to_numpy().T / scale_of(tire)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_forces_are_continuous_where_the_path_is_straight(turning, scale_of, convention):
    straight = forces(turning, scale_of, [0.0], convention)
    for size in (1e-300, 1e-15, 1e-12, 1e-9):
        near = forces(turning, scale_of, [size, -size], convention)
        assert np.max(np.abs(near - straight)) < 10.0 * (size / FULL) ** 2 + 1e-14


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_forces_go_over_steadily(turning, scale_of, convention):
    values = forces(turning, scale_of, np.linspace(-2.0, 2.0, 4001) * FULL, convention)
    # A smooth step has 1.5 times the slope of a straight line over 1000 intervals.
    assert np.all(np.abs(np.diff(values)).max(axis=1) < 3e-3 * np.ptp(values, axis=1) + 1e-12)
    assert np.ptp(values, axis=1)[1] > 1e-4  # inclination has another effect with turn slip


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_turn_slip_acts_in_full_beyond(turning, scale_of, convention):
    """From FULL on the forces change with the path only, as slowly as at any other curvature."""
    values = forces(turning, scale_of, [FULL, 2.0 * FULL, 10.0 * FULL, 100.0 * FULL], convention)
    assert np.max(np.abs(values - values[:, :1])) < 100.0 * 100.0 * FULL


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_without_the_effect_turn_slip_has_no_influence(turning, scale_of, convention):
    without = replace(turning, effects=turning.has - {"turn_slip"})
    straight, turned = forces(without, scale_of, [0.0, 0.5], convention).T
    np.testing.assert_array_equal(turned, straight)
    straight, turned = forces(turning, scale_of, [0.0, 0.5], convention).T
    assert np.max(np.abs(turned - straight)) > 1e-3
