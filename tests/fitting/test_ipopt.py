"""IPOPT: its optimum, bounds and constraints, and the status without convergence."""

from __future__ import annotations

import itertools
from math import inf

import numpy as np
import pytest
from scipy.optimize import least_squares

from tirefmu.fitting.constraints import Constraint, declared_constraints, grid, operating_range
from tirefmu.fitting.solvers import INTERRUPTED, solve
from tirefmu.tires.code import code_for

FREE = ("PCY1", "PDY1", "PDY2", "PEY1", "PKY1", "PKY2", "PHY1", "PVY1", "PVY3")
#: Iterations after which a fit is stopped; some points before satisfy the constraints.
STOPPED_AT = 12
START = {"PCY1": 1.2, "PDY1": 1.5, "PKY1": 30.0, "PKY2": 1.5}


@pytest.fixture(scope="module")
def problem(known, make, noisy_table):
    return make.problem(noisy_table, known, FREE)


@pytest.fixture
def start(problem, known):
    values = {**known.values, "PEY1": 0.0, "PHY1": 0.0, "PVY1": 0.0, "PVY3": 0.0, "PDY2": 0.0, **START}
    return np.array([values[name] for name in FREE]) / problem.scale


@pytest.fixture
def bounds():
    """Return a function that returns scaled bounds of some coefficients."""

    def write(problem, **given):
        lower = np.array([given.get(name, (-inf, inf))[0] for name in FREE]) / problem.scale
        upper = np.array([given.get(name, (-inf, inf))[1] for name in FREE]) / problem.scale
        return lower, upper

    return write


@pytest.fixture(scope="module")
def curvature(known, noisy_table):
    """Return the constraint E_y <= 1 with its points, and a function for E_y at points."""
    (constraint,) = (c for c in declared_constraints("mf96")["Fy"] if c.name == "curvature:E_y")
    ranges = operating_range(noisy_table, known)
    nominal = {name: known.nominal(name) for name in known.inputs}
    code = code_for("mf96", "numpy")

    def values(problem, x, density):
        points = grid(constraint, ranges, nominal, density=density)
        return code.quantities(points, problem.parameters(x))[code.quantities_names.index("E_y")]

    return (constraint, grid(constraint, ranges, nominal)), values


def test_it_finds_the_least_squares(problem, start, bounds):
    solution = solve(problem, start, *bounds(problem), [])

    def residual(x):
        forces = code_for("mf96", "numpy").forces(problem.rows.inputs, problem.parameters(x))
        measured = problem.rows.measured[:, 1]
        return (forces[1] - measured) / np.sqrt(np.sum(measured**2))

    reference = least_squares(residual, start, xtol=1e-12, ftol=1e-12, gtol=1e-12)
    assert solution.converged
    assert solution.cost == pytest.approx(reference.cost, rel=1e-5)
    assert solution.cost == problem.cost(solution.x)
    np.testing.assert_allclose(solution.x, reference.x, atol=0.02)


def test_a_constraint_without_a_value_is_a_reason_and_no_line_of_the_solver(problem, start, bounds, curvature, capfd):
    (constraint, points), _ = curvature
    undefined = points.copy()
    undefined[:, 0] = np.nan
    solution = solve(problem, start, *bounds(problem), [(constraint, undefined)], max_iterations=20)
    assert capfd.readouterr() == ("", "")
    assert (solution.converged, solution.reason) == (False, "cost, constraints or derivatives are not finite")


def test_bounds_are_satisfied(problem, start, bounds, known):
    lower, upper = bounds(problem, PDY1=(0.1, 1.7), PKY2=(2.6, 5.0), PCY1=(1.0, 2.0))
    solution = solve(problem, np.clip(start, lower, upper), lower, upper, [])
    assert solution.converged
    assert (solution.x >= lower).all()
    assert (solution.x <= upper).all()
    values = dict(zip(FREE, solution.x * problem.scale, strict=True))
    assert values["PDY1"] == pytest.approx(1.7, abs=1e-3)  # the optimum is 1.9
    assert values["PKY2"] == pytest.approx(2.6, abs=1e-3)  # and 2.2
    free = solve(problem, start, *bounds(problem), [])
    assert free.cost < solution.cost


def test_a_constraint_is_satisfied_if_the_optimum_violates_it(problem, start, bounds, curvature):
    (constraint, points), curvature_at = curvature
    free = solve(problem, start, *bounds(problem), [])
    # E_y of the known tire is below 1: the bound is below the unconstrained solution.
    highest = float(curvature_at(problem, free.x, 1).max())
    ceiling = highest - 0.3
    tight = Constraint(constraint.quantity, -inf, ceiling, constraint.varied)
    constrained = solve(problem, start, *bounds(problem), [(tight, points)])
    assert constrained.converged
    assert curvature_at(problem, constrained.x, 4).max() == pytest.approx(ceiling, abs=1e-3)
    assert constrained.cost > free.cost


def test_the_best_point_of_a_stopped_fit_satisfies_the_constraints(problem, start, bounds, curvature):
    """From the unconstrained optimum, which violates them at a lower cost: that start is not the best point."""
    (constraint, points), curvature_at = curvature
    free = solve(problem, start, *bounds(problem), [])
    ceiling = float(curvature_at(problem, free.x, 1).max()) - 0.3
    tight = [(Constraint(constraint.quantity, -inf, ceiling, constraint.varied), points)]
    calls = itertools.count(1)
    stopped = solve(problem, free.x, *bounds(problem), tight, stop=lambda: next(calls) >= STOPPED_AT)
    assert stopped.reason == INTERRUPTED
    assert not stopped.converged
    assert curvature_at(problem, stopped.x, 1).max() <= ceiling + 1e-5
    assert stopped.cost > free.cost


def test_too_few_iterations_are_a_result(problem, start, bounds):
    solution = solve(problem, start, *bounds(problem), [], max_iterations=1)
    assert not solution.converged
    assert solution.reason.startswith("iteration limit: predicted reduction")
    assert solution.detail == "Maximum_Iterations_Exceeded"
    assert solution.iterations == 1
    assert np.isfinite(solution.x).all()
    assert np.isfinite(solution.cost)


def test_infeasible_constraints_are_a_result(problem, start, bounds):
    points = np.array([[0.0], [0.0], [0.0], [700.0]])
    pair = [(Constraint("mu_y", 3.0, inf, ()), points), (Constraint("mu_y", -inf, 1.0, ()), points)]
    solution = solve(problem, start, *bounds(problem), pair, max_iterations=50)
    assert not solution.converged
    assert solution.reason
    assert np.isfinite(solution.x).all()


def test_a_direction_that_is_not_identifiable_does_not_change(known, make, noisy_table):
    pair = make.problem(noisy_table[noisy_table["Fz"] == 500.0], known, ("PDY1", "PDY2"))
    start = np.array([1.7, -0.5]) / pair.scale
    wide = np.full(2, 50.0)
    solution = solve(pair, start, -wide, wide, [])
    dfz = (500.0 - 700.0) / 700.0
    value = solution.x * pair.scale
    assert solution.converged
    assert value[0] + value[1] * dfz == pytest.approx(1.9 - 0.2 * dfz, rel=0.01)  # this combination is identifiable
    # Along the other direction the values do not change.
    along = np.array([-dfz, 1.0]) / pair.scale
    assert (solution.x - start) @ along == pytest.approx(0.0, abs=0.05)
