"""Effect screening: detection of missing effects, no false detection, and projection of the baseline model."""

from dataclasses import replace

import numpy as np
import pytest

from tirefmu.diagnosis.probing import alias_columns, correlations, separating_measurement
from tirefmu.diagnosis.probing.effect_probing import LARGEST_CHANGE, Screen
from tirefmu.diagnosis.thresholds import CONFOUNDED
from tirefmu.symbolic.added import library
from tirefmu.symbolic.detection import Form
from tirefmu.symbolic.models import model_named

THRUST = Form(("PVY3",), ({"PVY3": 0.15},))
FRICTION = Form(("PDY3",), ({"PDY3": 3.0},))


def test_a_missing_effect_is_detected_with_its_size(without_camber):
    (response,) = without_camber.responses([without_camber.columns(THRUST)])
    assert abs(response.estimate[0]) > 5.0 * response.coloured[0]
    assert response.estimate == pytest.approx([0.3 / 0.15], rel=0.1)
    assert abs(response.estimate[0] - 2.0) < 4.0 * response.error[0]


def test_an_effect_that_is_not_missing_is_not_detected(at_true_values):
    for form in (THRUST, FRICTION):
        (response,) = at_true_values.responses([at_true_values.columns(form)])
        assert abs(response.estimate[0]) < 3.3 * response.coloured[0]
        assert abs(response.estimate[0]) < 4.0 * response.error[0] < 0.2


def test_a_response_in_the_tangent_space_of_the_baseline_is_not_testable(without_camber):
    column = without_camber.tangent[:, :, [2]]
    free = without_camber.project(column)
    assert np.linalg.norm(free) < 0.02 * np.linalg.norm(column)
    (response,) = without_camber.responses([column])
    assert (response.coloured.tolist(), response.estimate.tolist()) == ([np.inf], [0.0])
    assert np.isinf(response.error).all()


def test_a_projection_is_orthogonal_to_the_tangent_space_and_idempotent(without_camber):
    columns = without_camber.columns(THRUST)
    free = without_camber.project(columns)
    tangent = without_camber.tangent.reshape(-1, without_camber.tangent.shape[-1])
    cosines = (tangent.T @ free.reshape(-1)) / np.linalg.norm(tangent, axis=0) / np.linalg.norm(free)
    firm = without_camber.prior_precision < 0.01 * np.sum(tangent**2, axis=0)  # a strong prior leaves a remainder
    assert firm.any()
    assert np.max(np.abs(cosines[firm])) < 0.02
    np.testing.assert_allclose(without_camber.project(free), free, atol=0.02 * np.abs(free).max())


def test_a_block_that_alone_determines_a_coefficient_is_predicted_within_limits(problem, tire):
    """Without it the coefficient is at its prior mean, and the linear prediction of the block far off."""
    fx = problem.simulator.signals.channels.index("Fx")
    only = problem.simulator.signals.block == problem.simulator.signals.block[len(problem.simulator.signals.block) // 2]
    inverse_noise = problem.inverse_noise.copy()
    inverse_noise[fx, ~only] = 0.0
    alone = replace(problem, inverse_noise=inverse_noise, center={**problem.center, "PDX1": 3.0})
    free = ("PDX1", "PDY1", "PKY1")
    change, others = (Screen(of, of.at(tire.parameters(), free)).change_without_block for of in (alone, problem))
    rms = np.sqrt(np.mean(alone.at(tire.parameters(), free).residual[fx, inverse_noise[fx] > 0.0] ** 2))
    assert np.abs(change[fx]).max() == pytest.approx(LARGEST_CHANGE * rms)
    assert np.abs(others[fx]).max() < rms


# ------------------------------------------------------------------ other explanations


def test_a_zero_offset_is_confounded_with_a_shift(at_true_values):
    """An error of the slip angle is a horizontal shift; an error of the longitudinal slip is not."""
    aliases = alias_columns(at_true_values)
    reported = correlations(at_true_values, ("PHY1",), aliases.items())
    assert reported["slip_angle_zero_offset"] > CONFOUNDED > reported["slip_zero_offset"]
    assert all(0.0 <= value <= 1.0 + 1e-9 for value in reported.values())


def test_the_correlation_does_not_depend_on_size_and_sign(at_true_values):
    own = at_true_values.tangent[:, :, [5]]  # of PHY1
    reported = correlations(
        at_true_values, ("PHY1",), [("itself", own), ("reversed", -7.0 * own), ("other", own * 0.0)]
    )
    assert reported == pytest.approx({"itself": 1.0, "reversed": 1.0})


def test_correlations_ignore_responses_of_the_remaining_model(at_true_values):
    own, friction = at_true_values.tangent[:, :, [5]], at_true_values.tangent[:, :, [2]]  # of PHY1 and PDY1
    friction = friction * np.linalg.norm(own) / np.linalg.norm(friction)
    reported = correlations(at_true_values, ("PHY1",), [("mixed", own + 2.0 * friction)])
    assert reported["mixed"] == pytest.approx(1.0, abs=1e-3)


def test_the_separating_measurement_does_not_depend_on_the_order():
    pairs = [("temp_friction", "wear_drift"), ("plysteer", "conicity"), ("a", "b")]
    detections = model_named("mf61").extended(tuple(library().values())).detections
    for first, second in pairs:
        forth, back = (separating_measurement(*pair, detections) for pair in ((first, second), (second, first)))
        assert forth == back != ""


def test_a_channel_is_requested_only_where_it_is_not_recorded():
    """What separates two effects holds for any recording; only an explanation by a lacking channel asks for it."""
    detections = model_named("mf61").extended(tuple(library().values())).detections.values()
    pairs = [pair for detection in detections for pair in detection.confounded]
    always = [detection.separate_by for detection in detections]
    always += [pair.separate_by for pair in pairs if not pair.other.startswith("unrecorded")]
    assert [text for text in always if text.startswith("record ")] == []
    assert any(pair.separate_by.startswith("record ") for pair in pairs)
