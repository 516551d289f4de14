"""Robust losses: their derivatives, and fits of recordings with outliers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tirefmu.fitting.problem import LOSSES, limits_of, noise_weights, robust_scale
from tirefmu.measurements import ChannelNoise, Noise, Recording

SIZE = 15.0  # N, of the noise
FREE = ("PCY1", "PDY1", "PDY2", "PEY1", "PKY1", "PKY2", "PHY1", "PVY1")
ROBUST = ("huber", "cauchy")


@pytest.fixture(scope="module")
def outliers(known, make):
    """Return a side force with errors in every twentieth row, one-sided and up to a hundred times the noise."""
    recording = make.sideways(known, noise=Noise({"Fy": ChannelNoise(constant=SIZE)}))
    rng = np.random.default_rng(8)
    wrong = rng.random(len(recording)) < 0.05
    force = recording.table["Fy"] + np.where(wrong, rng.uniform(0.0, 100.0 * SIZE, len(recording)), 0.0)
    return Recording(recording.table.assign(Fy=force), recording.signs, "outliers")


@pytest.mark.parametrize("name", LOSSES)
def test_weight_and_slope_are_those_of_the_value(name):
    loss, v = LOSSES[name], np.array([0.01, 0.3, 0.9, 1.2, 3.0, 50.0])
    h = 1e-5 * v
    first = (loss.value(v + h) - loss.value(v - h)) / (2 * h)
    np.testing.assert_allclose(first, 2 * v * loss.weight(v), rtol=1e-6)
    second = ((v + h) * loss.weight(v + h) - (v - h) * loss.weight(v - h)) / (2 * h)
    np.testing.assert_allclose(second, loss.slope(v), rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(loss.value(np.array([1e-4])), 1e-8, rtol=1e-6)  # squares near zero


@pytest.mark.parametrize("name", ROBUST)
def test_constants_give_95_percent_efficiency(name):
    loss, u = LOSSES[name], np.random.default_rng(0).normal(size=400_000)
    v = np.abs(u) / loss.constant
    efficiency = np.mean(loss.slope(v)) ** 2 / np.mean((u * loss.weight(v)) ** 2)
    assert efficiency == pytest.approx(0.95, abs=0.01)


@pytest.mark.parametrize("name", ROBUST)
def test_gradient_is_the_slope_of_the_cost(known, make, outliers, name):
    problem = make.problem(outliers.table, known, FREE, loss=LOSSES[name])
    x = np.array([known.values[name] for name in FREE]) / problem.scale * 1.05
    problem.limits = limits_of(problem, x)
    cost, gradient, matrix = problem.derivatives(x)
    assert cost == problem.cost(x) < replace(problem, limits=None).cost(x)
    for i in range(len(x)):
        away = np.zeros_like(x)
        away[i] = 1e-6
        slope = (problem.cost(x + away) - problem.cost(x - away)) / 2e-6
        assert gradient[i] == pytest.approx(slope, rel=1e-4, abs=1e-8)
    assert np.linalg.eigvalsh(matrix)[0] > 0


def test_noise_weights_ignore_outliers(known, make, outliers):
    problems = [make.problem(outliers.table, known, ("PDY1",), loss=loss) for loss in LOSSES.values()]
    x = np.ones(1)  # scaled
    squares, *robust = (1 / np.sqrt(noise_weights(problem, x)[0, 1] * len(outliers)) for problem in problems)
    assert squares > 5 * SIZE
    assert robust == pytest.approx([SIZE, SIZE], rel=0.15)
    assert limits_of(problems[0], x) is None
    assert limits_of(problems[1], x)[0, 1] == pytest.approx(1.345 * SIZE, rel=0.15)


def test_robust_scale_of_no_residuals_is_zero():
    assert robust_scale(np.zeros(0)) == 0.0


def test_robust_losses_resist_outliers_and_squares_do_not(known, make, outliers):
    table = outliers.with_signs("adapted-sae").table
    inputs = {name: table[name].to_numpy() for name in known.inputs}
    true = known.forces(**inputs)["Fy"]
    errors, intervals = {}, {}
    for loss in LOSSES:
        result = make.fit(outliers, loss=loss)
        assert result.ok, (loss, result.status)
        fitted = result.tire.in_signs("adapted-sae").forces(**inputs)["Fy"]
        errors[loss] = float(np.sqrt(np.mean((fitted - true) ** 2)))
        intervals[loss] = make.coefficients(result)["PDY1"].interval
    assert errors["squares"] > SIZE  # the error exceeds the noise
    assert max(errors["huber"], errors["cauchy"]) < 0.4 * SIZE
    assert max(intervals["huber"], intervals["cauchy"]) < 0.5 * intervals["squares"]
