"""Unexplained structure: its features, and the proposed formula."""

from dataclasses import replace

import numpy as np
import pytest

from tirefmu.diagnosis.probing.effect_probing import Screen
from tirefmu.diagnosis.recording.simulation import Simulator
from tirefmu.diagnosis.search import proposals
from tirefmu.diagnosis.search.effect_search import Search
from tirefmu.diagnosis.search.proposals import with_correction
from tirefmu.diagnosis.thresholds import EFFECT_P, MIN_STRETCHES, P_FACTOR, STRETCHES
from tirefmu.diagnosis.unexplained.drift import is_drift
from tirefmu.diagnosis.unexplained.features import (
    Feature,
    determined,
    directions,
    features,
    locations_of,
)
from tirefmu.diagnosis.unexplained.formula_proposal import effect_of
from tirefmu.diagnosis.unexplained.past import STATES, _low_pass
from tirefmu.diagnosis.unexplained.structure import core_part, structure_of
from tirefmu.symbolic.added import library


@pytest.fixture(scope="module")
def velocity_dependent_friction(problem, at_true_values):
    """Return a screen of a recording whose friction decreases with sliding speed, unlike that of the tire."""
    signals = problem.simulator.signals
    fall = -0.1 * 5.0 * np.abs(np.tan(signals.named()["alpha"]))
    missing = directions(at_true_values.problem.simulator, at_true_values.solution.parameters)["friction"] * fall
    measured = signals.measured + missing
    other = replace(problem, simulator=problem.simulator.with_signals(replace(signals, measured=measured)))
    screen = Screen(other, other.at(at_true_values.solution.parameters, at_true_values.solution.free))
    screen.learn_noise({0: (problem.inverse_noise * missing)[:, :, None]})
    return screen


def test_structure_is_identified_with_its_location_variable_and_size(velocity_dependent_friction):
    found = structure_of(velocity_dependent_friction)
    assert found.passes
    assert found.generalizes
    assert (found.stretch_gains > 0.0).sum() == STRETCHES
    assert found.depends_on == ("alpha",)
    (size,) = [
        value for value, term in zip(found.response.estimate, found.terms, strict=True) if "tan(alpha)" in term.text
    ]
    assert size == pytest.approx(-0.1, rel=0.3)
    assert f"{size:+.3g}" in found.formula


def test_a_zero_that_drifts_in_steps_is_no_structure(problem, at_true_values, velocity_dependent_friction):
    found = structure_of(velocity_dependent_friction)
    assert not is_drift(velocity_dependent_friction, found)
    signals = problem.simulator.signals
    side, steps = signals.channels.index("Fy"), np.linspace(0.0, 2.999, signals.measured.shape[1]).astype(int) % 2
    column = np.zeros((*signals.measured.shape, 1))
    column[side, :, 0] = steps / np.median(problem.inverse_noise[side])
    measured = replace(signals, measured=signals.measured + column[:, :, 0])
    drifting = replace(problem, simulator=problem.simulator.with_signals(measured))
    screen = Screen(drifting, drifting.at(at_true_values.solution.parameters, at_true_values.solution.free))
    weighted = problem.inverse_noise[:, :, None] * column
    screen.learn_noise({0: weighted})
    response = screen.response(weighted)
    gains = screen.baseline.loss - response.loss
    resembling = replace(found, columns=column, response=response, gains=gains,
                         gain=gains.sum() / screen.baseline.loss.sum(), p=response.p_coloured)  # fmt: skip
    assert resembling.response.p_coloured < EFFECT_P / P_FACTOR
    assert is_drift(screen, resembling)


def test_noise_has_no_structure_that_passes(at_true_values):
    found = structure_of(at_true_values)
    assert found is None or not found.passes


def test_structure_in_one_part_of_a_recording_is_rejected(velocity_dependent_friction):
    found = structure_of(velocity_dependent_friction)
    stretch_gains = np.where(np.arange(STRETCHES) < MIN_STRETCHES - 1, found.stretch_gains, -1e-3)
    assert not replace(found, stretch_gains=stretch_gains).passes
    assert not replace(found, stretch_gains=0.3 * found.stretch_gains).passes
    assert not replace(found, gain_error=found.gain).passes


def test_a_product_is_odd_if_one_of_its_factors_is():
    values = np.array([1.0, -2.0])
    even, odd = Feature("Fz", frozenset({"Fz"}), values), Feature("10*gamma", frozenset({"gamma"}), values, odd=True)
    rate = Feature("rate of alpha", frozenset({"dalpha/dt"}), values, odd=True, expressible=False)
    assert [(a * b).odd for a, b in ((even, even), (even, odd), (odd, even), (odd, odd))] == [False, True, True, False]
    assert not (even * rate).expressible
    assert (even * rate).in_effect_file == ""  # neither part of the rate is a formula
    lagged = replace(rate, formula="alpha - late_alpha", states=("late_alpha",))
    assert (even * lagged).in_effect_file == "Fz*(alpha - late_alpha)"
    assert (even * lagged).states == ("late_alpha",)
    assert (even * odd).text == "Fz*10*gamma"
    assert (even * odd).depends_on == {"Fz", "gamma"}
    np.testing.assert_array_equal((even * odd).values, values**2)


