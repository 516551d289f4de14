"""Fit error and noise floor, residual maps, weights, extrapolation, and measurement artefacts."""

from dataclasses import replace

import numpy as np
import pytest

from tirefmu.diagnosis import diagnose
from tirefmu.diagnosis.diagnose import with_library
from tirefmu.diagnosis.probing import reweighted
from tirefmu.diagnosis.probing.effect_probing import Screen
from tirefmu.diagnosis.signals import OUTLIER, quantisation, ripple
from tirefmu.diagnosis.verdict import (
    MAX_CHANGE,
    computed_by,
    delivered_residuals,
    error_splits,
    extrapolations,
    fit_errors,
    outside,
    residual_maps,
    residual_of,
    time_course,
)
from tirefmu.fitting import fit
from tirefmu.measurements import Recording, read_recording
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire

NOISE = {"Fx": 5.0, "Fy": 5.0, "Mz": 0.5}


def test_the_noise_floor_equals_the_noise(at_true_values, tire, table):
    recording = Recording(table, "adapted-sae", "bench")
    residual, signals = residual_of(computed_by(tire, recording), at_true_values, recording), at_true_values.signals
    residuals = delivered_residuals(residual, residual, signals)
    splits = error_splits(residual, residuals, recording)
    assert {name: one.floor for name, one in splits.items()} == pytest.approx(NOISE, rel=0.1)


def agree(fitted, diagnosis):
    """Return the relative difference of the noise floors by channel, and its standard error by their different rows.

    The diagnosis has no rows of the hold-out set, an eighth. Noise is as correlated as the residual of the fit.
    """
    floors = {name: one["floor"] for name, one in diagnosis.gap["train"].items()}
    measured = [c for c in fitted.channels if c.channel in floors]
    error = {c.channel: np.sqrt(1.0 / 7.0 / (2.0 * c.effective_rows)) for c in measured}
    return {c.channel: floors[c.channel] / c.noise_floor - 1.0 for c in measured}, error


def test_a_fit_and_a_diagnosis_state_the_same_noise_floor(tire, table):
    recording = Recording(table, "adapted-sae", "bench")
    fitted = fit([recording], "mf96", start=tire, effects=tire.has)
    diagnosis = diagnose(recording, tire=fitted.tire, candidates=["camber_stiffness"])
    difference, error = agree(fitted, diagnosis)
    assert set(difference) == set(NOISE)
    assert all(abs(difference[name]) < 4.0 * error[name] for name in NOISE), difference


@pytest.mark.slow
def test_they_are_the_same_for_a_measured_recording(data_folder):
    measured = read_recording(data_folder / "cornering.mat")
    recording = replace(measured, table=measured.table.iloc[::8].reset_index(drop=True))
    fitted = fit([recording], "mf61")
    difference, error = agree(fitted, diagnose(recording, tire=fitted.tire, candidates=["relax_lat"]))
    assert set(difference) == {"Fy", "Mz", "Mx"}
    assert all(abs(difference[name]) < 4.0 * error[name] for name in difference), difference


def test_the_error_of_the_true_tire_is_the_noise(at_true_values, without_camber, tire, table):
    recording = Recording(table, "adapted-sae", "bench")
    screens, signals = (without_camber, at_true_values), at_true_values.signals
    without = replace(tire, values={**tire.values, "PVY3": -0.3})  # as wrong as the tire of the other recording
    both = [
        residual_of(computed_by(each, recording), screen, recording)
        for each, screen in zip((without, tire), screens, strict=True)
    ]
    residuals = delivered_residuals(*both, signals)
    splits = error_splits(both[1], residuals, recording)
    reported = fit_errors(*screens, residuals, splits)
    for part in ("train", "cv", "holdout"):
        for channel, noise in NOISE.items():
            assert reported[part][channel]["after"] == pytest.approx(noise, rel=0.15)
        assert reported[part]["Fy"]["before"] > 1.2 * NOISE["Fy"]
    for channel in NOISE:  # out-of-sample errors are slightly larger
        assert reported["cv"][channel]["after"] >= reported["train"][channel]["after"]


def test_the_map_of_a_missing_effect_grows_with_its_input(without_camber, at_true_values):
    def worst(screen):
        maps = residual_maps(screen)
        return {(one["channel"], *one["over"]): one["worst"] for one in maps}

    seen, flat = worst(without_camber)["Fy", "Fz", "gamma"], worst(at_true_values)["Fy", "Fz", "gamma"]
    assert abs(seen["mean"]) > 2.0 > 1.5 > abs(flat["mean"])
    assert min(abs(seen["from"][1]), abs(seen["to"][1])) > 0.02
    assert (
        sum(map(sum, residual_maps(at_true_values)[0]["count"]))
        == (at_true_values.problem.inverse_noise[0] > 0.0).sum()
    )


def test_the_misfit_over_time_of_the_true_tire_is_one(without_camber, at_true_values):
    reported = time_course(without_camber, at_true_values)["Fy"]
    assert len(reported["t"]) == len(reported["before"]) == at_true_values.n_blocks
    np.testing.assert_allclose(reported["after"], 1.0, atol=0.4)
    assert max(reported["before"]) > 1.5


# ------------------------------------------------------------------ weights from the noise of the residual


