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


def test_without_longitudinal_slip_the_side_force_is_pure(tire, points):
    # MF5.2 to 6.2 combine at kappa + S_Hyk: a shift in both, of which the weight is 1.
    answer = evaluated(tire, points(tire), kappa=0.0)
    assert answer["Fy"].to_numpy() == pytest.approx(answer["F_y0"].to_numpy(), rel=1e-13)
    assert (answer["G_yk"] == 1).all()
    assert (answer["S_Vyk"] == 0).all()


def test_without_longitudinal_slip_and_moment_arm_the_moment_is_pure(tire, points):
    answer = evaluated(without_moment_arm(tire), points(tire), kappa=0.0, **STRAIGHT[tire.model])
    trail, residual = 1.0, 1.0
    if tire.model != "mf96":
        # As in the industry's solvers: LFZO is in the trail only, one more cos(alpha') in M_zr0 only
        # (the book's 1e-6 m/s makes its quotient finite).
        trail = tire.values["LFZO"]
        residual = (1 / np.cos(answer["alpha"]) + 1e-6 / answer["V"]).to_numpy()
    assert answer["trail"].to_numpy() == pytest.approx(trail * answer["trail_0"].to_numpy(), rel=1e-12)
    assert answer["M_zr"].to_numpy() == pytest.approx(residual * answer["M_zr0"].to_numpy(), rel=1e-12)
    expected = trail * (answer["M_z0"] - answer["M_zr0"]) + answer["M_zr"]
    assert answer["Mz"].to_numpy() == pytest.approx(expected.to_numpy(), rel=1e-12, abs=1e-12 * abs(expected).max())


def test_without_side_slip_the_longitudinal_force_is_pure(tire, points):
    answer = evaluated(tire, points(tire), alpha=0.0)
    assert answer["Fx"].to_numpy() == pytest.approx(answer["F_x0"].to_numpy(), rel=1e-13)


def test_combined_slip_reduces_both_forces(tire, points):
    """Otherwise the laws above would test nothing."""
    answer = evaluated(tire, points(tire))
    assert (abs(answer["G_xa"] - 1) > 1e-3).mean() > 0.9
    assert (abs(answer["G_yk"] - 1) > 1e-3).mean() > 0.9
    assert (abs(answer["Mz"] - answer["M_z0"]) > 1e-6 * answer["Fz"]).mean() > 0.9
