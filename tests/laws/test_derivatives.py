"""The printed Jacobians against CasADi's differentiation and against central differences."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np
import pytest

from tirefmu.symbolic.model.lines import reaching
from tirefmu.tires.code import code_for
from tirefmu.tires.code.casadi_code import casadi_expression

ROUTINES = ("jacobian_inputs", "jacobian_parameters")


def printed(tire, routine, rows, parameters):
    """Return derivatives as (n, n_forces, n_by)."""
    return getattr(code_for(tire.symbolic_model, "numpy"), routine)(rows, parameters)


@cache
def differentiated(model, routine):
    """Return the Jacobian that CasADi derives from the forces, as a function of inputs and parameters."""
    x, p = ca.SX.sym("x", len(model.inputs)), ca.SX.sym("p", len(model.parameters))
    jacobian = ca.jacobian(casadi_expression(model, "forces", x, p), x if routine == "jacobian_inputs" else p)
    return ca.Function("jacobian", [x, p], [jacobian])


def by_casadi(tire, routine, rows, parameters):
    function = differentiated(tire.symbolic_model, routine)
    full = np.stack([np.array(function(point, parameters)) for point in rows.T])
    return full if routine == "jacobian_inputs" else full[:, :, : len(tire.symbolic_model.coefficients)]


#: Relative step of a difference; the smoothed signs of MF96 turn within 1e-3 of slip, and this is 1e-5 of the slip.
STEP = 1e-5
#: Weights of a difference of the fourth order, by steps.
WEIGHTS = {1: 8 / 12, -1: -8 / 12, 2: -1 / 12, -2: 1 / 12}
#: A force is rounded to 1e-16 of its size, some ten times over a hundred lines.
ROUNDING = 1e-14


def forces_at(tire, rows, parameters):
    return code_for(tire.symbolic_model, "numpy").forces(rows, parameters)


def by_differences(tire, routine, rows, parameters):
    by_inputs = routine == "jacobian_inputs"
    moved = rows if by_inputs else parameters[: len(tire.symbolic_model.coefficients), None]
    columns = []
    for i, size in enumerate(np.abs(moved).max(axis=1)):
        slope = 0.0
        for steps, weight in WEIGHTS.items():
            r, p = rows.copy(), parameters.copy()
            (r if by_inputs else p)[i] += steps * STEP * size
            slope = slope + weight * forces_at(tire, r, p) / (STEP * size)
        columns.append(slope)
    return np.stack(columns, axis=-1).transpose(1, 0, 2)


def rounding_of(tire, routine, rows, parameters, n_by):
    """Return the rounding of the force per argument, below which a derivative is indistinguishable from 0.

    A derivative may be a small difference of large terms (Mz by PHYP1: terms of the trail and of the arm of Fx), so
    that its size does not determine its rounding.
    """
    moved = rows if routine == "jacobian_inputs" else parameters[:n_by, None]
    forces = np.abs(forces_at(tire, rows, parameters)).max(axis=1)
    return ROUNDING * forces[:, None] / np.abs(moved).max(axis=1)


@pytest.mark.parametrize("routine", ROUTINES)
def test_the_chain_rule_is_casadis(tire, points, routine):
    rows, parameters = points(tire, n=60), tire.parameters()
    ours, theirs = (f(tire, routine, rows, parameters) for f in (printed, by_casadi))
    rounding = rounding_of(tire, routine, rows, parameters, ours.shape[2])
    # The same numbers in another order: rounding over some hundred products.
    assert (np.abs(ours - theirs) <= 1e-11 * np.abs(theirs).max(axis=0) + rounding).all()


@pytest.mark.parametrize("routine", ROUTINES)
def test_the_chain_rule_is_the_slope_of_the_forces(model_tire, points, routine):
    rows, parameters = points(model_tire, n=100), model_tire.parameters()
    if "phit" in model_tire.inputs:  # turn slip starts with a jump: a difference across it is not a slope
        rows = rows[:, rows[model_tire.inputs.index("phit")] != 0]
    ours, theirs = (f(model_tire, routine, rows, parameters) for f in (printed, by_differences))
    noise = rounding_of(model_tire, routine, rows, parameters, ours.shape[2]) / STEP
    # The remainder of the fifth derivative: a bend within 1e-3 of slip over steps of 1e-5, to the fourth, is 1e-8.
    assert (np.abs(ours - theirs) <= 1e-7 * np.abs(theirs).max(axis=0) + noise).all()


def test_every_coefficient_that_leads_to_a_force_moves_one(tire, points):
    """No such derivative is zero everywhere, with any option. Limits have an influence outside the ranges only."""
    moved = np.zeros(len(tire.symbolic_model.coefficients))
    crawling = np.array([[0.02 if name == "V" else 1.0] for name in tire.inputs])
    for convention in ("tno", "book"):
        for speed in (1.0, crawling):
            parameters = tire.parameters(convention=convention)
            jacobian = printed(tire, "jacobian_parameters", points(tire) * speed, parameters)
            moved = np.maximum(moved, np.abs(jacobian).max(axis=(0, 1)))
    leading = {
        str(s) for line in reaching(tire.symbolic_model.lines(), tire.outputs) for s in line.expression.free_symbols
    }
    declarations = tire.symbolic_model.coefficients
    expected = [name in leading and not declarations[name].section.endswith("_RANGE") for name in declarations]
    assert [name for name, zero, it_is in zip(declarations, moved == 0, expected, strict=True) if it_is and zero] == []
