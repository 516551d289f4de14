"""Cost, gradient and Gauss-Newton matrix against dense NumPy and finite differences; the weights."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest

from tirefmu.fitting.problem import LOSSES, MIN_NOISE, Problem, Rows, emphasis, equal_weights, limits_of, noise_weights
from tirefmu.fitting.problem import rows as rows_module
from tirefmu.fitting.problem import weighted_residuals as module
from tirefmu.fitting.solvers import noise_of
from tirefmu.fitting.uncertainty.sandwich import sandwich
from tirefmu.tires.code import code_for, fastest_code
from tirefmu.tires.code.normal_equations import equations_by_chunks

FREE = ("PCX1", "PDX2", "PKX1", "RBX1", "PCY1", "PKY1", "PKY2", "PVY3", "PHY1", "RBY2", "QBZ1", "QDZ8", "QBZ9")


@pytest.fixture(params=["all", "no load_stiffness"])
def problem(known, make, request):
    """Return a problem with gaps in the data, two recordings, weights and scales of all sizes."""
    tire = known
    if request.param == "no load_stiffness":  # the parameter vector then holds another PKY1 than the tire
        tire = replace(known, effects=tuple(e for e in known.has if e != "load_stiffness"))
    free = tuple(name for name in FREE if name != "PKY2" or "load_stiffness" in tire.has)
    rng = np.random.default_rng(2)
    inputs = np.stack([make.anywhere(60)[name] for name in tire.inputs])
    measured = code_for("mf96", "numpy").forces(inputs, tire.parameters()).T
    measured = measured * (1 + 0.1 * rng.standard_normal(measured.shape))
    measured[rng.random(measured.shape) < 0.2] = np.nan
    rows = Rows(inputs, measured, np.repeat([0, 1], 30))
    weights = rng.uniform(0.1, 1.0, (2, 3)) / [1e6, 1e6, 1e3]
    return Problem(tire, rows, free, weights, rng.uniform(0.1, 10.0, len(free)))


@pytest.fixture
def x(problem):
    """Return scaled values near those of the tire."""
    own = np.array([problem.tire.values[name] for name in problem.free])
    return own * np.random.default_rng(4).uniform(0.8, 1.2, len(own)) / problem.scale


def weighted_residual(problem, x):
    """The residual of a tire with these values: (forces - measured) sqrt(w) at measured rows."""
    values = dict(zip(problem.free, x * problem.scale, strict=True))
    tire = replace(problem.tire, values={**problem.tire.values, **values})
    forces = tire.forces(**dict(zip(tire.inputs, problem.rows.inputs, strict=True)))
    residual = np.stack([forces[name] for name in tire.outputs], axis=1) - problem.rows.measured
    root = np.sqrt(problem.weights)[problem.rows.group]
    return (residual * root)[np.isfinite(problem.rows.measured)]


def jacobian(problem, x, step=1e-6):
    columns = []
    for i in range(len(x)):
        away = np.zeros_like(x)
        away[i] = step * max(1.0, abs(x[i]))
        difference = weighted_residual(problem, x + away) - weighted_residual(problem, x - away)
        columns.append(difference / (2 * away[i]))
    return np.stack(columns, axis=1)


def test_cost_is_half_the_weighted_sum_of_squares(problem, x):
    expected = 0.5 * np.sum(weighted_residual(problem, x) ** 2)
    assert problem.cost(x) == pytest.approx(expected, rel=1e-12)
    assert problem.derivatives(x)[0] == pytest.approx(expected, rel=1e-12)


def test_gradient_and_matrix_are_those_of_the_residual(problem, x):
    J, r = jacobian(problem, x), weighted_residual(problem, x)
    _, gradient, matrix = problem.derivatives(x)
    np.testing.assert_allclose(gradient, J.T @ r, rtol=1e-5, atol=1e-7 * np.abs(J.T @ r).max())
    np.testing.assert_allclose(matrix, J.T @ J, rtol=1e-5, atol=1e-7 * np.abs(J.T @ J).max())
    assert np.all(np.diag(matrix) > 0)  # each free coefficient is seen


def test_the_sum_over_chunks_is_the_total(problem, x, monkeypatch):
    whole = problem.derivatives(x)
    monkeypatch.setattr(module, "CHUNK", 7)
    monkeypatch.setattr(module, "normal_equations", partial(equations_by_chunks, size=7))
    for one, other in zip(whole, problem.derivatives(x), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)
    np.testing.assert_allclose(problem.costs(x[None, :], np.array([np.inf])), whole[0], rtol=1e-12)


def test_unmeasured_rows_have_no_influence(problem, x):
    missing = np.isnan(problem.rows.measured).all(axis=1)
    assert not missing.all()
    silent = replace(problem.rows, measured=np.where(np.arange(60)[:, None] < 20, np.nan, problem.rows.measured))
    moved = replace(silent, inputs=np.where(np.arange(60) < 20, 0.5 * silent.inputs, silent.inputs))
    a, b = (Problem(problem.tire, rows, problem.free, problem.weights, problem.scale) for rows in (silent, moved))
    for one, other in zip(a.derivatives(x), b.derivatives(x), strict=True):
        np.testing.assert_array_equal(one, other)


# ------------------------------------------------------------------ weights


def test_equal_weights_give_the_cost_of_the_report(problem, x):
    problem.weights = equal_weights(problem.rows)
    values = dict(zip(problem.free, x * problem.scale, strict=True))
    forces = replace(problem.tire, values={**problem.tire.values, **values}).forces(
        **dict(zip(problem.tire.inputs, problem.rows.inputs, strict=True))
    )
    unexplained = 0.0
    for i, name in enumerate(problem.tire.outputs):
        measured = problem.rows.measured[:, i]
        unexplained += np.nansum((forces[name] - measured) ** 2) / np.nansum(measured**2)
    assert problem.cost(x) == pytest.approx(0.5 * unexplained, rel=1e-12)


def test_a_channel_of_zeros_has_a_finite_weight(problem):
    measured = problem.rows.measured.copy()
    measured[:, 0], measured[:, 2] = np.nan, 0.0
    assert np.isfinite(equal_weights(replace(problem.rows, measured=measured))).all()


def test_noise_weights_normalize_each_recording_and_channel(problem, x):
    weights = noise_weights(problem, x)
    residual = weighted_residual(problem, x)  # with the weights as they were: the index of each number
    present = np.isfinite(problem.rows.measured)
    squares = np.zeros(problem.rows.measured.shape)
    squares[present] = residual**2
    squares *= (weights / problem.weights)[problem.rows.group]
    n = present.sum()
    for group in (0, 1):
        rows = problem.rows.group == group
        for channel in range(3):
            share = present[rows, channel].sum() / n
            assert squares[rows, channel].sum() == pytest.approx(share, rel=1e-9)
    problem.weights = weights
    assert problem.cost(x) == pytest.approx(0.5, rel=1e-9)


def test_noise_weights_of_exact_data_are_finite(known, make):
    inputs = np.stack([make.anywhere(20)[name] for name in known.inputs])
    measured = fastest_code("mf96").forces(inputs, known.parameters()).T
    rows = Rows(inputs, measured, np.zeros(20, dtype=np.int64))
    problem = Problem(known, rows, ("PDY1",), equal_weights(rows), np.ones(1))
    x = np.array([known.values["PDY1"]])
    assert problem.cost(x) == 0.0
    expected = 1 / (60 * MIN_NOISE**2 * np.mean(measured**2, axis=0))
    np.testing.assert_allclose(noise_weights(problem, x), expected[None, :], rtol=1e-12)


@pytest.mark.parametrize("loss", ["squares", "huber"])
def test_zeros_of_a_channel_without_residual_have_no_noise_weight(known, make, loss):
    """They have no scale: the computed moment is 0, too."""
    tire = replace(
        known, values={**known.values, **dict.fromkeys(("QDZ1", "QDZ2", "QDZ6", "QDZ7", "QDZ8", "QDZ9"), 0.0)}
    )
    inputs = np.stack([{**make.anywhere(20), "kappa": np.zeros(20)}[name] for name in tire.inputs])
    measured = 1.1 * fastest_code("mf96").forces(inputs, tire.parameters()).T
    assert not measured[:, 2].any()
    rows = Rows(inputs, measured, np.zeros(20, dtype=np.int64))
    problem = Problem(tire, rows, ("PDY1",), equal_weights(rows), np.ones(1), LOSSES[loss])
    x = np.array([tire.values["PDY1"]])
    problem.weights = noise_weights(problem, x)
    problem.limits = limits_of(problem, x)
    assert problem.weights[0, 2] == 0.0 < problem.weights[0, 1]
    assert np.isfinite(problem.cost(x))


def test_a_swept_channel_has_a_larger_weight():
    """Cornering tests dominate Fy, drive and brake tests Fx."""
    sweep, held = np.linspace(-0.2, 0.2, 400), np.repeat([-0.1, 0.0, 0.1, 0.05], 100)
    cornering = pd.DataFrame({"kappa": 0.0, "alpha": sweep, "recording": 0})
    driving = pd.DataFrame({"kappa": sweep, "alpha": held, "recording": 1})
    factors = emphasis(pd.concat([cornering, driving], ignore_index=True), ["Fx", "Fy", "Mx"])
    assert factors[1, 0] > 1.2 * factors[0, 0]
    assert factors[0, 1] > 1.2 * factors[1, 1]
    assert factors[0, 1] == factors[1, 0]
    assert factors[:, 2].tolist() == [1.0, 1.0]


# ------------------------------------------------------------------ rows


def test_rows_of_a_table(known):
    table = pd.DataFrame(
        {"alpha": [0.1, 0.2], "Fz": [500.0, 600.0], "Fy": [1.0, np.nan], "Mz": [3.0, 4.0], "recording": [0, 1]}
    )
    rows = Rows.of(table, known, ["Fy"])
    assert known.inputs == ("kappa", "alpha", "gamma", "Fz")
    assert known.outputs == ("Fx", "Fy", "Mz")
    np.testing.assert_array_equal(rows.inputs, [[0, 0], [0.1, 0.2], [0, 0], [500, 600]])
    np.testing.assert_array_equal(rows.measured, [[np.nan, 1, np.nan], [np.nan] * 3])
    np.testing.assert_array_equal(rows.group, [0, 1])
    assert len(rows) == 2
    alone = Rows.of(table[["alpha", "Fy"]], known, ["Fy", "Fx"])
    np.testing.assert_array_equal(alone.inputs[3], [known.values["FNOMIN"]] * 2)  # an absent input is nominal
    np.testing.assert_array_equal(alone.group, [0, 0])


def test_a_sample_is_random_and_reproducible(problem):
    rows = problem.rows
    one, two, other = rows.sample(25), rows.sample(25), rows.sample(25, seed=1)
    np.testing.assert_array_equal(one.inputs, two.inputs)
    np.testing.assert_array_equal(one.measured, two.measured)
    assert not np.array_equal(one.inputs, other.inputs)
    indices = [int(np.flatnonzero((row == rows.inputs.T).all(axis=1))[0]) for row in one.inputs.T]
    assert indices == sorted(set(indices))
    assert len(one) == 25
    assert len(set(np.diff(indices))) > 1  # not every k-th row
    np.testing.assert_array_equal(one.measured, rows.measured[indices])
    np.testing.assert_array_equal(one.group, rows.group[indices])
    assert rows.sample(60) is rows
    assert rows.sample(99) is rows


@pytest.mark.parametrize("loss", ["squares", "cauchy"])
def test_blocks_of_rows_are_all_rows(problem, x, loss, monkeypatch):
    """Cost, derivatives, residuals, weights, noise and intervals do not depend on the size of a block."""

    def computed():
        rows = replace(problem.rows, weight=np.random.default_rng(0).uniform(0.5, 1.5, len(problem.rows)))
        one = replace(problem, rows=rows, weights=equal_weights(rows), loss=LOSSES[loss])
        one.weights = noise_weights(one, x)
        one.limits = limits_of(one, x)
        return [one.weights, *one.derivatives(x), one.residual(x), *sandwich(one, x), noise_of(one, x)]

    whole = computed()
    for each in (rows_module, module):
        monkeypatch.setattr(each, "BLOCK", 7)
    for expected, found in zip(whole, computed(), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12 * np.max(np.abs(expected)))
