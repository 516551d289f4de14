"""The printed Jacobians against CasADi's differentiation and against central differences."""

from __future__ import annotations

from importlib import import_module

import casadi as ca
import numpy as np
import pytest

ROUTINES = ("jacobian_inputs", "jacobian_parameters")


def printed(tire, routine, rows, parameters):
    """Return derivatives as (n, n_forces, n_by)."""
    module = import_module(f"tirefmu.generated.numpy.{tire.model}")
    matrix = getattr(module, routine)(rows, parameters)
    return np.array([[np.broadcast_to(value, rows.shape[1]) for value in row] for row in matrix]).transpose(2, 0, 1)


def by_casadi(tire, routine, rows, parameters):
    module = import_module(f"tirefmu.generated.casadi.{tire.model}")
    x, p = ca.SX.sym("x", len(rows)), ca.SX.sym("p", len(parameters))
    jacobian = ca.jacobian(module.forces(x, p), x if routine == "jacobian_inputs" else p)
    function = ca.Function("jacobian", [x, p], [jacobian])
    return np.stack([np.array(function(point, parameters)) for point in rows.T])


def by_differences(tire, routine, rows, parameters):
    module = import_module(f"tirefmu.generated.numpy.{tire.model}")
    moved = rows if routine == "jacobian_inputs" else np.repeat(parameters[:, None], rows.shape[1], axis=1)
    columns = []
    for i, size in enumerate(np.abs(moved).max(axis=1)):
        step = np.zeros_like(moved)
        step[i] = 1e-6 * size
        ends = [
            module.forces(moved + way * step, parameters) if moved is rows else module.forces(rows, moved + way * step)
            for way in (1, -1)
        ]
        columns.append((np.stack(ends[0]) - np.stack(ends[1])) / (2e-6 * size))
    return np.stack(columns, axis=-1).transpose(1, 0, 2)


@pytest.mark.parametrize("routine", ROUTINES)
def test_the_chain_rule_is_casadis(tire, points, routine):
    rows, parameters = points(tire, n=60), tire.parameters()
    ours, theirs = (f(tire, routine, rows, parameters) for f in (printed, by_casadi))
    size = np.abs(theirs).max(axis=0)
    assert (np.abs(ours - theirs) <= 1e-13 * size).all()


@pytest.mark.parametrize("routine", ROUTINES)
def test_the_chain_rule_is_the_slope_of_the_forces(tire, points, routine):
    rows, parameters = points(tire, n=100), tire.parameters()
    ours, theirs = (f(tire, routine, rows, parameters) for f in (printed, by_differences))
    size = np.abs(theirs).max(axis=0)
    # A force is rounded at 1e-16 of its size, a few ten times over its lines; a difference over 2e-6 of the
    # argument makes 1e-9 of that. The smoothed signs bend within 1e-3 of slip: 1e-7 is their third derivative.
    inputs = dict(zip(tire.inputs, rows, strict=True))
    noise = 1e-9 * np.abs(np.stack(list(tire.forces(**inputs).values()))).max(axis=1)
    moved = np.abs(rows if routine == "jacobian_inputs" else parameters[:, None]).max(axis=1)
    assert (np.abs(ours - theirs) <= 1e-7 * size + noise[:, None] / moved).all()


def test_slip_stiffnesses_are_the_first_columns_of_the_jacobian(tire, points):
    rows, parameters = points(tire), tire.parameters()
    stiffnesses = printed(tire, "slip_stiffnesses", rows, parameters)
    np.testing.assert_array_equal(stiffnesses, printed(tire, "jacobian_inputs", rows, parameters)[:, :, :2])


def test_every_coefficient_moves_an_output(tire, points):
    """The derivative by no coefficient is zero everywhere."""
    jacobian = printed(tire, "jacobian_parameters", points(tire), tire.parameters())
    still = np.abs(jacobian).max(axis=(0, 1)) == 0
    assert [name for name, zero in zip(tire.book.coefficients, still, strict=True) if zero] == []
