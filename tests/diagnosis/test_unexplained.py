"""Unexplained structure: its features, and the proposed formula."""

from dataclasses import replace

import numpy as np
import pytest

from tirefmu.diagnosis import LeastSquares
from tirefmu.diagnosis.probing.effect_probing import Screen
from tirefmu.diagnosis.signals import Simulator, disturbances_of, signals_of
from tirefmu.diagnosis.unexplained.features import (
    STATES,
    Feature,
    _low_pass,
    directions,
    features,
    locations_of,
    placed,
)
from tirefmu.diagnosis.unexplained.formula_proposal import Dictionary, UnexplainedStructure, effect_of
from tirefmu.symbolic.added import library
from tirefmu.tires import Tire

from ..relatives import slow_but
from .conftest import FREE, NOISE, VALUES, measured, sweeps


@pytest.fixture(scope="module")
def upright():
    """Return the dictionary of formulas, problem and solution of a tire whose moment follows the upright wheel.

    It has no effects in the quantities with factors: their leading coefficients are all of them.
    """
    tire = Tire("mf61", VALUES, effects=("plysteer", "camber_thrust"), signs="adapted-sae")
    signals = signals_of(measured(tire, sweeps(600)), tire, "adapted-sae", smooth=False)
    noise = np.array([NOISE[name] for name in signals.channels])
    problem = LeastSquares(
        Simulator(tire, signals), np.ones(signals.measured.shape) / noise[:, None],
        disturbances_of(signals, noise, VALUES["UNLOADED_RADIUS"]), tire.symbolic_model.prior_center | VALUES,
    )  # fmt: skip
    solution = problem.at(tire.parameters(), FREE)
    return Dictionary(Screen(problem, solution)), problem, solution


def test_the_shortlist_contains_the_term_that_a_recording_has(at_true_values):
    problem, solution = at_true_values.problem, at_true_values.solution
    signals = problem.simulator.signals
    fall = -0.1 * 5.0 * np.abs(np.tan(signals.named()["alpha"]))
    measured = signals.measured + directions(problem.simulator, solution.parameters)["friction", False] * fall
    other = replace(problem, simulator=problem.simulator.with_signals(replace(signals, measured=measured)))
    screen = Screen(other, other.at(solution.parameters, solution.free))
    dictionary = Dictionary(screen)
    first = dictionary.shortlisted(screen, range(len(dictionary.terms)))[0]
    assert (dictionary.terms[first][0].name, dictionary.terms[first][1].text) == ("friction", "5*absolute(tan(alpha))")


@pytest.mark.parametrize("name", ["kappa", "Fz", "gamma"])
def test_an_input_that_does_not_vary_is_in_no_formula(at_true_values, name):
    signals, tire = at_true_values.signals, at_true_values.problem.simulator.tire
    inputs = signals.inputs.copy()
    row = signals.names.index(name)
    inputs[row] = inputs[row].mean()
    for feature in [one for many in features(replace(signals, inputs=inputs), tire) for one in many]:
        assert not {name, f"d{name}/dt"} & feature.depends_on
        assert feature.states or name not in feature.text


def test_a_product_is_odd_if_one_of_its_factors_is():
    values = np.array([1.0, -2.0])
    even, odd = (
        Feature(text, frozenset({name}), values, is_odd, text)
        for text, name, is_odd in (("Fz", "Fz", False), ("10*gamma", "gamma", True))
    )
    formula = "alpha - late_alpha"
    rate = Feature("rate of alpha", frozenset({"dalpha/dt"}), values, True, formula, states=("late_alpha",))
    assert [(a * b).odd for a, b in ((even, even), (even, odd), (odd, even), (odd, odd))] == [False, True, True, False]
    assert (even * rate).text == "Fz*(rate of alpha)"
    assert (even * rate).formula == "Fz*(alpha - late_alpha)"
    assert (even * rate).states == ("late_alpha",)
    assert (even * odd).formula == (even * odd).text
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
        np.testing.assert_allclose(acts[name, False], expected, atol=1e-4 * np.abs(expected).max())


#: Formulas of which one multiplies and the other is added.
FACTOR, SUM = ["10*absolute(gamma)"], ["10*gamma", "10*gamma*(Fz/FNOMIN - 1)"]