def test_even_and_odd_features_under_mirroring(at_true_values):
    """The mirrored recording has opposite lateral inputs; this includes rates and memories."""
    signals, tire = at_true_values.signals, at_true_values.problem.simulator.tire
    inputs = signals.inputs.copy()
    for name in ("alpha", "gamma"):
        inputs[signals.names.index(name)] *= -1.0
    mirrored = features(replace(signals, inputs=inputs), tire)
    for here, there, sign in zip(features(signals, tire), mirrored, (1.0, -1.0), strict=True):
        assert here
        for one, other in zip(here, there, strict=True):
            assert one.text == other.text
            np.testing.assert_allclose(other.values, sign * one.values, atol=1e-9)


def test_a_memory_is_a_first_order_lag():
    step = np.r_[0.0, np.ones(50)]
    np.testing.assert_allclose(_low_pass(step, 0.1), 1.0 - np.exp(-0.1 * np.arange(51)), atol=1e-12)
    np.testing.assert_allclose(_low_pass(np.full(20, 3.0), 0.1), 3.0)


def test_the_response_at_a_location_equals_finite_differences(at_true_values):
    """A factor on friction or stiffness has the response of the leading coefficients."""
    model = at_true_values.problem.simulator.symbolic_model
    assert {location.name for location in locations_of(model)} >= {"friction", "slip stiffness", "slip angle"}
    simulator, parameters = at_true_values.problem.simulator, at_true_values.solution.parameters
    acts = directions(at_true_values.problem.simulator, at_true_values.solution.parameters)
    for name, scaled in (("friction", ("PDX1", "PDY1")), ("slip stiffness", ("PKX1", "PKY1"))):
        changes = []
        for share in (1e-5, -1e-5):
            moved = parameters.copy()
            for coefficient in scaled:
                moved[simulator.index[coefficient]] *= 1.0 + share
            changes.append(simulator.forces(moved))
        expected = (changes[0] - changes[1]) / 2e-5
        np.testing.assert_allclose(acts[name], expected, atol=1e-4 * np.abs(expected).max())


def test_no_feature_names_an_input_that_was_not_recorded(problem):
    signals, tire = problem.simulator.signals, problem.simulator.tire
    assert "V" not in signals.recorded
    named = {name for part in features(signals, tire) for feature in part for name in feature.depends_on}
    assert named <= signals.recorded | {"dalpha/dt", "dkappa/dt", "dFz/dt", "memory"}


def test_a_formula_of_two_slips_needs_combined_slip(problem):
    """Without combined slip the noise of one slip in a sweep of the other would determine the formula."""
    signals, tire = problem.simulator.signals, problem.simulator.tire
    inputs = signals.inputs.copy()
    alpha, kappa = (signals.names.index(name) for name in ("alpha", "kappa"))
    first = np.arange(inputs.shape[1]) < inputs.shape[1] // 2
    inputs[kappa, first] = 1e-4 * np.random.default_rng(0).normal(size=int(first.sum()))
    inputs[alpha, ~first] = 0.0
    pure = replace(signals, inputs=inputs)

    def formulas(recording):
        even, odd = features(recording, tire)
        return {
            (location.name, feature.text)
            for location in locations_of(problem.simulator.symbolic_model)
            for feature in (*even, *odd, *(one * other for one in even for other in even))
            if determined(location, feature, recording, tire)
        }

    lost = formulas(signals) - formulas(pure)
    assert ("trail", "5*absolute(kappa)") in lost
    assert ("friction", "5*absolute(tan(alpha))") in lost
    assert ("side force", "5*absolute(tan(alpha))*5*absolute(kappa)") in lost
    assert {("trail", "5*absolute(tan(alpha))"), ("friction", "5*sqrt(tan(alpha)**2 + kappa**2)")} <= formulas(pure)


