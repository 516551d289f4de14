"""Intervals under correlated noise, and directions that are not identifiable."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from scipy.signal import lfilter

from tirefmu.fitting.problem import Problem, Rows
from tirefmu.fitting.uncertainty.sandwich import uncertainty
from tirefmu.tires import Tire

N, SEGMENTS = 12_000, 6
SEGMENT = np.repeat(np.arange(SEGMENTS), N // SEGMENTS)
FREE = ("PCY1", "PDY1", "PDY2", "PEY1", "PKY1", "PKY2", "PHY1", "PVY1")


def correlated(rng, stays, n=N):
    """Return noise of variance 1 whose autocorrelation falls by `stays` from row to row."""
    return lfilter([np.sqrt(1 - stays**2)], [1.0, -stays], rng.normal(size=n + 500))[500:]


def sweeps(tire, noise, free=FREE, loads=(300.0, 700.0, 1100.0), passes=1):
    """Return the problem of sweeps at six loads, `passes` each, with noise of 20 N added to the true side force."""
    alpha = np.tile(np.linspace(-0.2, 0.2, N // SEGMENTS // passes), SEGMENTS * passes)
    load = np.repeat(np.resize(loads, SEGMENTS), N // SEGMENTS)
    inputs = np.stack([np.zeros(N), alpha, np.zeros(N), load])
    measured = np.full((N, 3), np.nan)
    measured[:, 1] = tire.forces(kappa=0.0, alpha=alpha, gamma=0.0, Fz=load)["Fy"] + 20.0 * noise
    rows = Rows(inputs, measured, np.zeros(N, dtype=int), SEGMENT)
    scale = np.array([max(abs(tire.values[name]), 0.1) for name in free])
    return Problem(tire, rows, free, np.array([[0.0, 1.0 / (N * 400.0), 0.0]]), scale)


@pytest.mark.slow
@pytest.mark.parametrize(("stays", "passes"), [(0.0, 1), (0.95, 1), (0.95, 40)])
def test_intervals_have_their_nominal_coverage(known, stays, passes):
    """One Gauss-Newton step from the truth is the fit, because the model is almost linear in that range.

    In a quick sweep the noise is slower than the sweep: it changes offsets, not slopes.
    """
    inside, white = [], []
    for seed in range(40):
        problem = sweeps(known, correlated(np.random.default_rng(seed), stays), passes=passes)
        truth = np.array([known.values[name] for name in FREE]) / problem.scale
        _, gradient, matrix = problem.derivatives(truth)
        missed = np.abs(np.linalg.solve(matrix, gradient)) * problem.scale
        half = np.array(list(uncertainty(problem, truth).intervals.values()))
        inside.append(missed <= half)
        white.append(missed <= 1.96 * np.sqrt(np.diag(np.linalg.inv(matrix)) / N) * problem.scale)
    assert 0.91 <= np.mean(inside) <= 0.985
    if stays and passes == 1:
        assert np.mean(white) < 0.6  # as if rows were independent: far too sure
    assert list(uncertainty(problem, truth).intervals) == list(FREE)


@pytest.mark.parametrize("of", ["rows", "channels"])
def test_intervals_do_not_depend_on_the_unit_of_the_weights(known, of):
    """The sandwich H^-1 M H^-1 has the weights once in H and twice in M."""
    problem = sweeps(known, correlated(np.random.default_rng(3), 0.5))
    uneven = replace(problem, rows=replace(problem.rows, weight=np.tile([0.5, 1.5], N // 2)))
    tripled = replace(uneven, rows=replace(uneven.rows, weight=3.0 * uneven.rows.weight))
    if of == "channels":
        tripled = replace(uneven, weights=3.0 * uneven.weights)
    truth = np.array([known.values[name] for name in FREE]) / problem.scale
    one, other = (uncertainty(each, truth).intervals for each in (uneven, tripled))
    assert other == pytest.approx(one, rel=1e-9)


def test_the_effective_sample_size_is_rows_over_correlation_length(known):
    problem = sweeps(known, correlated(np.random.default_rng(3), 0.9))
    truth = np.array([known.values[name] for name in FREE]) / problem.scale
    rows = uncertainty(problem, truth).effective_rows
    assert rows.shape == (1, 3)
    assert rows[0, 1] == pytest.approx(N * 0.1 / 1.9, rel=0.4)
    assert (rows[0, 0], rows[0, 2]) == (0.0, 0.0)


def test_one_load_does_not_identify_the_load_dependence(known):
    problem = sweeps(known, np.random.default_rng(0).normal(size=N), free=("PDY1", "PDY2", "PHY1"), loads=(300.0,))
    truth = np.array([known.values[name] for name in problem.free]) / problem.scale
    found = uncertainty(problem, truth)
    assert found.intervals["PDY2"] == inf
    # At 300 N friction is PDY1 - 0.57 PDY2: PDY1 is as sure as PDY2 is plausible (one size: 0.2).
    assert found.intervals["PDY1"] == pytest.approx(1.96 * 0.2 * 4 / 7, rel=0.1)
    assert 0 < found.intervals["PHY1"] < 1e-3
    (direction,) = found.directions
    assert direction.coefficients == ("PDY2",)
    assert direction.sd > 1.0


def test_a_bound_does_not_determine_what_the_data_do_not(known):
    """With PDY2 at a bound, one load would give PDY1 a narrow interval, and friction at other loads with it."""
    problem = sweeps(known, np.random.default_rng(0).normal(size=N), free=("PDY1", "PDY2"), loads=(300.0,))
    truth = np.array([known.values[name] for name in problem.free]) / problem.scale
    free, at_bound = uncertainty(problem, truth), uncertainty(problem, truth, fixed=("PDY2",))
    assert at_bound.intervals == free.intervals
    assert at_bound.intervals["PDY2"] == inf


def test_two_loads_identify_the_load_dependence(known):
    problem = sweeps(known, np.random.default_rng(0).normal(size=N), free=("PDY1", "PDY2"), loads=(300.0, 1100.0))
    found = uncertainty(problem, np.array([1.9, -0.2]) / problem.scale)
    assert found.directions == ()
    assert max(found.intervals.values()) < 0.05


def test_a_coefficient_without_influence_has_an_infinite_interval(known):
    upright = Tire("mf96", known.values, effects=known.effects, signs="adapted-sae")
    problem = sweeps(upright, np.random.default_rng(0).normal(size=N), free=("PDY1", "PDY3"))  # PDY3: camber
    found = uncertainty(problem, np.array([1.9, 3.0]) / problem.scale)
    assert found.intervals["PDY3"] == inf
    assert 0 < found.intervals["PDY1"] < 0.1
    assert [(d.coefficients, d.sd) for d in found.directions] == [(("PDY3",), inf)]


def test_a_coefficient_at_a_bound_is_treated_as_known(known):
    problem = sweeps(known, np.random.default_rng(0).normal(size=N))
    truth = np.array([known.values[name] for name in FREE]) / problem.scale
    free, fixed = uncertainty(problem, truth), uncertainty(problem, truth, fixed=("PCY1",))
    assert set(fixed.intervals) == set(FREE) - {"PCY1"}
    assert fixed.intervals["PEY1"] < free.intervals["PEY1"]
    assert uncertainty(problem, truth, fixed=FREE).intervals == {}
