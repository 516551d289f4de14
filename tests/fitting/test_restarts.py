"""Restarts from other values of a few coefficients: when they run, and which solution is returned."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from tirefmu.boundary.errors import UnknownName
from tirefmu.fitting import load_recipe
from tirefmu.fitting.solvers import SolverResult, best_end

LOWER, UPPER = np.array([-10.0, -10.0]), np.array([10.0, 10.0])
PROBLEM = SimpleNamespace(free=("RBY2", "RBY3"), scale=np.array([2.0, 0.5]))


def ends_at(cost, starts, *, converged=True):
    """Return a solver that returns its start with a given cost, and records its starts."""

    def solve_from(start):
        starts.append(start.tolist())
        return SolverResult(start, cost, 5, converged, "message")

    return solve_from


def first(x, cost=1.0):
    return SolverResult(np.array(x), cost, 7, True, "message")


def test_a_better_solution_replaces_the_first():
    starts = []
    end = best_end(PROBLEM, first([1.0, 2.0]), ends_at(0.5, starts), LOWER, UPPER, [{"RBY2": 8.0}], always=True)
    assert starts == [[4.0, 2.0]]  # 8 in units of 2; the others are unchanged
    assert (end.cost, end.iterations) == (0.5, 12)


@pytest.mark.parametrize(("cost", "converged"), [(1.0, True), (2.0, True), (0.5, False)])
def test_a_worse_or_unconverged_solution_does_not(cost, converged):
    solution = first([1.0, 2.0])
    solve_from = ends_at(cost, [], converged=converged)
    assert best_end(PROBLEM, solution, solve_from, LOWER, UPPER, [{"RBY2": 8.0}], always=True) is solution


def test_without_a_start_tire_only_coefficients_at_a_bound_are_restarted():
    again, starts = [{"RBY2": 8.0}, {"RBY3": 1.0}, {"PDY1": 1.0}], []
    best_end(PROBLEM, first([1.0, 10.0]), ends_at(2.0, starts), LOWER, UPPER, again, always=False)
    assert starts == [[1.0, 2.0]]
    best_end(PROBLEM, first([1.0, 2.0]), ends_at(2.0, starts), LOWER, UPPER, again, always=False)
    assert len(starts) == 1


def test_a_start_outside_its_bounds_is_moved_to_them():
    starts = []
    best_end(PROBLEM, first([1.0, 2.0]), ends_at(2.0, starts), LOWER, UPPER, [{"RBY2": 900.0}], always=True)
    assert starts == [[10.0, 2.0]]


def test_restart_values_of_a_recipe_refer_to_coefficients(make, tmp_path):
    path = make.recipe(tmp_path, '[[stage]]\nname = "one"\nagain = [{ RBY2 = 20, RBY3 = -0.05 }]\n')
    assert load_recipe(path, "mf61").stages[0].again == ({"RBY2": 20.0, "RBY3": -0.05},)
    wrong = make.recipe(tmp_path, '[[stage]]\nname = "one"\nagain = [{ RBY22 = 20 }]\n')
    with pytest.raises(UnknownName, match="RBY2"):
        load_recipe(wrong, "mf61")
