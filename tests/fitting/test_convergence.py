"""The convergence criterion depends only on the point; a solver that ends elsewhere is continued."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from tirefmu.fitting.constraints import Constraint, ConstraintFunctions
from tirefmu.fitting.problem import Problem, Ridge
from tirefmu.fitting.solvers import INTERRUPTED, GaussNewton, SolverResult, solve

FREE = ("PCY1", "PDY1", "PDY2", "PKY1", "PKY2", "PHY1", "PVY1")
LOAD = np.array([[0.0], [0.0], [0.0], [700.0]])


@pytest.fixture(scope="module")
def exact(known, make):
    return make.problem(make.sideways(known).table, known, FREE)


@pytest.fixture(scope="module")
def noisy(known, make, noisy_table):
    return make.problem(noisy_table, known, FREE)


@pytest.fixture(scope="module")
def truth(known, exact):
    return np.array([known.values[name] for name in FREE]) / exact.scale


class Failing(Problem):
    """A problem whose gradient is NaN at some evaluations."""

    at = range(0)
    count = 0

    def derivatives(self, x):
        self.count += 1
        cost, gradient, matrix = super().derivatives(x)
        return cost, gradient * (np.nan if self.count in self.at else 1.0), matrix


def failing(problem, at):
    faulty = Failing(problem.tire, problem.rows, problem.free, problem.weights, problem.scale)
    faulty.at = at
    return faulty


def evaluated(problem, x, constraints=(), *, lower=-inf, upper=inf, steps=0):
    bounds = (np.full(len(x), bound) if np.isscalar(bound) else bound for bound in (lower, upper))
    return GaussNewton(Ridge(problem, x, 0.0), *bounds, ConstraintFunctions(problem, constraints)).last(x, steps)


def bounded(index, value):
    bound = np.full(len(FREE), inf)
    bound[index] = value
    return bound


# ------------------------------------------------------------------ the criterion


def test_exact_data_have_converged_at_the_truth(exact, truth):
    found = evaluated(exact, truth)
    assert found.converged
    assert found.reason.endswith("of the least noise")


def test_a_point_away_from_the_optimum_has_not_converged(exact, noisy, truth):
    for problem in (exact, noisy):
        found = evaluated(problem, truth * 1.02)
        assert not found.converged
        assert found.reason.startswith("predicted reduction")


def test_the_measure_is_the_standard_error(noisy, truth):
    """A point within a hundredth of a standard error has converged; a point at one standard error has not."""
    optimum = evaluated(noisy, truth, steps=20).x
    _, _, matrix = noisy.derivatives(optimum)
    values, vectors = np.linalg.eigh(matrix)
    error = np.sqrt(2.0 * noisy.cost(optimum) / len(noisy.rows) / values)
    away = vectors @ error
    assert evaluated(noisy, optimum + 0.01 * away).converged
    assert not evaluated(noisy, optimum + away).converged


@pytest.mark.parametrize(("errors", "reason", "accepted"), [
    (0.7, "iteration limit", True), (0.7, "no step is accepted", True), (0.7, INTERRUPTED, False),
    (2.0, "iteration limit", False), (inf, "iteration limit", False), (np.nan, "iteration limit", False),
])  # fmt: skip
def test_an_end_within_a_standard_error_of_the_optimum_is_accepted(errors, reason, accepted):
    end = SolverResult(np.zeros(1), 1.0, 300, False, reason, errors=errors).accepted()
    assert (end.converged, end.reason.endswith("standard errors of the optimum")) == (accepted, accepted)


@pytest.mark.parametrize("errors", [0.7, 2.0])
def test_the_distance_of_the_optimum_is_in_standard_errors(noisy, truth, errors):
    """Whatever the direction: the error of no coefficient is larger."""
    optimum = evaluated(noisy, truth, steps=20).x
    values, vectors = np.linalg.eigh(noisy.derivatives(optimum)[2])
    for value, vector in zip(values, vectors.T, strict=True):
        error = np.sqrt(2.0 * noisy.cost(optimum) / len(noisy.rows) / value)
        end = evaluated(noisy, optimum + errors * error * vector)
        assert not end.converged
        assert end.errors == pytest.approx(errors, rel=0.3)


def test_at_a_bound_the_gradient_may_point_beyond_it(noisy, truth):
    index = FREE.index("PDY1")
    bound = bounded(index, 0.9 * truth[index])
    found = evaluated(noisy, np.minimum(truth, bound), upper=bound, steps=20)
    assert found.converged
    assert found.x[index] == pytest.approx(bound[index], rel=1e-12)
    assert not evaluated(noisy, found.x).converged  # without the bound there is more to gain


def test_an_active_constraint_is_part_of_the_criterion(noisy, truth):
    constraints = [(Constraint("mu_y", -inf, 1.7, ()), LOAD)]  # the tire has 1.9
    start = truth.copy()
    start[FREE.index("PDY1")] *= 0.85
    found = evaluated(noisy, start, constraints, steps=20)
    assert found.converged
    assert ConstraintFunctions(noisy, constraints).values(found.x) == pytest.approx(1.7, abs=2e-6)
    assert not evaluated(noisy, found.x).converged


def test_a_point_that_violates_a_constraint_has_not_converged(noisy, truth):
    found = evaluated(noisy, truth, [(Constraint("mu_y", -inf, 1.7, ()), LOAD)], steps=5)
    assert (found.converged, found.steps) == (False, 0)
    assert found.reason.startswith("a constraint is violated by 2e-01")


# ------------------------------------------------------------------ a solver that fails


def test_a_solver_that_fails_at_the_optimum_has_converged(exact, truth):
    everywhere = np.full(len(FREE), inf)
    solution = solve(failing(exact, range(6, 7)), truth * 1.02, -everywhere, everywhere, [])
    assert solution.detail == "Invalid_Number_Detected"
    assert solution.converged
    np.testing.assert_allclose(solution.x, truth, atol=1e-6)


def test_a_solver_that_fails_before_the_optimum_is_continued(noisy, truth):
    everywhere = np.full(len(FREE), inf)
    whole = solve(noisy, truth * 1.1, -everywhere, everywhere, [])
    solution = solve(failing(noisy, range(3, 4)), truth * 1.1, -everywhere, everywhere, [])
    assert solution.detail.startswith("Invalid_Number_Detected")
    assert solution.converged
    assert solution.cost == pytest.approx(whole.cost, rel=1e-4)


def test_a_solver_that_always_fails_reports_it(noisy, truth):
    everywhere = np.full(len(FREE), inf)
    solution = solve(failing(noisy, range(3, 1000)), truth * 1.1, -everywhere, everywhere, [])
    assert not solution.converged
    assert solution.reason == "cost, constraints or derivatives are not finite"
    assert solution.detail == ", ".join(3 * ["Invalid_Number_Detected"])
    assert np.isfinite(solution.x).all()
