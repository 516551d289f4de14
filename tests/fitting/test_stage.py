"""A stage that continues the one before: Gauss-Newton steps, a sample of many rows, IPOPT if they find no optimum."""

from __future__ import annotations

from functools import partial
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest

from tirefmu.fitting import StageSolver
from tirefmu.fitting import stage as solution_of_a_stage
from tirefmu.fitting.problem import Problem
from tirefmu.fitting.solvers import SolverResult, solve, solver_for

FREE = ("PCY1", "PDY1", "PDY2", "PKY1", "PKY2", "PHY1", "PVY1")
UNCONSTRAINED = SimpleNamespace(of=lambda channels, density=0: [], violations=lambda dense, values: [])
EVERYWHERE = np.full(len(FREE), inf)


@pytest.fixture(scope="module")
def noisy(known, make, noisy_table):
    return make.problem(noisy_table, known, FREE)


@pytest.fixture(scope="module")
def optimum(noisy, known):
    truth = np.array([known.values[name] for name in FREE]) / noisy.scale
    return solve(noisy, truth * 1.05, -EVERYWHERE, EVERYWHERE, [])


@pytest.fixture(scope="module")
def near(noisy, optimum):
    return solve(noisy.sampled(len(noisy.rows) // 3), optimum.x, -EVERYWHERE, EVERYWHERE, []).x


def stage(problem, solver=solve, stop=lambda: False):
    report = partial(lambda count, cost, values: None)
    return StageSolver(problem, -EVERYWHERE, EVERYWHERE, UNCONSTRAINED, [], ["Fy"], "final", 1e-9, solver, report, stop)


def recording(calls, *, converged=True):
    """Return a solver that records rows and manner of its calls, and returns its start."""

    def solver(problem, start, lower, upper, constraints, *, local=False, refine=False, **options):
        calls.append((len(problem.rows), "local" if local else "refine" if refine else ""))
        return SolverResult(start, 1.0, 1, converged or not local, "message")

    return solver


def test_the_optimum_is_that_of_a_solution_from_the_beginning(noisy, optimum, near):
    solution = stage(noisy).solve(near, continues=True)
    assert solution.converged
    assert not solution.detail  # IPOPT did not run
    assert solution.cost == pytest.approx(optimum.cost, rel=1e-6)


def test_without_an_optimum_ipopt_follows(noisy, optimum, near):
    class Failing(Problem):
        count = 0

        def derivatives(self, x):
            self.count += 1
            cost, gradient, matrix = super().derivatives(x)
            return cost, gradient * (np.nan if self.count == 1 else 1.0), matrix

    faulty = Failing(noisy.tire, noisy.rows, noisy.free, noisy.weights, noisy.scale)
    solution = stage(faulty).solve(near, continues=True)
    assert solution.converged
    assert solution.detail
    assert solution.cost == pytest.approx(optimum.cost, rel=1e-4)


def test_steps_of_few_iterations_are_no_optimum(noisy, optimum):
    solution = solve(noisy, optimum.x * 1.3, -EVERYWHERE, EVERYWHERE, [], local=True, max_iterations=1)
    assert not solution.converged
    assert solution.iterations == 1


def test_of_many_rows_a_sample_is_solved_first(noisy, near, monkeypatch):
    monkeypatch.setattr(solution_of_a_stage, "MIN_ROWS", len(noisy.rows))
    monkeypatch.setattr(solution_of_a_stage, "SAMPLE", 100)
    calls = []
    assert stage(noisy, recording(calls)).solve(near, continues=True).iterations == 2
    assert calls == [(100, "local"), (len(noisy.rows), "refine")]


def test_only_a_stage_that_continues_takes_steps_first(noisy, near):
    calls = []
    stage(noisy, recording(calls)).solve(near)
    assert calls == [(len(noisy.rows), "")]
    calls.clear()
    stage(noisy, recording(calls, converged=False)).solve(near, continues=True)
    assert [manner for _, manner in calls] == ["local", ""]


def test_a_stop_after_the_sample_returns_the_cost_of_all_rows(noisy, near, monkeypatch):
    monkeypatch.setattr(solution_of_a_stage, "MIN_ROWS", len(noisy.rows))
    calls = []
    solution = stage(noisy, recording(calls), stop=lambda: bool(calls)).solve(near, continues=True)
    assert len(calls) == 1
    assert not solution.converged
    assert solution.cost == noisy.cost(near)


def test_a_sample_has_about_the_cost_of_all_rows(noisy, near):
    some = noisy.sampled(200)
    assert len(some.rows) == 200
    assert some.cost(near) == pytest.approx(noisy.cost(near), rel=0.3)
    assert some.cost(near) != noisy.cost(near)


def test_a_search_without_derivatives_has_no_steps(noisy, near):
    solution = solver_for("ioa")(noisy, near, -EVERYWHERE, EVERYWHERE, [], local=True)
    assert not solution.converged
    np.testing.assert_array_equal(solution.x, near)
