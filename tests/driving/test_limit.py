"""A drive with braking and driving at the limit, on tires that differ from their files in all directions."""

from __future__ import annotations

import numpy as np
import pytest
import road

import tirefmu
from tirefmu.applications.driving import estimate
from tirefmu.applications.driving.dynamics import FORM, N_COLUMNS, discrepancy_columns
from tirefmu.applications.driving.evaluation import evaluated, interval_data, values_of
from tirefmu.applications.driving.interval import BALANCE, interval_of
from tirefmu.symbolic.vehicle.quantities import CORNERS

AXLES = ("front", "rear")
#: Lateral factor that a longitudinal one follows, and the entry of the car by which it differs.
ALONG = {"LMUX": ("LMUY", "grip"), "LKX": ("LKY", "slip_stiffness")}
FACTORS = {
    "front": {"LMUX": 0.91, "LMUY": 0.75, "LKX": 1.1, "LKY": 1.12},
    "rear": {"LMUX": 0.72, "LMUY": 0.85, "LKX": 0.9, "LKY": 1.2},
}
SECONDS = 10.0


@pytest.fixture(scope="module")
def drive():
    logs, rows = road.made_drives([road.Truth(FACTORS, {})], ["brake"], [True], seed=2, seconds=SECONDS)
    return logs[0], {name: values[:, 0] for name, values in rows.items()}


@pytest.fixture(scope="module")
def at_the_limit(drive, car, tire):
    return tirefmu.drive(drive[0], vehicle=car, tire=tire)


def along(axle, name):
    """Return the true value of an entry of the car for a longitudinal factor."""
    lateral, entry = ALONG[name]
    return f"{entry}_{axle}", FACTORS[axle][name] / FACTORS[axle][lateral]


def unbalanced(answer, motion, truths):
    """Yield what the balance of both axles lacks at the true motion, per load (rms), in driving and in braking."""
    first, unknowns, car = answer.grid, answer.unknowns, answer.car
    interval = interval_of(car, answer.tires, unknowns, sampled=first.sampled, spins=CORNERS, step=first.step)
    at, t = np.empty(first.n_nodes), road.STEP * np.arange(len(motion["vx"]))
    at[first.left], at[first.right] = first.t - first.step / 2, first.t + first.step / 2
    states = np.stack([np.interp(at, t, motion[name]) for name in ("vx", "vy", "yaw_rate")], axis=1)
    ax = np.interp(first.t, t, motion["ax"])
    for true in truths:
        names = [*unknowns.car, *unknowns.factors]
        z = np.zeros(len(names))
        for name, factor in true.items():
            z[names.index(name)] = np.log(factor) / unknowns.spread[names.index(name)] * car.values.get(name, 1.0)
        grid = estimate._moved(first, interval, states, answer.log, car, unknowns.car_values(car, z))
        added = estimate.curved(grid, interval, estimate.no_forces(grid, states, z), states, z)
        lacking = (
            estimate.values_of(interval.value_chunk, grid, states, z, estimate.interval_data(grid)) + added.correction
        )[:, -len(BALANCE) :]
        yield [float(np.sqrt(np.mean(lacking[rows] ** 2))) for rows in (ax > 1.0, ax < -1.5)]


def test_the_forces_of_the_true_motion_are_balanced_if_the_tires_are_right_along_the_wheel(at_the_limit, drive):
    lateral = {(axle, name): FACTORS[axle][name] for axle in AXLES for name in ("LMUY", "LKY")}
    lateral["brake_front"] = 0.72 / at_the_limit.car.values["brake_front"]
    all_of = lateral | dict(along(axle, name) for axle in AXLES for name in ALONG)
    without, whole = unbalanced(at_the_limit, drive[1], [lateral, all_of])
    assert max(whole) < 0.005
    assert max(without) > 2.0 * max(whole)


def test_driving_and_braking_at_the_limit_contradict_no_car(at_the_limit):
    assert at_the_limit.ok
    assert at_the_limit.verdict.contradiction.p > 1e-3
    assert not at_the_limit.verdict.car
    assert not at_the_limit.verdict.check
    for axle in AXLES:
        for name, factor in at_the_limit.factors[axle].items():
            assert factor.low < FACTORS[axle][name] < factor.high, (axle, name)
    assert at_the_limit.factors["front"]["LMUY"].differs