@pytest.mark.parametrize(
    ("where", "texts"),
    slow_but(
        [("force and trail", FACTOR), ("slip angle", SUM)],
        [("force", [*FACTOR, "(Fz/FNOMIN - 1)*10*absolute(gamma)", "Fz/FNOMIN - 1"]), ("force and trail", FACTOR),
         ("trail", FACTOR), ("side force", ["10*gamma"]), ("slip angle", SUM)],
    ),
)  # fmt: skip
def test_the_column_of_a_formula_is_what_the_delivered_effect_changes(upright, where, texts):
    """Also in the aligning moment, which follows the upright wheel in the book: inclination does not change that."""
    dictionary, problem, solution = upright
    places = {(location.name, feature.text): i for i, (location, feature) in enumerate(dictionary.terms)}
    indices, size = [places[where, text] for text in texts], 1e-4
    locations, terms = zip(*(dictionary.terms[i] for i in indices), strict=True)
    effect = effect_of(UnexplainedStructure(locations[0], terms, (size,) * len(terms)))
    for number, i in enumerate(indices, 1):
        forces = []
        for step in (size, -size):
            extended, parameters = problem.with_effect(effect, solution, {f"FOUND{number}": step})
            forces.append(extended.simulator.forces(parameters))
        change, column = (forces[0] - forces[1]) / (2.0 * size), dictionary.column(i)
        for of_effect, of_column in zip(change, column, strict=True):
            np.testing.assert_allclose(of_effect, of_column, atol=1e-3 * np.abs(of_column).max() + 1e-6)


def test_no_feature_names_an_input_that_was_not_recorded(problem):
    signals, tire = problem.simulator.signals, problem.simulator.tire
    assert "V" not in signals.origin.recorded
    named = {name for part in features(signals, tire) for feature in part for name in feature.depends_on}
    assert named <= signals.origin.recorded | {"dalpha/dt", "dkappa/dt", "dFz/dt", "memory"}


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
        every = (*even, *odd, *(one * other for one in even for other in even))
        simulator = problem.simulator.with_signals(recording)
        return {(location.name, feature.text) for location, feature in placed(simulator, every, every)}

    lost = formulas(signals) - formulas(pure)
    assert ("trail", "5*absolute(kappa)") in lost
    assert ("friction", "5*absolute(tan(alpha))") in lost
    assert ("side force", "5*absolute(tan(alpha))*5*absolute(kappa)") in lost
    assert {("trail", "5*absolute(tan(alpha))"), ("friction", "5*sqrt(tan(alpha)**2 + kappa**2)")} <= formulas(pure)


def test_the_states_of_a_proposal_resemble_the_features(at_true_values):
    """Rates and memories are written as an effect, which a tire simulates: both change the forces alike.

    A direction turns at once where it is computed from a recording, but over a width as the state of a tire.
    """
    simulator, size = at_true_values.problem.simulator, 0.02
    place = next(one for one in locations_of(simulator.symbolic_model) if one.name == "friction")
    past = [one for many in features(at_true_values.signals, simulator.tire) for one in many if one.states]
    assert {state for one in past for state in one.states} == STATES.keys()
    effect = effect_of(UnexplainedStructure(place, tuple(past), (size,) * len(past)))
    tire = replace(simulator.tire, added=(*simulator.tire.added, effect))
    signals = at_true_values.signals.with_inputs_of(tire)
    assert signals.names == tire.inputs
    extended, parameters = Simulator(tire, signals), tire.parameters()
    own = [extended.index[name] for name in simulator.names]
    parameters[own] = simulator.tire.parameters()
    without, direction = (
        extended.forces(parameters),
        directions(at_true_values.problem.simulator, at_true_values.solution.parameters)["friction", False],
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


def test_a_formula_has_its_variables_and_sizes(at_true_values):
    simulator = at_true_values.problem.simulator
    (place,) = [one for one in locations_of(simulator.symbolic_model) if one.name == "side force"]
    even, _ = features(at_true_values.signals, simulator.tire)
    (camber,) = [one for one in even if one.text == "10*absolute(gamma)"]
    structure = UnexplainedStructure(place, (camber,), (0.25,))
    assert structure.depends_on == ("Fz", "gamma")
    assert structure.formula.endswith("term: +0.25*10*absolute(gamma)")
    assert replace(structure, sizes=(-0.5,)).formula.endswith("term: -0.5*10*absolute(gamma)")
    effect = effect_of(structure)
    assert effect.name == "found_fz_gamma"
    assert [one.name for one in effect.declarations] == ["FOUND1"]


def test_no_effect_of_the_library_has_the_states_of_a_proposal():
    assert STATES.keys().isdisjoint(state.name for effect in library().values() for state in effect.states)
