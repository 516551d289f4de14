"""Constraints for the solver: exact derivatives, only quantities that a free coefficient influences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tirefmu.fitting.constraints import Constraint, ConstraintFunctions, declared_constraints, grid, measured_values
from tirefmu.fitting.problem import Problem, Rows
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire
from tirefmu.tires.code import code_for

RANGES = {
    "kappa": (-0.2, 0.2), "alpha": (-0.15, 0.15), "gamma": (0.0, 0.06), "Fz": (500.0, 2500.0), "p": (7e4, 1e5),
    "V": (11.0, 11.0), "phit": (0.0, 0.0),
}  # fmt: skip
FORCES = {"Fx", "Fy", "Mz"}


def problem_of(model, free=None):
    symbolic_model = MODELS[model]
    rng = np.random.default_rng(4)
    values = {"FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25, "NOMPRES": 8.5e4}
    fitted = [
        name
        for name, declaration in symbolic_model.coefficients.items()
        if declaration.fitted and FORCES & set(declaration.channels)
    ]
    for name in fitted:
        declaration = symbolic_model.coefficients[name]
        bound = declaration.upper if rng.random() < 0.5 else declaration.lower
        values[name] = declaration.generic + 0.05 * rng.random() * (bound - declaration.generic)
    values = {name: value for name, value in values.items() if name in symbolic_model.coefficients}
    tire = Tire(model, values, signs="adapted-sae")
    free = tuple(free or fitted)
    outputs = len(symbolic_model.outputs)
    rows = Rows(np.ones((len(symbolic_model.inputs), 1)), np.ones((1, outputs)), np.zeros(1, dtype=int))
    return Problem(tire, rows, free, np.ones((1, outputs)), rng.uniform(0.1, 3.0, len(free)))


def constraints(model):
    ranges = {quantity.name: RANGES[quantity.name] for quantity in MODELS[model].inputs}
    nominal = {"Fz": 1500.0, "p": 8.5e4, "V": 11.0}
    every = [constraint for channel in declared_constraints(model).values() for constraint in channel]
    return [(constraint, grid(constraint, ranges, nominal, density=0)) for constraint in every]


@pytest.mark.parametrize("model", MODELS)
def test_values_are_the_quantities_of_the_book(model):
    problem, every = problem_of(model), constraints(model)
    imposed, x = (
        ConstraintFunctions(problem, every),
        np.array([problem.tire.values[n] for n in problem.free]) / problem.scale,
    )
    code = code_for(model, "numpy")

    def value(constraint, points):
        index = code.quantities_names.index(constraint.quantity)
        return code.quantities(points, problem.parameters(x))[index]

    def expected_of(constraint, points):
        q = value(constraint, points)
        if constraint.measure == "value":
            return q / constraint.size
        load = [quantity.name for quantity in MODELS[model].inputs].index("Fz")
        step = 1e-4 * points[load]
        away = step * (np.arange(len(points)) == load)[:, None]
        growth = points[load] * (value(constraint, points + away) - value(constraint, points - away)) / (2 * step)
        return (growth if constraint.measure == "growth" else growth - q) / constraint.size

    expected = [expected_of(constraint, points) for constraint, points in every]
    assert len(imposed) == sum(points.shape[1] for _, points in every)
    ends = np.cumsum([points.shape[1] for _, points in every])
    for (constraint, points), one, within in zip(every, expected, np.split(imposed.values(x), ends[:-1]), strict=True):
        measured = (
            measured_values(problem.tire.symbolic_model, constraint, points, problem.parameters(x)) / constraint.size
        )
        differenced = constraint.measure != "value"
        exactly = {"rtol": 1e-5, "atol": 1e-8} if differenced else {"rtol": 1e-9, "atol": 1e-12}
        np.testing.assert_allclose(measured, one, **exactly, err_msg=constraint.name)
        np.testing.assert_allclose(within, one, **exactly, err_msg=constraint.name)


@pytest.mark.parametrize("model", MODELS)
def test_the_jacobian_is_that_of_the_values(model):
    problem = problem_of(model)
    imposed, x = (
        ConstraintFunctions(problem, constraints(model)),
        np.array([problem.tire.values[n] for n in problem.free]),
    )
    x = x / problem.scale
    jacobian = np.array(imposed.jacobian(x).full())
    assert jacobian.shape == (len(imposed), len(x))
    step = 1e-6
    for column in range(len(x)):
        away = np.zeros(len(x))
        away[column] = step * max(1.0, abs(x[column]))
        slope = (imposed.values(x + away) - imposed.values(x - away)) / (2 * away[column])
        size = 1e-5 * (1.0 + np.abs(slope).max())
        np.testing.assert_allclose(jacobian[:, column], slope, rtol=1e-4, atol=size, err_msg=problem.free[column])


def test_constraints_without_a_free_coefficient_are_omitted():
    problem = problem_of("mf61", free=("PDX1", "PDX2"))
    every = constraints("mf61")
    imposed = ConstraintFunctions(problem, every)
    reached = [(c, points.shape[1]) for c, points in every if c.quantity in ("mu_x", "B_x")]
    assert len(imposed) == sum(n for _, n in reached)
    # How friction grows with load depends on PDX2 alone.
    assert imposed.sparsity.nnz() == sum(n * (1 if c.measure == "growth" else 2) for c, n in reached)
    assert len(ConstraintFunctions(problem, [])) == 0


def test_constraints_without_influence_at_the_fixed_values_are_omitted():
    """If friction does not depend on load, its constraint has rows of zeros, which would stop the solver."""
    problem = problem_of("mf61", free=("PDX1", "PPX3", "PDX3"))
    problem.tire = replace(problem.tire, values={**problem.tire.values, "PDX2": 0.0})
    problem = Problem(problem.tire, problem.rows, problem.free, problem.weights, problem.scale)
    (falling,) = ((c, points) for c, points in constraints("mf61") if c.name == "friction_falling:mu_x")
    assert len(ConstraintFunctions(problem, [falling])) == 0
    (positive,) = ((c, points) for c, points in constraints("mf61") if c.name == "signs:mu_x")
    assert len(ConstraintFunctions(problem, [positive])) == positive[1].shape[1]


def test_bounds_are_scaled_and_nan_is_a_violation():
    problem = problem_of("mf61", free=("PKX1",))
    stiff = Constraint("K_xkappa", 1.0, np.inf, ("Fz",), 1e4)
    imposed = ConstraintFunctions(problem, [(stiff, grid(stiff, RANGES, {}, density=0))])
    assert 1e-4 < imposed.low[0] < 1.1e-4
    assert imposed.satisfied(imposed.low)
    assert not imposed.satisfied(imposed.low - 1e-3)
    assert not imposed.satisfied(np.full(len(imposed), np.nan))