def test_weights_are_the_reciprocal_noise_and_outliers_are_excluded(problem, tire):
    signals = problem.simulator.signals
    rows = np.flatnonzero(~signals.holdout)[100::200]
    measured = signals.measured.copy()
    measured[1, rows] += 20.0 * OUTLIER * NOISE["Fy"]
    other = replace(problem, simulator=problem.simulator.with_signals(replace(signals, measured=measured)))
    found = reweighted(other, other.at(tire.parameters(), ("PDY1",)))
    assert not found.inverse_noise[1, rows].any()
    assert not found.inverse_noise[:, signals.holdout].any()
    for i, name in enumerate(signals.channels):
        weights = found.inverse_noise[i][found.inverse_noise[i] > 0.0]
        assert np.sqrt(np.mean(weights**-2.0)) == pytest.approx(NOISE[name], rel=0.15)
        assert len(weights) > 0.97 * (~signals.holdout).sum() - len(rows)


# ------------------------------------------------------------------ extrapolation


def extrapolated(screen, parameters, effects, inputs):
    improved = Screen(screen.problem, screen.problem.at(parameters, screen.solution.free))
    return extrapolations(improved, effects, inputs)


def test_the_measured_range_of_an_effect_is_that_of_its_input(at_true_values, tire):
    inputs = {"load_friction": ("Fz", "alpha", "T")}
    (reported,) = extrapolated(at_true_values, tire.parameters(), {"load_friction": ("PDY2",)}, inputs)
    assert (reported.effect, reported.input) == ("load_friction", "Fz")  # no slips, and T was not recorded
    assert reported.lower == pytest.approx(600.0, rel=0.02)
    assert reported.upper == pytest.approx(1400.0, rel=0.02)
    assert reported.doubtful == (reported.change > MAX_CHANGE)


def test_only_the_effect_is_extrapolated(at_true_values, tire):
    """Forces grow with load whatever effect a tire has; a small effect changes them little outside the range."""
    parameters, index = tire.parameters(), at_true_values.problem.simulator.index["PDY2"]
    changes = []
    absent = parameters[index]
    for value in (0.0, -0.02, -0.4):
        parameters[index] = absent + value
        (reported,) = extrapolated(at_true_values, parameters, {"load_friction": ("PDY2",)}, {"load_friction": ("Fz",)})
        changes.append((reported.change, reported.doubtful))
    assert changes[0] == (0.0, False)  # the effect is switched off
    assert 0.0 < changes[1][0] < 0.1 * changes[2][0]
    assert [doubtful for _, doubtful in changes] == [False, False, True]


@pytest.mark.parametrize("name", MODELS)
def test_no_extrapolation_leaves_the_physical_range(name):
    """A speed of 9 to 27.5 m/s is not extrapolated to rolling in reverse, nor a load to a lifted tire."""
    quantities = with_library(Tire(name, {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3})).symbolic_model.inputs
    positive = {each.name for each in quantities if each.lower == 0.0}
    assert positive == {"Fz", "p", "V", "distance"} & {each.name for each in quantities}
    for each in quantities:
        for lower, upper in ((0.0, 5.0), (1.0, 1.5), (9.0, 27.5), (1.0, 1e6)):
            below, above = outside(quantities, each.name, lower, upper)
            assert above - upper == 0.5 * (upper - lower)
            assert upper < above
            if each.name in positive:
                assert min(lower, 0.5 * lower) <= below <= lower
            else:
                assert lower - below == 0.5 * (upper - lower)


# ------------------------------------------------------------------ measurement artefacts


def test_a_ripple_once_per_revolution_is_found_in_its_channel(at_true_values):
    """At 10 m/s and a rolling radius of 0.29 m; the wheel turns with the longitudinal slip, too."""
    signals, rng = at_true_values.signals, np.random.default_rng(0)
    speed = np.full((1, len(signals.t)), 10.0)
    signals = replace(signals, names=(*signals.names, "V"), inputs=np.concatenate([signals.inputs, speed]))
    assert ripple(signals, rng.normal(size=signals.measured.shape), 0.3) == {}  # V is nominal: not recorded
    signals = replace(signals, origin=replace(signals.origin, recorded=signals.origin.recorded | {"V"}))
    rest = rng.normal(size=signals.measured.shape)
    assert ripple(signals, rest, 0.3) == {}
    turning = 10.0 * (1.0 + signals.inputs[signals.names.index("kappa")])
    angle = np.cumsum(turning * np.gradient(signals.t)) / 0.29
    rest[1] += 2.0 * np.sin(angle[signals.rows] + 0.7)
    assert ripple(signals, rest, 0.3) == pytest.approx({"Fy": 2.0}, rel=0.15)
    assert ripple(signals, rest, 0.4) == pytest.approx({"Fy": 2.0}, rel=0.15)  # the radius is searched for


def test_steps_of_a_sensor_are_found_at_any_offset():
    raw = np.random.default_rng(1).normal(0.0, 100.0, 2000)
    for step in (0.5, 4.0):
        assert quantisation(np.round(raw / step) * step + 0.3) == pytest.approx(step, rel=1e-6)
    assert quantisation(raw) == 0.0
    assert quantisation(np.full(50, 3.0)) == 0.0
