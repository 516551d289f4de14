"""Slip stiffnesses as residuals of a fit: derivatives, intervals, and the fit of a formula that cannot follow them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tirefmu.boundary.errors import FitError
from tirefmu.fitting import fit
from tirefmu.fitting.problem import SlopeTarget
from tirefmu.fitting.uncertainty.sandwich import uncertainty
from tirefmu.measurements import Noise, Recording, VirtualBench, alpha_sweeps
from tirefmu.numerics import SLOPE_WINDOW, read_slope

from .test_uncertainty import FREE, correlated, sweeps


def with_targets(problem, deviation=0.05, weight=1.0):
    """Return the problem with the slopes of its sweeps at zero slip as targets, by load."""
    alpha, load, force = problem.rows.inputs[1], problem.rows.inputs[3], problem.rows.measured[:, 1]
    targets = []
    for level in np.unique(load):
        own = np.flatnonzero(load == level)
        slope = read_slope(alpha[own], force[own], SLOPE_WINDOW["alpha"])
        inputs = np.ascontiguousarray(problem.rows.inputs[:, own[slope.rows]])
        size = np.hypot(slope.error, deviation * slope.value)
        rows = own[slope.rows]
        targets.append(
            SlopeTarget(0, 1, inputs, slope.influence, force[rows], rows, slope.value, slope.error, float(size))
        )
    return replace(problem, targets=tuple(targets), target_weight=weight)


def test_the_gradient_is_that_of_the_cost(known):
    problem = with_targets(sweeps(known, correlated(np.random.default_rng(0), 0.0)))
    x = 1.02 * np.array([known.values[name] for name in FREE]) / problem.scale
    cost, gradient, matrix = problem.derivatives(x)
    without = replace(problem, targets=())
    assert cost == problem.cost(x) > 1.01 * without.cost(x)
    assert problem.costs(x[None, :], np.array([np.inf]))[0] == pytest.approx(cost, rel=1e-12)
    step = 1e-6
    numeric = [(problem.cost(x + step * e) - problem.cost(x - step * e)) / (2 * step) for e in np.eye(len(x))]
    np.testing.assert_allclose(gradient, numeric, rtol=1e-5, atol=1e-8)
    added = matrix - without.derivatives(x)[2]
    np.testing.assert_allclose(added, problem.target_jacobian(x).T @ problem.target_jacobian(x), atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("stays", [0.0, 0.9])
def test_targets_are_no_further_information(known, stays):
    """Intervals have their nominal coverage although the rows near zero slip are fitted twice."""
    inside = []
    for seed in range(40):
        problem = with_targets(sweeps(known, correlated(np.random.default_rng(seed), stays)), weight=0.5)
        truth = np.array([known.values[name] for name in FREE]) / problem.scale
        _, gradient, matrix = problem.derivatives(truth)
        missed = np.abs(np.linalg.solve(matrix, gradient)) * problem.scale
        inside.append(missed <= np.array(list(uncertainty(problem, truth).intervals.values())))
    assert problem.derivatives(truth)[2][4, 4] > 2.0 * replace(problem, targets=()).derivatives(truth)[2][4, 4]
    assert 0.9 <= np.mean(inside) <= 0.99


def test_a_formula_that_cannot_follow_is_drawn_to_the_slip_stiffness(known, make):
    """Without dependence of the slip stiffness on load, the targets decide between peak and slope."""
    program = alpha_sweeps((220.0, 500.0, 800.0, 1120.0), sample_rate=12.0)
    table = VirtualBench(known, Noise.none()).run(program).table.drop(columns=["Fx", "Mz"])
    recording = Recording(table, "adapted-sae", "sweeps")
    effects = ("load_friction", "load_curvature")
    errors = []
    for weight in (0.0, 1000.0):
        result = make.fit(recording, effects=effects, stiffness_weight=weight)
        assert result.status == "converged"
        errors.append([each.off for each in result.findings.stiffnesses])
    assert len(errors[0]) == 4
    assert np.sum(np.square(errors[1])) < 0.9 * np.sum(np.square(errors[0]))


@pytest.mark.parametrize("weight", [-1.0, np.inf, np.nan])
def test_a_bad_weight(known, make, weight):
    with pytest.raises(FitError, match="stiffness weight"):
        fit(make.sideways(known), "mf96", nominal=make.nominal, stiffness_weight=weight)