def test_the_states_of_a_proposal_resemble_the_features(at_true_values, velocity_dependent_friction):
    """Rates and memories are written as an effect, which a tire simulates: both change the forces alike.

    A direction turns at once where it is computed from a recording, but over a width as the state of a tire.
    """
    simulator, size = at_true_values.problem.simulator, 0.02
    structure = structure_of(velocity_dependent_friction)
    place = next(one for one in locations_of(simulator.symbolic_model) if one.name == "friction")
    past = [one for many in features(at_true_values.signals, simulator.tire) for one in many if not one.expressible]
    assert {state for one in past for state in one.states} == STATES.keys()
    response = replace(structure.response, estimate=np.full(len(past), size))
    effect = effect_of([replace(structure, location=place, terms=tuple(past), response=response)])
    tire = replace(simulator.tire, added=(*simulator.tire.added, effect))
    signals = at_true_values.signals.with_inputs_of(tire)
    assert signals.names == tire.inputs
    extended, parameters = Simulator(tire, signals), tire.parameters()
    own = [extended.index[name] for name in simulator.names]
    parameters[own] = simulator.tire.parameters()
    without, direction = (
        extended.forces(parameters),
        directions(at_true_values.problem.simulator, at_true_values.solution.parameters)["friction"],
    )
    for i, feature in enumerate(past):
        parameters[extended.index[f"FOUND{i + 1}"]] = size
        change = (extended.forces(parameters) - without).ravel()
        parameters[extended.index[f"FOUND{i + 1}"]] = 0.0
        expected = (size * direction * feature.values).ravel()
        turns = any("direction" in state for state in feature.states)
        assert np.corrcoef(change, expected)[0, 1] > (0.5 if turns else 0.95), feature.text
        slope = float(change @ expected / (expected @ expected))
        assert slope == pytest.approx(0.75 if turns else 1.0, abs=0.25 if turns else 0.1), feature.text


def test_formulas_of_one_file_have_coefficients_and_states_of_their_own(at_true_values, velocity_dependent_friction):
    past = [one for many in features(at_true_values.signals, at_true_values.problem.simulator.tire) for one in many]
    (late,) = [one for one in past if one.text == "alpha of the last 0.3 s"]
    structure = structure_of(velocity_dependent_friction)
    response = replace(structure.response, estimate=np.array([0.1]))
    effect = effect_of([replace(structure, terms=(late,), response=response), structure], prefix="form")
    assert [one.name for one in effect.declarations] == [f"FORM{i + 1}" for i in range(1 + len(structure.terms))]
    assert [state.name for state in effect.states] == ["form_recent_alpha"]  # another proposal may have found_...
    assert len(effect.acts) == 2 * len(structure.location.quantities)


def search_with(screen, form):
    """Return a completed search that found an error of the functional form."""
    search = Search(screen.problem, screen.solution, {}, lambda sentence: None)
    search.screen, search.forms = screen, [form]
    return search


def test_an_error_of_the_form_that_the_holdout_confirms_is_corrected_in_the_tire(
    velocity_dependent_friction, monkeypatch
):
    monkeypatch.setattr(proposals, "_confirms_effects", lambda search, before: True)
    structure = structure_of(velocity_dependent_friction)
    search = search_with(velocity_dependent_friction, structure)
    start, problem, solution = search.problem.simulator.tire, search.problem, search.solution
    correction, corrected = with_correction(search, search.screen, start, lambda sentence: None)
    assert correction is not None
    assert corrected.added[-1] == correction.effect
    assert [text.partition(":")[0] for text in correction.formulas] == [structure.formula.partition(":")[0]]
    assert set(search.solution.free) - set(solution.free) == {one.name for one in correction.effect.declarations}
    assert problem.holdout_gain(solution, search.solution) > 0.5


@pytest.mark.parametrize("change", ["other side", "other variable", "nothing missing"])
def test_a_form_is_no_correction_without_need(velocity_dependent_friction, change, monkeypatch):
    structure = structure_of(velocity_dependent_friction)
    search = search_with(velocity_dependent_friction, structure)
    if change != "nothing missing":  # the search has found nothing, which no final fit confirms
        monkeypatch.setattr(proposals, "_confirms_effects", lambda search, before: True)
    if change == "other variable":
        term = replace(structure.terms[0], depends_on=frozenset({"T"}))
        search.forms = [replace(structure, terms=(term, *structure.terms[1:]))]
    elif change == "other side":
        used = (search.problem.inverse_noise > 0.0)[:, :, None]
        search.forms = [replace(structure, columns=np.where(used, structure.columns, -structure.columns))]
    start = search.problem.simulator.tire
    assert with_correction(search, search.screen, start, lambda sentence: None) == (None, start)


def test_no_effect_of_the_library_has_the_states_of_a_proposal():
    assert STATES.keys().isdisjoint(state.name for effect in library().values() for state in effect.states)


def test_the_part_of_a_structure_in_the_inputs_of_the_core(velocity_dependent_friction):
    screen = velocity_dependent_friction
    found = structure_of(screen)
    (term,) = found.terms[:1]
    assert core_part(screen, found).formula == found.formula
    other = replace(term, depends_on=frozenset({"memory"}), text="something else")
    mixed = replace(
        found,
        terms=(*found.terms[:1], other),
        response=screen.response(
            np.repeat(found.columns[:, :, :1] * screen.problem.inverse_noise[:, :, None], 2, axis=2)
        ),
    )
    part = core_part(screen, mixed)
    assert part.terms == (term,)
    assert part.depends_on == ("alpha",)
    assert part.gain <= found.gain + 0.05
    assert core_part(screen, replace(found, terms=(other,))) is None
