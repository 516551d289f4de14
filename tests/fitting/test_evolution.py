"""IOA: it recovers a small tire, satisfies bounds and constraints, is reproducible, and reports its status."""

from __future__ import annotations

from itertools import count
from math import inf

import numpy as np
import pytest

from tirefmu.boundary.errors import FitError, UnknownName
from tirefmu.fitting.constraints import Constraint
from tirefmu.fitting.problem import Problem
from tirefmu.fitting.solvers import GOAL, INTERRUPTED, LIMIT, METHODS, NO_GAIN, Evolution, solve, solver_for
from tirefmu.tires.code import code_for, forces_of_each

FREE = ("PCY1", "PDY1", "PDY2", "PKY1", "PKY2")
START = {"PCY1": 1.2, "PDY1": 1.5, "PDY2": 0.0, "PKY1": 30.0, "PKY2": 1.5}


@pytest.fixture(scope="module")
def problem(known, make):
    return make.problem(make.sideways(known, cambers=(0.0,)).table, known, FREE)


@pytest.fixture
def start(problem):
    return np.array([START[name] for name in FREE]) / problem.scale


@pytest.fixture
def bounds(problem):
    """Return a function that returns scaled bounds, by default the declared ones."""
    declarations = problem.tire.symbolic_model.coefficients

    def write(**given):
        lower, upper = zip(
            *(given.get(name, (declarations[name].lower, declarations[name].upper)) for name in FREE), strict=True
        )
        return np.array(lower) / problem.scale, np.array(upper) / problem.scale

    return write


@pytest.mark.slow
def test_it_recovers_known_coefficients(problem, start, bounds, known):
    solution = Evolution(1000)(problem, start, *bounds(), [])
    np.testing.assert_allclose(solution.x * problem.scale, [known.values[name] for name in FREE], rtol=1e-3)
    assert solution.cost == problem.cost(solution.x)


def test_equal_seeds_give_equal_searches(problem, start, bounds):
    first, again, other = (Evolution(30, seed)(problem, start, *bounds(), []) for seed in (4, 4, 5))
    np.testing.assert_array_equal(first.x, again.x)
    assert (first.cost, first.iterations) == (again.cost, again.iterations)
    assert not np.array_equal(first.x, other.x)


def test_every_candidate_is_within_the_bounds(problem, start, bounds, monkeypatch):
    lower, upper = bounds(PDY1=(0.1, 1.7), PKY2=(2.6, 5.0), PCY1=(1.2, 1.2))
    seen = []
    costs = Problem.costs

    def watched(self, population, limits):
        seen.append(population.copy())
        return costs(self, population, limits)

    monkeypatch.setattr(Problem, "costs", watched)
    solution = Evolution(200)(problem, np.clip(start, lower, upper), lower, upper, [])
    tried = np.concatenate(seen)
    rounding = 1e-12 * np.maximum(np.abs(lower), np.abs(upper))
    assert (tried >= lower - rounding).all()
    assert (tried <= upper + rounding).all()
    values = dict(zip(FREE, solution.x * problem.scale, strict=True))
    assert values["PCY1"] == pytest.approx(1.2, rel=1e-12)
    assert values["PDY1"] == pytest.approx(1.7, abs=1e-2)  # the optimum is 1.9


def test_constraints_are_satisfied_if_the_optimum_violates_them(problem, start, bounds):
    points = np.array([[0.0, 0.0], [0.1, 0.1], [0.0, 0.0], [220.0, 1120.0]])
    ceiling = (Constraint("mu_y", -inf, 1.6, ("Fz",)), points)
    free = Evolution(300)(problem, start, *bounds(), [])
    constrained = Evolution(300)(problem, start, *bounds(), [ceiling])
    reference = solve(problem, start, *bounds(), [ceiling])
    code = code_for("mf96", "numpy")
    index = code.quantities_names.index("mu_y")
    assert code.quantities(points, problem.parameters(free.x))[index].max() > 1.8
    assert code.quantities(points, problem.parameters(constrained.x))[index].max() <= 1.6 + 2e-6
    assert constrained.cost == pytest.approx(reference.cost, rel=1e-2)


def test_infeasible_constraints_are_a_result(problem, start, bounds):
    points = np.array([[0.0], [0.0], [0.0], [700.0]])
    pair = [(Constraint("mu_y", 3.0, inf, ()), points), (Constraint("mu_y", -inf, 1.0, ()), points)]
    solution = Evolution(150)(problem, start, *bounds(), pair)
    assert not solution.converged
    assert solution.reason == LIMIT
    assert np.isfinite(solution.x).all()


