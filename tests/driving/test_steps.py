"""Steps of the estimate of a drive: of unknowns within limits, of deviations, and the motion that it begins with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag

from tirefmu.applications.driving import estimate
from tirefmu.applications.driving.effects import effect_columns, factor_values, motion_of
from tirefmu.applications.driving.interval import interval_of
from tirefmu.symbolic.vehicle.quantities import CORNERS


@pytest.fixture(scope="module")
def factored(answer):
    """Return the residuals of some intervals of two chains, their factor, the dense Jacobian, how many unknowns."""
    rows = np.r_[20:50, 70:95]
    grid, _ = answer.grid.part(rows)
    linear, n, n_z = answer.estimate.residuals.part(rows), answer.estimate.states.shape[1], len(answer.estimate.z)
    n_residuals = linear.values.shape[1]
    dense = np.zeros((len(rows), n_residuals, grid.n_nodes * n + n_z))
    for k, ends in enumerate(zip(grid.left, grid.right, strict=True)):
        for place, node in enumerate(ends):
            dense[k, :, node * n : (node + 1) * n] += linear.by_nodes[k, :, place * n : (place + 1) * n]
        for i, (by_z, depends) in enumerate(zip(linear.by_z, linear.depends, strict=True)):
            dense[k, i, depends - n_z] = by_z[k]
    return linear, estimate.Factor(grid, linear), dense, n_z


def test_what_motion_and_unknowns_leave_of_residuals_is_that_of_the_dense_problem(factored):
    linear, factor, dense, n_z = factored
    J = dense.reshape(-1, dense.shape[2])
    prior = block_diag(np.zeros((J.shape[1] - n_z,) * 2), np.eye(n_z))
    rest = np.eye(len(J)) - J @ np.linalg.solve(J.T @ J + prior + 1e-9 * np.diag(np.diag(J.T @ J)), J.T)
    kinds = np.array([0, 2, linear.values.shape[1] - 1])
    of_kinds = [np.where(np.arange(linear.values.shape[1]) == kind, linear.values, 0.0).ravel() for kind in kinds]
    wanted = np.array([[one @ rest @ other for other in of_kinds] for one in of_kinds])
    found = factor.unexplained(linear.values, kinds)
    np.testing.assert_allclose(found, wanted, rtol=1e-3, atol=1e-4 * np.abs(wanted).max())
    assert np.linalg.eigvalsh(found).min() > 0.0


def test_an_unknown_at_its_limit_stays_there_and_the_others_go_as_if_it_were_given(factored):
    _, factor, _, n_z = factored
    z, free, wide = np.zeros(n_z), np.ones(n_z, dtype=bool), np.full((2, n_z), estimate.LARGEST) * [[-1.0], [1.0]]
    slope, alone = factor.slope(z), factor.step(z, z, free, estimate.LARGEST, wide)[1]
    for place in np.flatnonzero(slope * alone < 0.0)[[0, -1]]:
        limits, side = wide.copy(), int(slope[place] < 0.0)  # a step would pass this one
        limits[side, place] = 0.0
        _, change = factor.step(z, z, free, estimate.LARGEST, limits)
        _, given = factor.step(z, z, free & (np.arange(n_z) != place), estimate.LARGEST, wide)
        assert change[place] == 0.0
        np.testing.assert_allclose(change, given, rtol=1e-9, atol=1e-12)
        limits[:, place] = np.where(np.arange(2) == side, wide[:, place], 0.0)  # away from a limit, it is free
        assert factor.step(z, z, free, estimate.LARGEST, limits)[1][place] == alone[place]
    assert np.abs(factor.step(z, z, free, 0.1, wide)[1]).max() == pytest.approx(0.1)


def test_limits_of_an_effect_are_the_bounds_of_its_coefficients(answer):
    motion = motion_of(answer.grid, answer.estimate, answer.unknowns, answer.car)
    seen = set()
    for missing, u, _ in effect_columns(motion, answer.tires, factor_values(answer.unknowns, answer.estimate.z)):
        limits, declared = missing.limits(len(u)), missing.tires["front"].symbolic_model.coefficients
        assert (limits[0] < limits[1]).all()
        for side, name in ((0, "lower"), (1, "upper")):
            at, beyond = missing.values(limits[side]), missing.values(2.0 * limits[side] + [-1.0, 1.0][side])
            for i, key in enumerate(missing.center):
                if abs(limits[side, i]) < estimate.LARGEST:
                    seen.add(name)
                    bound = pytest.approx(getattr(declared[key], name), rel=1e-9, abs=1e-12)
                    assert at[key] == bound
                    assert beyond[key] == bound
    assert seen == {"lower", "upper"}


def test_a_motion_without_side_slip_leads_to_that_of_the_answer(answer):
    """Of the same car: lags of a wrong motion are those of a wrong motion, so that it is found with wide deviations."""
    final, unknowns, car = answer.estimate, answer.unknowns, answer.car
    interval = interval_of(
        car, answer.tires, unknowns, sampled=answer.grid.sampled, spins=CORNERS, step=answer.grid.step
    )
    start = final.states.copy()
    start[:, 1] = 0.0
    _, found = estimate._estimated(
        answer.grid, start, interval, unknowns, answer.log, car, estimate.no_forces, part=final
    )
    assert found.converged
    deviation = np.sqrt(np.diag(final.covariance))
    assert np.abs((found.z - final.z) / deviation).max() < 0.5
    assert found.evidence == pytest.approx(final.evidence, abs=2.0)


def test_a_restart_finds_the_optimum_from_its_car_alone_and_never_a_worse_one(answer):
    unknowns, n_car = answer.unknowns, len(answer.unknowns.car)
    interval = interval_of(
        answer.car, answer.tires, unknowns, sampled=answer.grid.sampled, spins=CORNERS, step=answer.grid.step
    )
    given = interval, unknowns, answer.estimate.states, answer.log, answer.car
    z = answer.estimate.z.copy()
    z[n_car : len(unknowns)] += 3.0  # factors that belong to no such car
    beside = replace(answer.estimate, z=z, evidence=answer.estimate.evidence - 100.0)
    _, found = estimate.restarted(answer.grid, *given, beside)
    np.testing.assert_allclose(found.z[n_car : len(unknowns)], answer.estimate.z[n_car : len(unknowns)], atol=0.02)
    assert found.evidence == pytest.approx(answer.estimate.evidence, abs=2.0)
    best = replace(answer.estimate, evidence=found.evidence + 1.0)
    assert estimate.restarted(answer.grid, *given, best)[1] is best


def test_forces_that_hide_the_priors_end_an_estimate_that_did_not_converge(answer, monkeypatch):
    unknowns = answer.unknowns
    interval = interval_of(
        answer.car, answer.tires, unknowns, sampled=answer.grid.sampled, spins=CORNERS, step=answer.grid.step
    )
    inverted = np.linalg.inv

    def rounded(matrix):
        return inverted(matrix) - (np.eye(matrix.shape[-1]) if matrix.ndim == 2 else 0.0)

    monkeypatch.setattr(np.linalg, "inv", rounded)
    with np.errstate(invalid="raise"):
        _, found = estimate.estimated(answer.grid, interval, unknowns, answer.estimate.states, answer.log, answer.car)
    assert not found.converged
