"""A cost that jumps: with a side slip of exactly 0, sgn(alpha_t) of the combined aligning moment does at QHZ1 = 0."""

from __future__ import annotations

from math import inf

import numpy as np
import pandas as pd
import pytest

from tirefmu.fitting.constraints import ConstraintFunctions
from tirefmu.fitting.problem import Problem, Ridge, Rows, equal_weights
from tirefmu.fitting.solvers import GaussNewton, solve
from tirefmu.tires import Tire

FREE = ("QBZ1", "QCZ1", "QDZ1", "QHZ1")
VALUES = {
    "FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3, "PCX1": 1.6, "PDX1": 1.2, "PKX1": 24.0, "PCY1": 1.4, "PDY1": 1.1,
    "PKY1": -18.0, "PKY2": 1.6, "PKY4": 2.0, "PVY1": 0.1, "RBY1": 14.0, "RCY1": 1.03, "QBZ1": 8.0, "QBZ9": 10.0,
    "QCZ1": 1.15, "QDZ1": 0.09,
}  # fmt: skip
SLIP = np.linspace(-0.2, 0.2, 40)
EVERYWHERE = np.full(len(FREE), inf)


@pytest.fixture(scope="module", params=[0.0, 0.01])
def problem(request):
    """Return a problem of Mz with noise: 40 rows of side slip, 40 of kappa; and the scaled values of its tire."""
    tire = Tire("mf61", {**VALUES, "QHZ1": request.param}, signs="adapted-sae")
    still = np.zeros(40)
    inputs = {"alpha": np.append(SLIP, still), "kappa": np.append(still, SLIP)}
    table = pd.DataFrame({**inputs, "Fz": 3000.0, "gamma": 0.0, "recording": 0, "segment": 0})
    exact = tire.evaluate(table, signs="adapted-sae")["Mz"].to_numpy()
    table["Mz"] = exact + np.random.default_rng(0).normal(0.0, 1.0, len(table))
    rows = Rows.of(table, tire, ["Mz"])
    scale = np.array([8.0, 1.15, 0.09, 0.01])
    truth = np.array([tire.values[name] for name in FREE]) / scale
    return Problem(tire, rows, FREE, equal_weights(rows), scale), truth


def test_the_optimum_is_at_the_jump_or_beyond_it(problem):
    problem, truth = problem
    start = truth * [1.0, 1.0, 1.0, 0.0]
    steps = GaussNewton(Ridge(problem, start, 0.0), -EVERYWHERE, EVERYWHERE, ConstraintFunctions(problem, []))
    found = steps.last(start, 20)
    assert found.converged, found.reason
    assert problem.cost(found.x) <= problem.cost(truth)
    assert (found.x[-1] == 0.0) == (truth[-1] == 0.0)


def test_a_solution_from_the_jump_converges(problem):
    problem, truth = problem
    found = solve(problem, truth * [1.0, 1.0, 1.0, 0.0], -EVERYWHERE, EVERYWHERE, [])
    assert found.converged, found.reason
    assert problem.cost(found.x) <= problem.cost(truth)
