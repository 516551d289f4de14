"""A drive of a known car on known tires: factors, forces, tires and files; refusals of logs that contradict the car."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import hidden
import numpy as np
import pandas as pd
import pytest
import road
from scipy.stats import chi2

import tirefmu
from tests.json_schemas import check_file, objections
from tirefmu.applications.driving import estimate, simulation
from tirefmu.applications.driving.dynamics import (
    DAMPING,
    SIZED,
    USUAL,
    behind_lags,
    heaving,
    measured_slips,
    size_of,
    wheel_motion,
    with_lags,
)
from tirefmu.applications.driving.effects import Missing, effect_columns, factor_values, motion_of
from tirefmu.applications.driving.estimate import estimated
from tirefmu.applications.driving.evaluation import curvature_of
from tirefmu.applications.driving.factors import factors_of, scaled_tires, withheld
from tirefmu.applications.driving.figures import write_drive
from tirefmu.applications.driving.inputs.car import Car, loads_of
from tirefmu.applications.driving.interval import OUTPUTS, Relaxation, interval_of
from tirefmu.applications.driving.rivals import (
    DriveExplanation,
    Rival,
    forces_of,
    nearby,
    probabilities_of,
    reestimated,
)
from tirefmu.applications.driving.trust.contradiction import chances_of_entries, contradiction_of
from tirefmu.applications.driving.trust.left_out import is_better
from tirefmu.applications.driving.verdict import (
    EffectFinding,
    _car_lines,
    _contradiction_line,
    _unidentified_line,
    car_findings,
)
from tirefmu.boundary.errors import DataError, TirefmuError
from tirefmu.commands.cli import main
from tirefmu.symbolic.vehicle.quantities import CORNERS
from tirefmu.tires import read_tir

AXLES = ("front", "rear")


def test_the_factors_are_those_of_the_truth(answer):
    truth = {"front": (0.8, 0.9), "rear": (0.84, 1.0)}
    for axle, values in truth.items():
        for name, value in zip(("LMUY", "LKY"), values, strict=True):
            factor = answer.factors[axle][name]
            assert factor.determined, (axle, name)
            assert factor.low < value < factor.high
            assert factor.value == pytest.approx(value, rel=0.05)
    assert answer.ok
    assert not answer.verdict.car
    assert {finding.effect for finding in answer.verdict.tires} >= {"friction is lower"}
    assert answer.verdict.lacking < 0.95  # the tires of the truth have no effect that those of the file lack


@pytest.fixture(scope="session")
def forces(answer):
    """Return the side forces of both axles per static load over the drive, and the length of an interval."""
    motion = motion_of(answer.grid, answer.estimate, answer.unknowns, answer.car)
    return motion.side_forces(dict(answer.scaled)), answer.grid.step


def shifts(answer, added, known):
    """Return by how many of their deviations forces that the estimate does not know move the factors.

    `known`: the coefficients of the discrepancy that the estimate has.
    """
    estimate, n = answer.estimate, len(answer.unknowns)
    both, _ = estimate.information(answer.grid, added[:, :, None])
    kept = [*range(n), *(n + np.flatnonzero(known))]
    covariance = np.linalg.inv(both[np.ix_(kept, kept)] + np.eye(len(kept)))
    moved, deviation = covariance @ both[kept, -1], np.sqrt(np.diag(covariance))
    return (moved / deviation)[len(answer.unknowns.car) : n]


def late(force, step):
    return 0.015 * np.gradient(force, step, axis=0)


def inert(force, step):
    return 0.002 * np.gradient(np.gradient(force, step, axis=0), step, axis=0)


def another_curve(force, step):
    return 0.02 * force * (force / np.abs(force).max(axis=0)) ** 2


@pytest.mark.parametrize(("error", "places"), [(late, (9, 10)), (inert, (11,)), (another_curve, (0, 1, 2))])
def test_what_a_car_has_and_no_entry_explains_is_no_factor(error, places, answer, forces):
    """Late forces, masses that move against the body, another curve: in one axle, of the size that cars have."""
    n = (len(answer.estimate.z) - len(answer.unknowns)) // 2
    for axle in (0, 1):
        added = error(*forces) * (np.arange(2) == axle)
        known = shifts(answer, added, np.ones(2 * n, dtype=bool))
        unknown = shifts(answer, added, ~np.isin(np.arange(2 * n) % n, places))
        assert np.abs(known).max() < 1.96
        assert np.abs(known).max() < 0.85 * np.abs(unknown).max()


def test_a_drive_shows_no_less_of_what_it_cannot_see(answer):
    assert answer.estimate.size >= USUAL
    none, some = np.zeros(SIZED.sum()), np.full(SIZED.sum(), 1.5)
    assert size_of(USUAL, none, none) == USUAL
    assert USUAL < size_of(USUAL, some, none) < size_of(USUAL, 6.0 * some, none)


@pytest.mark.slow
@pytest.mark.parametrize("missing", [["ax"], ["ax", "speed"]], ids=["no ax", "wheel speeds only"])
def test_without_an_accelerometer_the_factors_are_those_of_the_truth(missing, log, car, tire):
    answer = tirefmu.drive(log.drop(columns=missing), vehicle=car, tire=tire)
    assert answer.ok
    for axle, values in {"front": (0.8, 0.9), "rear": (0.84, 1.0)}.items():
        for name, value in zip(("LMUY", "LKY"), values, strict=True):
            factor = answer.factors[axle][name]
            assert factor.determined
            assert factor.low < value < factor.high
            # With wheel speeds only, the interval alone is right.
            assert "speed" in missing or factor.value == pytest.approx(value, rel=0.05)


def test_verdict_and_table_have_the_same_factors(answer):
    text = " ".join(answer.verdict.lines)
    for axle in ("front", "rear"):
        for name, factor in answer.factors[axle].items():
            assert factor.determined == (f"{name} {factor.value:.3g} ({factor.low:.3g} to {factor.high:.3g})" in text)
    for finding in answer.verdict.tires:
        factor = answer.factors[finding.axle][finding.name]
        assert factor.changed > 0.95
        assert factor.high < 1.0 if "lower" in finding.effect else factor.low > 1.0


def unidentified(verdict):
    return any(line.startswith("no effect that the tires lack is identified") for line in verdict.lines)


def test_an_effect_that_is_only_likely_is_no_finding(answer):
    likely = EffectFinding("relax_lat", {"SIGY": 0.4}, 0.5)
    line = _unidentified_line((likely,))
    assert line.startswith("no effect that the tires lack is identified")
    assert "relax_lat 0.50" in line
    assert unidentified(answer.verdict) == (bool(answer.verdict.effects) and not answer.verdict.effect)


def test_there_are_no_longitudinal_factors(answer):
    assert all(set(factors) == {"LMUY", "LKY"} for factors in answer.factors.values())
    assert answer.scaled["front"].values["LMUX"] == answer.tires["front"].values["LMUX"]


def test_lag_and_compliance_are_estimated_with_the_rest(answer):
    entries = answer.to_json()["car"]["entries"]
    assert entries["roll_lag"]["uncertainty"] < entries["roll_lag"]["given_uncertainty"]
    assert {"steer_front", "steer_rear", "ay_gain", "yaw_rate_gain", "misalignment", "wheel_delay"} <= entries.keys()


def test_nodes_that_alternate_have_no_curvature(answer):
    """The midpoint rule lets the nodes of a stiff car alternate: a correction that followed them would diverge."""
    grid = answer.grid
    alternating = np.where(np.arange(grid.n_nodes)[:, None] % 2, 0.1, -0.1) * np.ones(3)
    assert np.abs(curvature_of(grid, alternating)).max() < 1e-12
    parabola = (grid.step * np.arange(grid.n_nodes)[:, None]) ** 2 * np.ones(3)
    np.testing.assert_allclose(curvature_of(grid, parabola), 2.0 * grid.step**2, rtol=1e-6)


def test_longitudinal_slips_lag_by_the_relaxation_length_and_differ_by_the_radii(answer):
    grid, car, states = answer.grid, answer.car, answer.estimate.states
    length, loads = 0.3, np.array([0.0, 1e5])
    entries = {**answer.unknowns.car_values(car, answer.estimate.z), "relaxation": 1.0, "unequal_rear": 0.004}
    law = Relaxation(loads, np.full(2, length), 0.0)
    interval = SimpleNamespace(relaxations={(axle, of): law for axle in ("front", "rear") for of in "xy"})
    added, V = (
        with_lags(grid, interval, states, car, entries).behind[12:16],
        wheel_motion(grid, states, car, entries)[1],
    )
    slips, equal = (measured_slips(grid, V, car, {**entries, "unequal_rear": size}) for size in (0.004, 0.0))
    np.testing.assert_allclose(slips[2:] - equal[2:], np.array([[0.002], [-0.002]]) * (1.0 + equal[2:]), atol=1e-5)
    rate = np.gradient(slips + added, grid.step, axis=1)
    lacking = added + length / V * rate  # a first-order lag, but for what the grid does not resolve
    assert np.sqrt(np.mean(lacking**2)) < 0.3 * np.sqrt(np.mean(added**2))


def test_side_forces_that_nothing_explains_are_stated(car, tire):
    """Those that the discrepancy takes as well: the balance of forces with the tires as estimated."""

    def worse_in_braking(kappa, alpha, Fz, V, factors):
        Fx, Fy = road.tire_forces(kappa, alpha, Fz, V, factors)
        return Fx, Fy * (1.0 + 4.0 * np.minimum(kappa, 0.0))

    truth = road.Truth({axle: dict.fromkeys(("LMUX", "LMUY", "LKX", "LKY"), 1.0) for axle in AXLES}, {})
    logs, _ = road.made_drives([truth], ["brake"], [True], seed=5, seconds=6.0, tire=worse_in_braking)
    answer = tirefmu.drive(logs[0], vehicle=car, tire=tire)
    values = answer.estimate.outputs
    Fy, of_tires = (values[:, [OUTPUTS.index(f"{name}_{axle}") for axle in AXLES]] for name in ("Fy", "Fy_tire"))
    entries = answer.unknowns.car_values(answer.car, answer.estimate.z)
    balance, stated = 2.0 * (Fy - of_tires), answer.estimate.beyond * loads_of(entries)
    rms = np.sqrt(np.mean((stated - balance) ** 2, axis=0)), np.sqrt(np.mean(balance**2, axis=0))
    assert np.all(rms[0] < 0.4 * rms[1])  # but for the curvature of the motion within an interval


def test_turns_to_one_side_determine_no_factor(answer):
    """A ramp of the speed at one steering angle: an asymmetry of the car looks like a stiffness."""
    outputs, right = answer.estimate.outputs, np.array([name.startswith("Fy") for name in OUTPUTS])
    estimate = replace(answer.estimate, outputs=np.where(right, np.abs(outputs), outputs))
    factors = factors_of(estimate, answer.unknowns, answer.tires, answer.grid.step, {})
    reasons = {factor.reason for row in factors.values() for factor in row.values()}
    assert len(reasons) == 1
    assert "one side" in reasons.pop()


def test_a_shorter_car_is_simulated_over_shorter_pieces(car):
    short = replace(car, values={**car.values, "wheelbase": car.values["wheelbase"] / 16.0})
    assert simulation.horizon(short) == pytest.approx(simulation.horizon(car) / 4.0)


def test_new_tires_predict_the_parts_that_were_left_out(answer):
    content = answer.to_json()
    assert content["written"]
    assert content["left_out"]["after"]["yaw_rate"] < 0.7 * content["left_out"]["before"]["yaw_rate"]
    assert content["car"]["contradiction"]["p"] > 1e-3


def test_errors_without_a_common_sign_are_no_gain():
    before = np.array([1.0, 1.2, 0.9, 1.1, 1.0, 1.3])
    assert is_better(before, 0.8 * before)
    assert not is_better(before, before)
    assert not is_better(before, before * [0.5, 1.6, 0.7, 1.5, 1.1, 0.9])
    # One part that gains much more than the others is no reason to doubt them; one that loses is.
    assert is_better(before, before * [0.7, 0.8, 0.75, 0.8, 0.7, 1e-3])
    assert not is_better(before, before * [0.7, 0.8, 0.75, 0.8, 0.7, 1e3])
    for n in (3, 5):
        assert is_better(before[:n], before[:n] * [0.8, 0.81, 0.79, 0.8, 0.81][:n])
        assert not is_better(before[:n], before[:n] * [0.9, 1.2, 0.8, 0.9, 1.1][:n])


@pytest.mark.parametrize("evidence", [(-120.0, -57.0), (-57.0, -120.0)])
def test_the_more_probable_of_two_optima_is_the_answer(monkeypatch, evidence):
    """An estimate that did not converge is none; a part of a long log shows whether both starts end in one optimum."""
    first, second = (SimpleNamespace(evidence=value, converged=True) for value in evidence)
    wholes = []

    def from_one_start(grid, *_, part=None, together=False):
        if grid == "whole":
            wholes.append(part)
        return grid, (part or (second if together else first))

    monkeypatch.setattr(estimate, "_estimated", from_one_start)
    monkeypatch.setattr(estimate, "_samples", lambda grid: [])
    given = (None, None, np.zeros(3), None, None)
    assert estimate.estimated("whole", *given)[1].evidence == -57.0
    first.converged, second.converged = evidence[0] == -120.0, evidence[1] == -120.0
    assert estimate.estimated("whole", *given)[1].evidence == -120.0

    class Long(str):
        def part(self, rows):
            return "part", rows

    first.states = second.states = 1.0
    first.converged = second.converged = True
    monkeypatch.setattr(estimate, "_samples", lambda grid: [np.arange(1), np.arange(2)])
    wholes.clear()
    assert estimate.estimated(Long("whole"), *given)[1].evidence == -57.0
    assert len(wholes) == 2
    second.evidence = first.evidence + 0.1
    wholes.clear()
    estimate.estimated(Long("whole"), *given)
    assert len(wholes) == 1


@pytest.mark.parametrize("n", [799, 800, 2384, 4000, 12_000, 100_000])
def test_a_long_log_is_estimated_in_larger_and_larger_parts_that_are_spread_over_it(n):
    parts = list(estimate._samples(SimpleNamespace(t=np.arange(n))))
    assert [len(rows) for rows in parts] == [400 * 5**k for k in range(9) if 2 * 400 * 5**k <= n]
    for rows in parts:
        pieces = np.split(rows, np.flatnonzero(np.diff(rows) != 1) + 1)
        assert {len(piece) for piece in pieces} <= {100, *np.arange(1, n // 100 + 1) * 100}
        assert np.diff(rows).min() >= 1
        assert rows[0] >= 0
        assert rows[-1] < n
        thirds = np.histogram(rows, np.linspace(0, n, 5))[0]
        assert thirds.max() <= thirds.min() + 100


def test_a_joint_deviation_is_one_although_no_entry_alone_is(answer):
    n = len(answer.unknowns.car)
    sure = replace(answer.estimate, covariance=1e-6 * np.eye(len(answer.estimate.z)), scatter=0.0)
    wrong = contradiction_of(replace(sure, z=np.full(len(sure.z), 2.5)), answer.unknowns)
    right = contradiction_of(replace(sure, z=np.full(len(sure.z), 1.0)), answer.unknowns)
    far = np.sqrt(chi2.isf(1e-7, n) - (n - 1) * 0.5**2)  # with the others, ten times less probable than a contradiction
    alone = replace(sure, z=np.where(np.arange(len(sure.z)) == 0, far, 0.5))
    assert contradiction_of(alone, answer.unknowns).certain
    assert not contradiction_of(alone, answer.unknowns, answer.unknowns.car[0]).certain
    assert contradiction_of(alone, answer.unknowns, answer.unknowns.car[1]).certain
    assert wrong.degrees_of_freedom == n
    assert wrong.certain
    assert not right.certain
    assert not right.doubtful
    near = replace(right, deviation=float(chi2.isf(2e-6, n)), p=2e-6)
    assert near.doubtful
    assert not near.certain
    assert "no difference of the tires is certain" in _contradiction_line(near, sure, answer.unknowns)
    rough = replace(sure, z=np.full(len(sure.z), 2.5), converged=False)
    assert not contradiction_of(rough, answer.unknowns).certain


def with_deviations(answer, deviation, **z):
    """Return the estimate with given deviations of some unknowns by name, 0 of the others, all of one uncertainty."""
    unknowns = answer.unknowns
    names = [*unknowns.car, *(f"{name}_{axle}" for axle, name in unknowns.factors)]
    values = np.zeros(len(answer.estimate.z))
    values[[names.index(name) for name in z]] = list(z.values())
    covariance = deviation**2 * np.eye(len(values))
    return replace(answer.estimate, z=values, covariance=covariance, scatter=0.0)


def test_a_gross_entry_is_one_although_all_together_are_unremarkable(answer):
    estimate = with_deviations(answer, 0.5, mass=5.6, ratio=2.5)
    assert not contradiction_of(estimate, answer.unknowns).certain
    chances = chances_of_entries(estimate, answer.unknowns)
    assert chances["mass"] < 1e-6
    assert chances["ratio"] > 0.05  # one of all entries deviates as far by chance
    assert chances["wheelbase"] == pytest.approx(1.0)
    wrong = probabilities_of(answer.grid, estimate, answer.unknowns).car
    assert wrong["mass"] > 0.95
    assert wrong["ratio"] < 0.05


@pytest.mark.parametrize(
    ("deviation", "found", "checked"), [(1.0, set(), set()), (3.8, set(), {"mass"}), (5.6, {"mass"}, set())]
)
def test_an_entry_that_may_be_wrong_is_to_be_checked(deviation, found, checked, answer):
    estimate = with_deviations(answer, 0.3, mass=deviation, ratio=1.0)
    wrong = dict.fromkeys(answer.unknowns.car, 0.99 if deviation > 5.0 else 0.5)
    contradiction = contradiction_of(estimate, answer.unknowns)
    named, check = car_findings(estimate, answer.unknowns, answer.car, wrong, contradiction)
    assert ({entry.name for entry in named}, {entry.name for entry in check}) == (found, checked)
    lines = _car_lines(named, check, (), estimate)
    assert all("mass with driver and fuel" in line for line in lines)
    assert ("check the mass" in " ".join(lines)) == bool(checked)
    unfit = replace(estimate, converged=False)
    contradiction = contradiction_of(unfit, answer.unknowns)
    assert car_findings(unfit, answer.unknowns, answer.car, wrong, contradiction) == ((), ())


def test_effects_compete_by_estimates_of_the_whole_drive(answer):
    base, n = DriveExplanation(None, answer.grid, answer.estimate), len(answer.unknowns)
    none = Rival(None, np.zeros(0))
    first, second, third, unlikely = (
        Rival(
            Missing(name, answer.tires, {"PDY2": 0.0}, {"PDY2": 1.0}, frozenset()), np.zeros(1), gain=gain, power=power
        )
        for name, gain, power in (("a", 10.0, 0.5), ("b", 6.0, 0.9), ("c", 2.5, 0.9), ("d", -5.0, 0.5))
    )
    evidence, asked = {"a": 3.0, "b": 2.0}, []

    def refit(rival):
        asked.append(rival.missing.name)
        more = evidence.get(rival.missing.name)
        whole = replace(answer.estimate, evidence=answer.estimate.evidence + (more or 0.0))
        return DriveExplanation(rival.missing, answer.grid, whole) if more else None

    ranked, estimates = reestimated([none, first, second, unlikely], base, answer.unknowns, refit)
    by_name = {rival.missing.name if rival.missing else "": rival for rival in ranked}
    assert set(estimates) == {"a", "b"}
    # By their own powers, the one that explains less would be the likely one.
    assert by_name["a"].log_odds - by_name["b"].log_odds == pytest.approx(0.5)
    assert by_name["a"].u[0] == answer.estimate.z[n]
    assert by_name["d"].gain == unlikely.gain
    assert sum(rival.probability for rival in ranked) == pytest.approx(1.0)
    assert [rival.probability for rival in ranked] == sorted((rival.probability for rival in ranked), reverse=True)
    # The linearized evidence does not decide between effects: one that it shows far behind is estimated, and may win.
    asked.clear()
    ahead = replace(first, gain=40.0)
    evidence["b"] = 4.0
    ranked, _ = reestimated([none, ahead, second, unlikely], base, answer.unknowns, refit)
    assert asked == ["a", "b"]
    assert [rival.missing.name for rival in ranked if rival.missing][:2] == ["b", "a"]
    # An effect without an optimum may explain as much as the best one: no name is certain.
    ranked, estimates = reestimated([none, first, replace(third, gain=30.0)], base, answer.unknowns, refit)
    assert set(estimates) == {"a"}
    likely = [rival.log_odds for rival in ranked if rival.missing]
    assert likely[0] == pytest.approx(likely[1])
    # An effect without an optimum, and an unlikely one, have no estimate.
    ranked, estimates = reestimated([third, none, unlikely], base, answer.unknowns, refit)
    assert not estimates
    assert {rival.gain for rival in ranked} == {third.gain, none.gain, unlikely.gain}


def test_a_small_change_that_is_certain_is_a_change(answer):
    size = answer.unknowns.spread[-1]
    for error, value, changed in ((0.01, 1.06, True), (0.01, 1.01, False), (0.05, 1.06, False), (0.05, 1.4, True)):
        estimate = with_deviations(answer, error / size, LKY_rear=np.log(value) / size)
        probability = probabilities_of(answer.grid, estimate, answer.unknowns).factors["rear", "LKY"]
        assert (probability > 0.95) == changed, (error, value, probability)


def test_what_parts_of_a_drive_differ_by_is_no_contradiction(answer):
    z, sure = np.full(len(answer.estimate.z), 2.5), 1e-6 * np.eye(len(answer.estimate.z))
    narrow = replace(answer.estimate, z=z, covariance=sure, scatter=0.0)
    scatter = 4.0 * np.eye(len(z))
    assert contradiction_of(narrow, answer.unknowns).certain
    assert not contradiction_of(replace(narrow, covariance=sure + scatter, scatter=scatter), answer.unknowns).certain


def test_the_car_is_wrong_only_if_another_one_explains_the_drive_and_no_effect_does(answer):
    sure = replace(answer.estimate, z=np.full(len(answer.estimate.z), 2.5), scatter=0.0)
    wrong = contradiction_of(replace(sure, covariance=1e-6 * np.eye(len(sure.z))), answer.unknowns)
    lines = {}
    for key, case in {"car": wrong, "tires": replace(wrong, unless=("load_friction",)),
                      "neither": replace(wrong, explained=False)}.items():  # fmt: skip
        assert case.of_car == (key == "car")
        lines[key] = _contradiction_line(case, sure, answer.unknowns)
        assert lines[key].startswith("the drive contradicts the car file")
    assert "or the tires lack load_friction" in lines["tires"]
    assert "another car does not explain it" in lines["neither"]


def test_where_the_car_is_wrong_no_factor_is_determined(answer):
    for axle, row in withheld(answer.factors, "another car").items():
        for name, factor in row.items():
            assert not factor.determined
            assert not factor.differs
            assert factor.reason == (answer.factors[axle][name].reason or "another car")
            assert factor.value == answer.factors[axle][name].value


def test_a_delay_is_estimated(answer):
    entries = answer.to_json()["car"]["entries"]
    assert entries["delay"]["value"] == pytest.approx(-0.015, abs=0.004)


def test_the_simulated_vehicle_is_closer_on_the_new_tires(answer):
    for name, before in answer.before.rms.items():
        assert answer.after.rms[name] < 0.7 * before, name


def resimulated(answer, tires, **options):
    given = (answer.grid, answer.estimate, answer.unknowns, answer.car)
    return simulation.simulated(*given, tires, z=answer.estimate.z, **options)


def test_four_fmus_move_the_vehicle_as_the_generated_code_does(answer):
    on_fmus = resimulated(answer, answer.scaled, fmus=True)
    np.testing.assert_allclose(on_fmus.motion, answer.after.motion, rtol=1e-9, atol=1e-9)
    assert on_fmus.rms == pytest.approx(answer.after.rms, rel=1e-6)


def test_the_fmus_of_lagging_tires_lag(tire):
    lagging = replace(tire, effects={*tire.effects, "relax_lat"}, values={**tire.values, "SIGY": 0.5})
    t = 0.01 * np.arange(40)
    table = pd.DataFrame(
        {"t": t, "kappa": 0.01, "alpha": 0.05 * np.sin(20.0 * t), "gamma": 0.0, "Fz": 4000.0, "V": 15.0}
    )
    with simulation.fmu_forces({"front": tire, "rear": lagging}, 2) as forces:
        wheels = [
            {name: np.full((4, 2), row[name]) for name in ("kappa", "alpha", "gamma", "Fz", "V")}
            for _, row in table.iterrows()
        ]
        found = np.array([forces(inputs, 0.01) for inputs in wheels])[:, :, :, 1]
    for corner, expected in enumerate((tire, tire, lagging, lagging)):
        exact = expected.evaluate(table, signs="iso", hold=True)
        np.testing.assert_allclose(found[:, 0, corner], exact["Fx"], rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(found[:, 1, corner], exact["Fy"], rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize("fmus", [False, True])
def test_a_drive_too_short_to_simulate_has_an_answer_without_errors(fmus, answer, tmp_path, monkeypatch):
    monkeypatch.setattr(simulation, "HORIZON", 20.0)
    none = resimulated(answer, answer.scaled, fmus=fmus)
    content = replace(answer, before=none).to_json()
    assert set(content["simulation"]["before"].values()) == {None}
    assert objections("drive", json.loads(json.dumps(content, allow_nan=False))) == []
    write_drive(replace(answer, before=none), tmp_path / "report.html")
    assert '<td class="n">-</td>' in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_the_forces_are_a_recording(answer, tmp_path):
    written = answer.save(tmp_path)
    recording = tirefmu.read_recording(written[0])
    assert recording.measured() == ("Fy",)  # Fx over kappa would be the tire's own curve
    assert len(recording.segments()) == 2
    front = answer.wheels[answer.wheels["axle"] == 1]
    forces = answer.scaled["front"].forces(kappa=front["kappa"], alpha=front["alpha"], Fz=front["Fz"], code="numpy")
    assert np.sqrt(np.mean((forces["Fy"] - front["Fy"]) ** 2)) < 0.05 * front["Fy"].abs().max()
    assert read_tir(written[1]).values["LMUY"] == pytest.approx(answer.factors["front"]["LMUY"].value)


@pytest.fixture(scope="module")
def relaxing(car):
    """Return the answer to a drive on tires whose relaxation the file lacks, and their relaxation length, m."""
    (log,), _, _, (_, (length,)) = hidden.made(["relaxation"], seed=7, seconds=14.0)
    return tirefmu.drive(log, vehicle=car, tire=hidden.file_tire("relaxation")), length


@pytest.mark.slow
def test_a_relaxation_length_is_that_of_the_truth(relaxing):
    answer, length = relaxing
    likely = {finding.effect: finding.coefficients for finding in answer.verdict.effects}
    assert likely["relax_lat"]["SIGY"] == pytest.approx(length, rel=0.25)


@pytest.mark.slow
def test_an_effect_is_a_name_only_if_it_is_certain_and_predicts(relaxing):
    answer, _ = relaxing
    # 14 s do not separate a relaxation from all other effects: it is a likely one, and need not be the name.
    assert "relax_lat" in {finding.effect for finding in answer.verdict.effects}
    assert (answer.verdict.effect == "relax_lat") == (answer.verdict.lacking > 0.95)
    assert unidentified(answer.verdict) == (not answer.verdict.effect)
    assert "axle: the drive disagrees most with its tire file" in " ".join(answer.verdict.lines)


@pytest.mark.slow
def test_a_drive_estimated_with_an_effect_has_it_in_its_tires(relaxing):
    answer, length = relaxing
    interval = interval_of(
        answer.car, answer.tires, answer.unknowns, sampled=answer.grid.sampled, spins=CORNERS, step=answer.grid.step
    )
    given = interval, answer.unknowns, answer.estimate.states, answer.log, answer.car
    base = DriveExplanation(None, *estimated(answer.grid, *given))  # the answer itself may have the effect
    motion = motion_of(base.grid, base.estimate, answer.unknowns, answer.car)
    columns = effect_columns(motion, answer.tires, factor_values(answer.unknowns, base.estimate.z))
    missing, u = next((missing, u) for missing, u, _ in columns if missing.name == "relax_lat")
    forces = forces_of(Rival(missing, u), answer.unknowns, answer.car, base)
    near = nearby(Rival(missing, u), base, answer.unknowns)
    grid, estimate = estimated(base.grid, *given, forces, near)
    assert estimate.converged
    assert estimate.evidence > base.estimate.evidence
    found = estimate.z[len(answer.unknowns) :]
    assert missing.values(found)["SIGY"] == pytest.approx(length, rel=0.25)
    delivered = missing.delivered(found)
    assert delivered["front"].has - answer.tires["front"].has == {"relax_lat"}
    on_fmus = simulation.simulated(
        grid, estimate, answer.unknowns, answer.car, scaled_tires(delivered, answer.factors), z=estimate.z, fmus=True
    )
    assert on_fmus.rms["yaw_rate"] < 0.7 * answer.before.rms["yaw_rate"]


def the_forces_of(effect, answer):
    """Return the forces of an effect about the estimate of a drive, the start with it, and its typical size."""
    base = DriveExplanation(None, answer.grid, answer.estimate)
    motion = motion_of(answer.grid, answer.estimate, answer.unknowns, answer.car)
    columns = effect_columns(motion, answer.tires, factor_values(answer.unknowns, answer.estimate.z))
    rival = next(Rival(missing, size) for missing, size, _ in columns if missing.name == effect)
    near = nearby(rival, base, answer.unknowns)
    return forces_of(rival, answer.unknowns, answer.car, base), near, rival.u


@pytest.mark.parametrize("effect", ["heat_friction", "load_lag", "speed_friction", "wear_drift"])
def test_an_estimate_with_an_effect_in_proportion_begins_at_the_one_without(effect, answer):
    forces, near, _ = the_forces_of(effect, answer)
    at_start = forces(answer.grid, answer.estimate.states, near.z)
    assert not at_start.offset.any()
    assert not at_start.slopes.any()
    assert at_start.columns[:, :, len(answer.unknowns) :].any()


@pytest.mark.parametrize("entry", ["mass", "cg_height", "front_roll_share", "ratio"])
def test_forces_of_an_effect_follow_what_loads_and_slips_follow(entry, answer):
    forces, near, u = the_forces_of("load_curvature", answer)
    n, i = len(answer.unknowns), answer.unknowns.car.index(entry)
    z = np.concatenate([near.z[:n], u, near.z[n + len(u) :]])
    moved = z + 0.3 * (np.arange(len(z)) == i)
    middle = (answer.estimate.states[answer.grid.left] + answer.estimate.states[answer.grid.right])[:, :3] / 2

    def at(linear, z):
        forces = linear.offset + linear.columns @ z[: n + len(u)]
        return forces + np.einsum("kim,km->ki", linear.slopes, middle)

    here, there = (forces(answer.grid, answer.estimate.states, point) for point in (z, moved))
    change = at(there, moved) - at(here, z)
    assert np.abs(at(here, moved) - at(here, z) - change).max() < 0.1 * np.abs(change).max()


def test_an_unknown_at_its_bound_leaves_the_others_the_step_without_it(answer):
    factor, z = estimate.Factor(answer.grid, answer.estimate.residuals), answer.estimate.z
    slope, free = 30.0 * np.random.default_rng(5).normal(size=len(z)), np.ones(len(z), dtype=bool)
    wide = np.full((2, len(z)), np.inf) * [[-1.0], [1.0]]
    _, step = factor.step(slope, z, free, np.inf, wide)
    against = np.flatnonzero(step * factor.slope(slope) > 0.0)  # where it would pass only with the others
    assert len(against)
    for i in against:
        limits = wide.copy()
        limits[int(step[i] > 0.0), i] = z[i]
        _, bound = factor.step(slope, z, free, np.inf, limits)
        _, held = factor.step(slope, z, np.arange(len(z)) != i, np.inf, wide)
        np.testing.assert_allclose(bound, held, atol=1e-12)


def test_each_wheel_rolls_its_own_distance(answer):
    motion = motion_of(answer.grid, answer.estimate, answer.unknowns, answer.car)
    distances = np.concatenate([wheels["distance"].reshape(2, -1) for wheels in motion.wheels])
    assert not distances[:, 0].any()
    duration = motion.t[-1] - motion.t[0]
    np.testing.assert_allclose(distances[:, -1], motion.inputs["V"].mean(axis=1) * duration, rtol=0.01)


@pytest.mark.parametrize("effect", ["heat_friction", "relax_lat", "load_lag", "break_in", "hysteresis_force"])
def test_side_forces_of_an_effect_are_those_of_the_table(effect, answer):
    motion = motion_of(answer.grid, answer.estimate, answer.unknowns, answer.car)
    same = {axle: {} for axle in answer.tires}
    columns = effect_columns(motion, answer.tires, same)
    missing, u, added = next(column for column in columns if column[0].name == effect)
    tires = missing.on(u, same)
    tables = [pd.DataFrame({"t": np.tile(motion.t, 2), **wheels}) for wheels in motion.wheels]
    forces = [tire.evaluate(table, signs="iso")["Fy"] for tire, table in zip(tires.values(), tables, strict=True)]
    exact = np.stack([Fy.to_numpy().reshape(2, -1).sum(axis=0) for Fy in forces], axis=1) / motion.loads
    assert np.abs(motion.side_forces(tires) - exact).max() < 5e-3 * np.abs(added).max()


def test_a_car_that_slides_beyond_90_degrees_has_forces(answer):
    states = answer.estimate.states.copy()
    states[:, 0], states[:, 1] = 0.05, -20.0
    spun = replace(answer.estimate, states=states)
    forces = motion_of(answer.grid, spun, answer.unknowns, answer.car).side_forces(answer.tires)
    assert np.isfinite(forces).all()


SAME = road.Truth({axle: dict.fromkeys(("LMUX", "LMUY", "LKX", "LKY"), 1.0) for axle in ("front", "rear")}, {})


@pytest.mark.slow
def test_a_wrong_car_is_no_finding_of_a_tire(tire):
    logs, _ = road.made_drives([SAME], ["step"], [True], seed=3, seconds=14.0)
    content = road.car_content()
    content["steering"]["ratio"] *= 1.06
    answer = tirefmu.drive(logs[0], vehicle=Car.from_content(content, "car.toml"), tire=tire)
    verdict = answer.verdict
    assert not verdict.tires
    determined = [factor.determined for row in answer.factors.values() for factor in row.values()]
    assert not (verdict.contradiction.certain and any(determined))
    assert {finding.name for finding in verdict.car} <= {"ratio"}


def test_a_signal_behind_a_lag_is_that_of_the_differential_equation():
    step, t = 0.05, 0.05 * np.arange(200)
    omega, lag = 2 * np.pi * 1.2, 0.06
    added = behind_lags(np.sin(omega * t)[None], np.full((1, len(t)), lag), step)[0, 0]
    exact = (np.sin(omega * t) - omega * lag * np.cos(omega * t)) / (1.0 + (omega * lag) ** 2) - np.sin(omega * t)
    mean = exact * np.sinc(omega * step / 2.0 / np.pi)  # over an interval
    np.testing.assert_allclose(added[20:-5], mean[20:-5], atol=2e-3)


def test_signals_behind_lags_know_nothing_of_each_other():
    signals, constants = np.random.default_rng(2).normal(size=(2, 3, 40))
    constants = np.abs(constants)
    together = behind_lags(signals, constants, 0.05, (1.0, 1.5, 0.0))
    alone = [
        [behind_lags(signals[i : i + 1], longer * constants[i : i + 1], 0.05)[0, 0] for i in range(3)]
        for longer in (1.0, 1.5, 0.0)
    ]
    np.testing.assert_allclose(together, alone, atol=1e-12)
    np.testing.assert_allclose(together[2], 0.0, atol=1e-6)  # without a lag, nothing is added


def test_chains_side_by_side_know_nothing_of_each_other():
    signals, constants = np.random.default_rng(3).normal(size=(2, 2, 3, 40))
    constants = np.abs(constants)
    together, heaved = behind_lags(signals, constants, 0.05, (1.0, 1.1)), heaving(signals[0], 0.7, 0.05)
    for chain in range(3):
        alone = behind_lags(signals[:, chain], constants[:, chain], 0.05, (1.0, 1.1))
        np.testing.assert_allclose(together[:, :, chain], alone, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(heaved[chain], heaving(signals[0, chain], 0.7, 0.05), rtol=1e-9, atol=1e-9)


def test_a_body_heaves_as_a_damped_mass_on_springs():
    step, period = 0.05, 0.8
    t, w = step * np.arange(400), 2 * np.pi / period
    for omega in (0.2 * w, w, 3.0 * w):
        gain = (1j * omega) ** 2 / (1.0 - (omega / w) ** 2 + 2j * DAMPING * omega / w)
        mean = np.imag(gain * np.exp(1j * omega * t)) * np.sinc(omega * step / 2.0 / np.pi)
        np.testing.assert_allclose(
            heaving(np.sin(omega * t), period, step)[200:-2], mean[200:-2], atol=0.03 * abs(gain)
        )
    assert not heaving(np.full(20, 3.0), period, step).any()  # at rest


@pytest.mark.slow
def test_the_lift_of_a_body_is_none_of_the_tires(tire):
    truth = replace(SAME, car={"lift": 2e-4, "heave_period": 0.65})
    logs, _ = road.made_drives([truth], ["slalom"], [True], seed=4, seconds=14.0)
    answer = tirefmu.drive(logs[0], vehicle=Car.from_content(road.car_content(), "car.toml"), tire=tire)
    assert not answer.verdict.tires
    assert all(row["LKY"].low < 1.0 < row["LKY"].high for row in answer.factors.values())
    lift = answer.to_json()["car"]["entries"]["lift"]
    assert abs(lift["value"] - 2e-4) < 2.0 * lift["uncertainty"] < 2.0 * lift["given_uncertainty"]


@pytest.mark.slow
def test_without_a_peak_friction_is_not_determined(car, tire):
    logs, _ = road.made_drives([SAME], ["sweep"], [False], seed=2, seconds=10.0)
    answer = tirefmu.drive(logs[0], vehicle=car, tire=tire)
    factors = answer.factors
    assert not answer.verdict.tires
    for axle in ("front", "rear"):
        assert not factors[axle]["LMUY"].determined
        assert factors[axle]["LMUY"].low < 1.0 < factors[axle]["LMUY"].high


def with_pose(log, sign, size):
    """Return a log with positions and a heading from 0 to 360 deg, in units of a size in deg."""
    t, speed = log["t"].to_numpy(), log["speed"].to_numpy()
    step = np.gradient(t)
    heading = np.cumsum(log["yaw_rate"].to_numpy() * step)
    x, y = np.cumsum(speed * np.cos(heading) * step), np.cumsum(speed * np.sin(heading) * step)
    return log.assign(x=x, y=y, heading=(sign * np.degrees(heading) + 200.0) % 360.0 * size)


REFUSED = {
    "no steering": (lambda log: log.assign(steer=0.0), "steer hardly changes"),
    "held steering": (lambda log: log.assign(steer=0.3), "steer hardly changes"),
    "no channel": (lambda log: log.drop(columns="steer"), "no channel steer"),
    "wrong sign": (lambda log: log.assign(steer=-log["steer"]), "opposite signs"),
    "degrees called radians": (lambda log: log.assign(yaw_rate=np.degrees(log["yaw_rate"])), "yaw_rate"),
    "radians called degrees": (lambda log: log.rename(columns={"steer": "steer [deg]"}), "steer in rad"),
    "steering in degrees": (lambda log: log.assign(steer=np.degrees(0.3 * log["steer"])), "steer"),
    "in g": (lambda log: log.assign(ay=log["ay"] / 9.81), "ay in g (--columns 'ay=HEADER [g]')"),
    "in km/h": (lambda log: log.assign(speed=3.6 * log["speed"]), "speed in km/h (--columns 'speed=HEADER [km/h]')"),
    "in g and km/h": (
        lambda log: log.filter(regex="^(?!omega)").assign(ay=log["ay"] / 9.81, speed=3.6 * log["speed"]),
        "speed in km/h and ay in g",
    ),
    "heading in degrees": (lambda log: with_pose(log, 1.0, 1.0), "in deg? --columns 'heading=HEADER [deg]'"),
    "heading of a compass": (
        lambda log: with_pose(log, -1.0, 1.0),
        "as that of a compass and in deg? --columns 'heading=-HEADER [deg]'",
    ),
    "heading to the right": (
        lambda log: with_pose(log, -1.0, np.pi / 180.0),
        "as that of a compass? --columns 'heading=-HEADER'",
    ),
    "braking is positive": (lambda log: log.assign(ax=-log["ax"]), "rate of the speed have opposite signs"),
    "a turned sensor": (
        lambda log: log.assign(ax=-log["ay"], ay=log["ax"]),
        "--columns 'ay=-HEADER of ax,ax=HEADER of ay'",
    ),
    "a sensor turned the other way": (
        lambda log: log.assign(ax=log["ay"], ay=-log["ax"]),
        "--columns 'ay=HEADER of ax,ax=-HEADER of ay'",
    ),
    "another signal": (lambda log: log.assign(ay=np.roll(log["ax"], 100)), "ay does not follow speed times yaw rate"),
    "wheel speeds in rpm": (
        lambda log: log.drop(columns="speed").assign(
            **{name: log[name] * 30.0 / np.pi for name in log if "omega" in name}
        ),
        "wheel speeds in rpm (--columns 'omega_fl=HEADER [rpm],omega_fr=HEADER [rpm]",
    ),
    "a bank": (lambda log: log.assign(ay=log["ay"] + 6.0), "a banked road"),
    "microseconds": (lambda log: log.assign(t=1e6 * log["t"]), "in us? --columns 't=t [us]'"),
    "speed 0": (lambda log: log.assign(speed=0.0), "does not move"),
    "another log": (
        lambda log: log.assign(yaw_rate=np.roll(log["yaw_rate"], 300)),
        "does not follow speed times yaw rate",
    ),
    "time": (lambda log: log.assign(t=log["t"].to_numpy()[::-1]), "time decreases"),
}


@pytest.mark.parametrize(("change", "message"), REFUSED.values(), ids=REFUSED)
def test_a_log_that_contradicts_the_car_is_refused(change, message, log, car, tire):
    with pytest.raises(DataError, match=re.escape(message)) as refusal:
        tirefmu.drive(change(log), vehicle=car, tire=tire)
    assert len(str(refusal.value).splitlines()) == 1


@pytest.mark.parametrize(("nominal", "message"), [(2e5, "another load class (--tire)"), (40.0, "mass not in kg?")])
def test_a_tire_of_another_load_class_is_refused(nominal, message, log, car, tire):
    with pytest.raises(TirefmuError, match=re.escape(message)):
        tirefmu.drive(log, vehicle=car, tire=replace(tire, values={**tire.values, "FNOMIN": nominal}))


def test_the_command_writes_the_answer(log, tire, tmp_path, capsys):
    log[:900].rename(columns={"ay": "AccY"}).assign(AccY=log["ay"] / 9.80665).to_csv(tmp_path / "log.csv", index=False)
    tire.save(tmp_path / "front.tir")
    lines = [f"[{name}]\n" + "\n".join(f"{k} = {v}" for k, v in of.items()) for name, of in road.car_content().items()]
    (tmp_path / "car.toml").write_text("\n".join(lines), encoding="utf-8")
    given = [str(tmp_path / "log.csv"), "--vehicle", str(tmp_path / "car.toml"), "--tire", str(tmp_path / "front.tir")]
    assert main(["drive", *given, "--columns", "ay=AccY [g]", "--fmus", "-o", str(tmp_path / "answer")]) == 0
    written = {path.name for path in (tmp_path / "answer").iterdir()}
    assert written == {"drive.json", "wheels.csv", "front.tir", "front.fmu", "rear.tir", "rear.fmu", "report.html"}
    check_file("drive", tmp_path / "answer" / "drive.json")
    content = json.loads((tmp_path / "answer" / "drive.json").read_text(encoding="utf-8"))
    assert {"factors", "found", "unknown", "car", "simulation"} <= content.keys()
    assert set(content["factors"]["rear"]["LKY"]) >= {"value", "low", "high", "determined"}
    assert content["simulation"]["fmus"]
    assert set(content["simulation"]["after"]) == {"yaw_rate", "ay", "vy"}
    assert main(["drive", *given, "-o", str(tmp_path / "other")]) == 2
    assert "no channel ay" in capsys.readouterr().err
    assert not (tmp_path / "other").exists()
