"""Bootstrap: the laws that connect it with the linear analysis."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from tirefmu.boundary.errors import FitError
from tirefmu.fitting import fit
from tirefmu.fitting.resampling import (
    MIN_SWEEPS,
    bootstrap_of,
    check_replicates,
    corrections,
    corrections_of,
    replicate_tasks,
    replicates_of,
    sweeps_of,
)
from tirefmu.fitting.uncertainty.sandwich import sandwich
from tirefmu.measurements import Noise


@pytest.fixture(scope="module")
def noisy(known, make):
    """Return a fit of twelve sweeps with noise, and their recording."""
    recording = make.sideways(known, noise=Noise())
    options = {"effects": make.effects, "nominal": make.nominal, "recipe": "joint", "sensor_errors": False}
    return fit([recording], "mf96", **options), recording


@pytest.fixture(scope="module")
def replicated(noisy):
    """Return the tasks of a bootstrap and its replicates."""
    result, recording = noisy
    tasks = replicate_tasks(result, [recording], 60, seed=3)
    return tasks, np.concatenate([replicates_of(task) for task in tasks])


def test_a_sweep_is_a_block(noisy):
    sweeps = sweeps_of([noisy[1]] * 2)
    assert len(np.unique(sweeps)) == 24
    assert (np.diff(sweeps) >= 0).all()


def test_the_replicates_have_the_covariance_of_sweeps_as_clusters(noisy, replicated):
    """To first order: H^-1 (sum over sweeps of g g') H^-1, with the gradient g of each sweep. 60 replicates: 9 %."""
    result, tasks, values = noisy[0], *replicated
    (stage,) = tasks[0].stages
    problem = stage.problem
    curvature = sandwich(problem, stage.x)[0] + stage.ridge * np.eye(len(stage.x))
    gradients = []
    for sweep in np.unique(tasks[0].sweeps):
        weight = np.where(tasks[0].sweeps[stage.numbers] == sweep, problem.rows.weight, 0.0)
        own = replace(problem, rows=replace(problem.rows, weight=weight), targets=())
        gradients.append(own.derivatives(stage.x)[1])
    changes = np.linalg.solve(curvature, np.array(gradients).T) * problem.scale[:, None]
    expected = dict(zip(problem.free, np.sqrt(np.sum(changes**2, axis=1)), strict=True))
    found = dict(zip(problem.free, values.std(axis=0, ddof=1), strict=True))
    inside = [one.name for one in result.coefficients if np.isfinite(one.interval)]
    ratios = np.array([found[name] / expected[name] for name in inside])
    assert len(ratios) > 8
    assert 0.8 < np.median(ratios) < 1.25


def test_a_replicate_depends_on_its_number_only(noisy, replicated):
    """So the results are those of any number of workers; a task can be sent to another process."""
    tasks, values = replicated
    task = pickle.loads(pickle.dumps(tasks[1]))
    single = replicates_of(replace(task, numbers=task.numbers[4:5]))
    np.testing.assert_allclose(single[0], values[task.numbers[4]], rtol=1e-9)
    other = replicates_of(replace(task, seed=4, numbers=task.numbers[4:5]))
    assert not np.allclose(other, single, rtol=1e-4)


def test_deviations_are_those_of_fits_to_new_noise_if_multiplied_by_the_leverage():
    """Exactly so for a linear problem with independent noise: a mean over many draws of noise, 1 % of it is random."""
    rng = np.random.default_rng(0)
    sweep = np.repeat(np.arange(12), 9)
    # The last two coefficients are of three sweeps each: the fit follows these most.
    own = [np.isin(sweep, some)[:, None] * rng.normal(size=(len(sweep), 1)) for some in ((0, 1, 2), (5, 6, 7))]
    matrix = np.hstack([rng.normal(size=(len(sweep), 4)), *own])
    blocks = [matrix[sweep == number] for number in range(12)]
    inverse = np.linalg.inv(matrix.T @ matrix)
    noise = rng.normal(size=(20_000, len(sweep)))
    residual = noise - noise @ matrix @ inverse @ matrix.T
    scores = [residual[:, sweep == number] @ block @ inverse for number, block in enumerate(blocks)]
    estimated = np.mean(np.sum(np.square(scores), axis=0), axis=0)
    leverage, freedom = corrections_of(matrix.T @ matrix, [block.T @ block for block in blocks])
    np.testing.assert_allclose(estimated * leverage**2, np.diag(inverse), rtol=0.03)
    assert (leverage[4:] ** 2 > 1.2).all()
    np.testing.assert_allclose(freedom[4:], 3.0, atol=0.5)
    assert (freedom[:4] > 5.0).all()


def test_a_coefficient_at_a_bound_has_no_correction(replicated):
    task = replicated[0][0]
    stage, determined = task.stages[0], task.determined[0]
    fixed = stage.problem.free.index("PKY1")
    lower = np.where(np.arange(len(stage.x)) == fixed, stage.x, stage.lower)
    found = corrections(replace(stage, bounds=np.array([lower, stage.upper])), determined, task.sweeps)
    assert "PKY1" not in found
    assert found.keys() == corrections(stage, determined, task.sweeps).keys() - {"PKY1"}


def test_expanded_percentiles_are_those_of_converged_replicates_in_the_signs_of_the_result(noisy, replicated):
    result, tasks, values = noisy[0], *replicated
    values = values.copy()
    values[7] = np.nan
    found = bootstrap_of(result, tasks, values)
    assert (found.bootstrap.replicates, found.bootstrap.failed, found.bootstrap.sweeps) == (59, 1, 12)
    free = tasks[0].stages[0].problem.free
    column = np.delete(values[:, free.index("PKY1")], 7)  # adapted SAE, where the stiffness is positive
    interval = found.bootstrap.interval("PKY1")
    stage = tasks[0].stages[0]
    value = stage.x[free.index("PKY1")] * stage.problem.scale[free.index("PKY1")]
    correction = corrections(stage, tasks[0].determined[0], tasks[0].sweeps)["PKY1"]
    assert correction.expansion > correction.leverage > 1.0
    expected = value + correction.expansion * (np.percentile(column, [2.5, 97.5], method="weibull") - value)
    np.testing.assert_allclose([-interval.upper, -interval.lower], expected)
    np.testing.assert_allclose(interval.deviation, correction.leverage * column.std(ddof=1))
    assert found.in_signs("adapted-sae").bootstrap.interval("PKY1").lower == -interval.upper
    assert found.to_json()["bootstrap"]["intervals"][0].keys() == {"name", "lower", "upper", "deviation"}
    values[10:] = np.nan
    with pytest.raises(FitError, match="9 of 60 replicates converged"):
        bootstrap_of(result, tasks, values)


def test_a_bootstrap_needs_sweeps_and_replicates(noisy, known, make):
    result, recording = noisy
    with pytest.raises(FitError, match="5 bootstrap replicates: at least 40"):
        replicate_tasks(result, [recording], 5, 0)
    short = make.sideways(known, loads=(500.0, 800.0), cambers=(0.0, 2.0))
    with pytest.raises(FitError, match=f"4 sweeps in the recordings, at least {MIN_SWEEPS} are"):
        check_replicates(100, [short])
    with pytest.raises(FitError, match="the tables are not those of the fit"):
        replicate_tasks(result, [short], 100, 0)
    with pytest.raises(FitError, match="no stage of the fit used all of its rows"):
        replicate_tasks(replace(result, run=replace(result.run, stages=())), [recording], 100, 0)