def test_the_discrepancy_has_the_same_part_of_the_integral_as_the_factors(at_the_limit):
    """LMUY and LKY together scale the side force, as the first coefficient of the discrepancy does."""
    grid, unknowns, final = at_the_limit.grid, at_the_limit.unknowns, at_the_limit.estimate
    given = at_the_limit.car, at_the_limit.tires, unknowns
    interval, n = interval_of(*given, sampled=grid.sampled, spins=CORNERS, step=grid.step), len(unknowns)
    values = estimate.values_of(interval.value_chunk, grid, final.states, final.z[:n], estimate.interval_data(grid))
    entries = unknowns.car_values(at_the_limit.car, final.z)
    columns = discrepancy_columns(grid, final.states, entries, values[:, -len(BALANCE) :], final.size)
    added = estimate.no_forces(grid, final.states, final.z).and_columns(*columns)
    weights = np.ones((len(grid.t), len(interval.residuals)))
    problem = estimate.MotionProblem(grid, interval, added, final.z, final.deviations, weights)
    slope = problem.solved(final.states).volume_slope()
    for first, axle in zip((n, n + N_COLUMNS), AXLES, strict=True):
        places = [unknowns.factor(axle, name) for name in ("LMUY", "LKY")]
        assert slope[first] / FORM == pytest.approx(np.sum(slope[places] / unknowns.spread[places]), rel=0.3)


def test_compiled_functions_of_an_interval_are_those_of_casadi(at_the_limit, monkeypatch):
    """And derivatives by the nodes alone are those of all derivatives."""
    grid, unknowns, final = at_the_limit.grid, at_the_limit.unknowns, at_the_limit.estimate
    given, chosen = (at_the_limit.car, at_the_limit.tires, unknowns), {"sampled": grid.sampled, "spins": CORNERS}
    compiled = interval_of(*given, **chosen, step=grid.step)
    monkeypatch.setattr("tirefmu.applications.driving.interval.compiled", lambda function, flags: function)
    plain, z, data = interval_of(*given, **chosen, step=grid.step), final.z[: len(unknowns)], interval_data(grid)
    shares = np.random.default_rng(1).normal(size=(len(grid.t), len(plain.residuals) * 2 * final.states.shape[1]))
    for name, more in (("node", None), ("residual", None), ("volume", shares)):
        one, other = (
            evaluated(getattr(interval, f"{name}_chunk"), grid, final.states, z, data, more)
            for interval in (compiled, plain)
        )
        np.testing.assert_allclose(one.values, other.values, rtol=1e-9, atol=1e-9)
        for ours, theirs in zip((one.by_nodes, *one.by_z), (other.by_nodes, *other.by_z), strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9 * np.abs(ours).max(initial=0.0))
    nodes, whole = (
        evaluated(function, grid, final.states, z, data) for function in (compiled.node_chunk, compiled.residual_chunk)
    )
    np.testing.assert_allclose(nodes.values, whole.values, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(
        values_of(compiled.value_chunk, grid, final.states, z, data), whole.values, rtol=1e-9, atol=1e-9
    )
    np.testing.assert_allclose(nodes.by_nodes, whole.by_nodes, rtol=1e-9, atol=1e-6)


def test_residuals_depend_on_the_stated_unknowns_alone(at_the_limit):
    grid, unknowns, final = at_the_limit.grid, at_the_limit.unknowns, at_the_limit.estimate
    given = at_the_limit.car, at_the_limit.tires, unknowns
    interval = interval_of(*given, sampled=grid.sampled, spins=CORNERS, step=grid.step)
    z, data, step = final.z[: len(unknowns)], interval_data(grid), 1e-5
    linear = evaluated(interval.residual_chunk, grid, final.states, z, data)
    by_all, of_all = (
        evaluated(interval.residual_chunk, grid, final.states, z, data, further=further).by_all(slice(None), len(z) + 2)
        for further in (None, 2)
    )
    np.testing.assert_array_equal(by_all, of_all)
    assert min(len(depends) for depends in linear.depends) < 5
    for i, shift in enumerate(step * np.eye(len(z))):
        ends = [values_of(interval.value_chunk, grid, final.states, z + side * shift, data) for side in (-1.0, 1.0)]
        slope = (ends[1] - ends[0]) / (2.0 * step)
        np.testing.assert_allclose(by_all[:, :, i], slope, rtol=1e-3, atol=1e-5 * np.abs(by_all).max())


def test_friction_along_the_wheel_is_estimated(at_the_limit):
    entries = at_the_limit.to_json()["car"]["entries"]
    name, value = along("rear", "LMUX")
    assert entries[name]["uncertainty"] < 0.7 * entries[name]["given_uncertainty"]
    assert entries[name]["value"] == pytest.approx(value, abs=3.0 * entries[name]["uncertainty"])


def test_every_part_of_a_drive_at_the_limit_is_predicted_better(at_the_limit):
    assert at_the_limit.written
    for _, _, before, after in at_the_limit.verdict.left_out.parts:
        assert after < before
