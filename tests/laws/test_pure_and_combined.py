"""In pure slip the combined formulas are the pure ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

#: M_z0 does not contain turn slip. In MF5.2 its side force is that of the upright tire; the trail acts on all of F_y.
STRAIGHT = {"mf96": {}, "mf52": {"phit": 0.0, "gamma": 0.0}, "mf61": {"phit": 0.0}, "mf62": {"phit": 0.0}}


def evaluated(tire, rows, **fixed):
    table = pd.DataFrame(dict(zip(tire.inputs, rows, strict=True))).assign(**fixed)
    return tire.evaluate(table, signs=tire.signs)


def without_moment_arm(tire):
    return replace(tire, values={**tire.values, "SSZ1": 0.0, "SSZ2": 0.0, "SSZ3": 0.0, "SSZ4": 0.0})


def test_without_longitudinal_slip_the_side_force_is_pure(magic_tire, points):
    # MF5.2 to 6.2 combine at kappa + S_Hyk: a shift in both, of which the weight is 1.
    answer = evaluated(magic_tire, points(magic_tire), kappa=0.0)
    assert answer["Fy"].to_numpy() == pytest.approx(answer["F_y0"].to_numpy(), rel=1e-13)
    assert (answer["G_yk"] == 1).all()
    assert (answer["S_Vyk"] == 0).all()


def test_without_longitudinal_slip_and_moment_arm_the_moment_is_pure(magic_tire, points):
    answer = evaluated(without_moment_arm(magic_tire), points(magic_tire), kappa=0.0, **STRAIGHT[magic_tire.model])
    trail, residual = 1.0, 1.0
    if magic_tire.model != "mf96":
        # As in the industry's solvers: LFZO is in the trail only, one more cos(alpha') in M_zr0 only
        # (the book's 1e-6 m/s makes its quotient finite).
        trail = magic_tire.values["LFZO"]
        residual = (1 / np.cos(answer["alpha"]) + 1e-6 / answer["V"]).to_numpy()
    assert answer["trail"].to_numpy() == pytest.approx(trail * answer["trail_0"].to_numpy(), rel=1e-12)
    assert answer["M_zr"].to_numpy() == pytest.approx(residual * answer["M_zr0"].to_numpy(), rel=1e-12)
    expected = trail * (answer["M_z0"] - answer["M_zr0"]) + answer["M_zr"]
    assert answer["Mz"].to_numpy() == pytest.approx(expected.to_numpy(), rel=1e-12, abs=1e-12 * abs(expected).max())


def test_without_side_slip_the_longitudinal_force_is_pure(magic_tire, points):
    answer = evaluated(magic_tire, points(magic_tire), alpha=0.0)
    assert answer["Fx"].to_numpy() == pytest.approx(answer["F_x0"].to_numpy(), rel=1e-13)


def test_combined_slip_reduces_both_forces(magic_tire, points):
    """Otherwise the laws above would test nothing."""
    answer = evaluated(magic_tire, points(magic_tire))
    assert (abs(answer["G_xa"] - 1) > 1e-3).mean() > 0.9
    assert (abs(answer["G_yk"] - 1) > 1e-3).mean() > 0.9
    assert (abs(answer["Mz"] - answer["M_z0"]) > 1e-6 * answer["Fz"]).mean() > 0.9


# ---- Turn slip begins continuously, also with inclination, and acts in full on every path that is not almost straight


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
