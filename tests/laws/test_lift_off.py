"""Lift-off and zero slip: forces are zero or finite, without a jump; NaN is propagated."""

from __future__ import annotations

import numpy as np
import pytest

from tirefmu.tires.code import code_for

LANGUAGES = ("numpy", "c", "casadi")
#: Below this load no model has contact, N (docs/conventions.md).
LIFT_OFF = 1e-6


def with_load(tire, rows, load):
    rows = rows.copy()
    rows[tire.inputs.index("Fz")] = load
    return rows


def with_each_load(tire, rows, loads):
    return np.hstack([with_load(tire, rows, load) for load in loads])


@pytest.mark.parametrize("code", LANGUAGES)
def test_no_force_without_load(model_tire, points, code):
    rows = with_each_load(model_tire, points(model_tire, n=20), [0.0, -0.0, -1e-300, -1.0, -5000.0])
    language, parameters = code_for(model_tire.model, code), model_tire.parameters()
    assert (language.forces(rows, parameters) == 0).all()
    quantities = dict(zip(language.quantities_names, language.quantities(rows, parameters), strict=True))
    quantities.pop("c_z", None)  # load per deflection: 0 divided by 0
    assert all(np.isfinite(values).all() for values in quantities.values())


@pytest.mark.parametrize("code", LANGUAGES)
def test_jacobians_stay_finite(model_tire, points, code):
    rows, parameters = points(model_tire, n=8), model_tire.parameters()
    rows = with_each_load(model_tire, rows, [0.0, -5000.0, 1e-9, 1e-6, 2e-6])
    assert np.isfinite(code_for(model_tire.model, code).jacobian_parameters(rows, parameters)).all()
    assert np.isfinite(code_for(model_tire.model, code).jacobian_inputs(rows, parameters)).all()


@pytest.mark.parametrize("code", ["numpy", "casadi"])
def test_a_vanishing_load_gives_finite_results(model_tire, points, code):
    """With turn slip, too, where moments are divided by moments. C evaluates the same operations as NumPy."""
    loads = [5e-324, 2.5e-293, 1e-155, 1e-101, 1e-60, 0.999 * LIFT_OFF, LIFT_OFF, 1.001 * LIFT_OFF]
    rows = with_each_load(model_tire, points(model_tire, n=8), loads)
    if "phit" in model_tire.inputs:
        rows[model_tire.inputs.index("phit")] = 1.0
    language, parameters = code_for(model_tire.model, code), model_tire.parameters()
    assert np.isfinite(language.forces(rows, parameters)).all()
    assert np.isfinite(language.jacobian_inputs(rows, parameters)).all()
    assert np.isfinite(language.jacobian_parameters(rows, parameters)).all()


@pytest.mark.parametrize("code", LANGUAGES)
def test_a_load_of_nan_is_not_a_lifted_tire(tire, points, code):
    rows = with_load(tire, points(tire, n=5), np.nan)
    assert np.isnan(code_for(tire.model, code).forces(rows, tire.parameters())).all()


def test_forces_start_at_zero(magic_tire, points, forces_of):
    """No force below the load of contact. Friction is far below 100: forces at a small load are small, not zero."""
    for load in (1e-12, 0.999 * LIFT_OFF):
        assert (forces_of(magic_tire, with_load(magic_tire, points(magic_tire), load)) == 0).all()
    for load in (1.001 * LIFT_OFF, 1e-5, 1e-3, 1.0):
        forces = np.abs(forces_of(magic_tire, with_load(magic_tire, points(magic_tire), load)))
        assert (forces > 0).all()
        assert np.max(forces) < 100 * load


def test_forces_are_proportional_to_a_vanishing_load(magic_tire, points, forces_of):
    """Except M_y, which decreases faster. MF5.2 to 6.2 add 1e-6 N to divisors of stiffness: 1e-4 at these loads."""
    rows, loads, error = (
        (points(magic_tire), (1e-3, 1e-4), 1e-4)
        if magic_tire.model == "mf96"
        else (points(magic_tire), (0.1, 0.05), 1e-3)
    )
    big, small = (forces_of(magic_tire, with_load(magic_tire, rows, load)) / load for load in loads)
    proportional = [name != "My" for name in magic_tire.outputs]
    np.testing.assert_allclose(big[proportional], small[proportional], rtol=error, atol=error)
    assert all((np.abs(small[i]) < np.abs(big[i])).all() for i, it_is in enumerate(proportional) if not it_is)


@pytest.mark.parametrize("name", ["kappa", "alpha", "gamma"])
def test_no_jump_across_zero(magic_tire, points, forces_of, scale_of, name):
    """No derivative in these tires exceeds 1e5 loads (K is below 1e2, a smoothed sign has a slope of 1e3)."""
    rows, index = points(magic_tire), magic_tire.inputs.index(name)
    for other in ("kappa", "alpha", "gamma"):
        at_zero = rows.copy()
        at_zero[magic_tire.inputs.index(other)] = 0.0
        left, right = at_zero.copy(), at_zero.copy()
        left[index], right[index] = -1e-10, 1e-10
        assert np.max(np.abs(forces_of(magic_tire, right) - forces_of(magic_tire, left)) / scale_of(magic_tire)) < 2e-5


@pytest.mark.parametrize("code", LANGUAGES)
def test_zero_slip_is_finite_to_the_last_derivative(magic_tire, code):
    nominal = np.array([magic_tire.nominal(name) for name in magic_tire.inputs])
    rows = np.repeat(nominal[:, None], 3, axis=1)
    rows[magic_tire.inputs.index("Fz")] = np.array([0.5, 1.0, 2.0]) * magic_tire.values["FNOMIN"]
    assert (rows[[magic_tire.inputs.index(name) for name in ("kappa", "alpha", "gamma")]] == 0).all()
    assert np.isfinite(code_for(magic_tire.model, code).quantities(rows, magic_tire.parameters())).all()
    assert np.isfinite(code_for(magic_tire.model, code).jacobian_parameters(rows, magic_tire.parameters())).all()