def test_a_search_continues_with_its_population_and_more_constraints(problem, start, bounds):
    points = np.array([[0.0], [0.0], [0.0], [700.0]])
    ceiling = (Constraint("mu_y", -inf, 1.7, ()), points)
    search = Evolution(300)
    first = search(problem, start, *bounds(), [])
    more = search(problem, first.x, *bounds(), [ceiling])
    assert more.iterations == first.iterations + 30
    assert (more.x * problem.scale)[FREE.index("PDY1")] <= 1.7 + 2e-6


# ------------------------------------------------------------------ how it ends


def test_the_error_goal_ends_it(problem, start, bounds):
    goal = 1e-3
    solution = Evolution(5000, goal=goal)(problem, start, *bounds(), [])
    assert (solution.converged, solution.reason) == (True, GOAL)
    assert solution.cost <= goal
    assert solution.iterations < 5000


def test_the_stopping_window_ends_a_search_unless_it_runs_to_the_limit(known, make, bounds, start, noisy_table):
    noisy = make.problem(noisy_table[noisy_table["gamma"] == 0.0], known, FREE)
    stopped = Evolution(1500)(noisy, start, *bounds(), [])
    assert (stopped.converged, stopped.reason) == (True, NO_GAIN)
    assert stopped.iterations < 1500
    assert stopped.cost == pytest.approx(solve(noisy, start, *bounds(), []).cost, rel=1e-4)
    full_length = Evolution(stopped.iterations + 1, run_to_limit=True)(noisy, start, *bounds(), [])
    assert full_length.reason == LIMIT


def test_a_stopped_search_returns_the_best_individual(problem, start, bounds):
    calls = []
    requests = count(1)
    solution = Evolution(1000)(
        problem, start, *bounds(), [], progress=lambda *call: calls.append(call), stop=lambda: next(requests) == 20
    )
    assert (solution.reason, solution.converged, solution.iterations) == (INTERRUPTED, False, 20)
    generations, costs, _ = zip(*calls, strict=True)
    assert generations == tuple(range(1, 21))
    assert list(costs) == sorted(costs, reverse=True)
    assert solution.cost == pytest.approx(costs[-1])
    assert solution.cost < problem.cost(start)


# ------------------------------------------------------------------ within a fit


def test_every_stage_of_the_default_recipe_can_be_solved_by_it(known, make):
    result = make.fit(make.sideways(known), effects=("load_friction",), method="ioa", iterations=40)
    by_ipopt = make.fit(make.sideways(known), effects=("load_friction",))
    assert [stage.name for stage in result.stages] == [stage.name for stage in by_ipopt.stages]
    assert result.channels[0].rmse < 3 * by_ipopt.channels[0].rmse


def test_invalid_methods_and_numbers_are_rejected():
    with pytest.raises(UnknownName, match="unknown method 'iao': did you mean ioa"):
        solver_for("iao")
    with pytest.raises(FitError, match="at least one"):
        solver_for("ioa", iterations=0)
    with pytest.raises(FitError, match="must not be negative"):
        solver_for("ioa", seed=-1)
    assert {method: solver_for(method, 7) for method in METHODS}["ioa"].max_iterations == 7


# ------------------------------------------------------------------ many points at once


@pytest.mark.parametrize("language", ["numpy", "batch"])
def test_the_forces_of_many_tires_are_those_of_each(known, make, language):
    code = code_for("mf96", language)
    inputs = np.stack([make.anywhere(300)[name] for name in known.inputs])
    inputs[0, 5] = 1e9  # outside the range of the batch kernel, which calls the code for single rows
    population = np.stack([make.other_tire(seed).parameters() for seed in range(4)])
    together = forces_of_each(code, inputs, population)
    for parameters, forces in zip(population, together, strict=True):
        np.testing.assert_array_equal(forces, code.forces(inputs, parameters))


def test_many_costs_are_those_of_each_up_to_their_limits(problem, start):
    population = start * np.random.default_rng(0).uniform(0.5, 1.5, (6, len(start)))
    each = np.array([problem.cost(x) for x in population])
    np.testing.assert_allclose(problem.costs(population, np.full(6, inf)), each, rtol=1e-12)
    limits = np.median(each) * np.ones(6)
    np.testing.assert_array_equal(problem.costs(population, limits) > limits, each > limits)
