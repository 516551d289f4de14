"""Probabilities of explanations: the evidence is that of the Gaussian model, and the answer is a distribution."""

import itertools
import signal
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from tirefmu.diagnosis.diagnose import _start_model, with_library
from tirefmu.diagnosis.explanations import (
    UNKNOWN,
    Addition,
    Budget,
    Ended,
    Explanation,
    Gain,
    Linearization,
    NormalEquations,
    Projected,
    Table,
    Term,
    answer_of,
    best_formula,
    compare,
    compared,
    effect_discrepancy,
    grip_drift,
    model_discrepancy,
    percent,
    projected,
    refitted,
    reproduced_terms,
    rivals_of,
    shared_problem,
    smooth_functions,
    terms_of_form,
    unknown_terms,
    without_folds,
)
from tirefmu.diagnosis.explanations.compare import _simplest, reduced
from tirefmu.diagnosis.explanations.effect_evidence import rival_of, with_rivals
from tirefmu.diagnosis.probing import candidates_for, fit_baseline
from tirefmu.diagnosis.signals import CROSS_TALK, between_rows, signals_of
from tirefmu.diagnosis.thresholds import DISCREPANCIES, EFFECT_ODDS, INEXACT_SHARE
from tirefmu.diagnosis.unexplained.features import Feature, Location, directions
from tirefmu.measurements import recording_from
from tirefmu.symbolic.detection import Form

from .suite import make_case


def equations(columns, residual, deviations):
    return NormalEquations(
        columns.T @ columns,
        columns.T @ residual,
        float(residual @ residual),
        deviations**-2.0,
        np.zeros(len(deviations)),
    )


@pytest.fixture(scope="module")
def linear_problem():
    rng = np.random.default_rng(4)
    columns, deviations = rng.standard_normal((40, 6)), rng.uniform(0.3, 3.0, 6)
    return columns, columns @ (deviations * rng.standard_normal(6)) + rng.standard_normal(40), deviations


def test_the_evidence_is_the_density_of_the_residual(linear_problem):
    columns, residual, deviations = linear_problem
    values = []
    for count in (0, 3, 6):
        part, own = columns[:, :count], deviations[:count]
        density = multivariate_normal(np.zeros(40), np.eye(40) + (part * own**2) @ part.T).logpdf(residual)
        evidence = equations(part, residual, own).solved()[1] if count else -0.5 * float(residual @ residual)
        values.append(density - evidence)
    assert values == pytest.approx([-20.0 * np.log(2.0 * np.pi)] * 3, rel=1e-9)


def test_values_away_from_their_prior_means_have_the_same_evidence(linear_problem):
    columns, residual, deviations = linear_problem
    shift = np.linspace(-1.0, 1.0, 6)
    distances = shift / deviations
    moved = residual - columns @ shift
    there = NormalEquations(
        columns.T @ columns, columns.T @ moved, float(moved @ moved + distances @ distances), deviations**-2.0,
        -distances / deviations,
    )  # fmt: skip
    estimate, evidence = there.solved()
    assert evidence == pytest.approx(equations(columns, residual, deviations).solved()[1], rel=1e-9)
    assert estimate + shift == pytest.approx(equations(columns, residual, deviations).solved()[0], rel=1e-6)


def test_the_gain_of_an_addition_is_the_difference_of_evidences(linear_problem):
    columns, residual, deviations = linear_problem
    projected = Projected.of(equations(columns, residual, deviations), [1, 2])
    without = equations(columns[:, :3], residual, deviations[:3]).solved()[1]
    for group, kept in zip(projected.groups, ([0, 1, 2, 3], [0, 1, 2, 4, 5]), strict=True):
        estimate, evidence = equations(columns[:, kept], residual, deviations[kept]).solved()
        gain, own = projected.gain(group)
        assert gain == pytest.approx(evidence - without, rel=1e-9)
        assert own * deviations[kept[3:]] == pytest.approx(estimate[3:], rel=1e-6)


def test_a_column_is_correlated_with_the_columns_that_reproduce_it(linear_problem):
    columns, residual, deviations = linear_problem
    repeated = np.column_stack([columns, columns[:, 3] - 2.0 * columns[:, 4]])
    projected = Projected.of(equations(repeated, residual, np.append(deviations, 1.0)), [1, 2, 1])
    assert projected.correlations(slice(0, 1))[0] == pytest.approx(1.0)
    with_both = Projected.of(equations(repeated[:, [0, 1, 2, 3, 4, 6]], residual, np.ones(6)), [2, 1])
    assert with_both.correlations(slice(0, 2))[2] == pytest.approx(1.0, abs=1e-6)
    assert np.all(projected.correlations(slice(0, 1)) <= 1.0 + 1e-9)


def test_the_evidence_of_limited_coefficients_is_the_integral_within_their_limits(linear_problem):
    """Of two coefficients whose columns are orthogonal; the second one is pushed beyond its limit."""
    columns = np.linalg.qr(linear_problem[0][:, :2])[0]
    residual, deviations = columns @ np.array([1.0, -2.5]), np.array([1.0, 2.0])
    limits = np.array([[-0.5, 0.0], [0.8, 3.0]])
    limited = replace(equations(columns, residual, deviations), limits=limits)
    axes = [np.linspace(*ends, 4001) for ends in limits.T]
    density = 0.0
    for axis, deviation, along in zip(axes, deviations, columns.T @ residual, strict=True):
        prior = np.exp(-0.5 * (axis / deviation) ** 2)
        likelihood = np.exp(along * axis - 0.5 * axis**2)
        whole = np.trapezoid(prior, axis)
        density += np.log(np.trapezoid(prior * likelihood, axis) / whole)
    assert limited.solved()[1] == pytest.approx(density - 0.5 * float(residual @ residual), abs=1e-5)


# ------------------------------------------------------------------ the answer


def test_an_effect_with_the_same_columns_is_tried_in_place_of_another_one():
    rng = np.random.default_rng(0)
    fixed, part, other = rng.standard_normal((3, 400, 1))
    same = 0.5 * part + fixed  # all that differs is in the explanation already
    rows = np.concatenate([1e3 * fixed, part, same, other], axis=1)
    matrix = rows.T @ rows
    columns = Projected.of(NormalEquations(matrix, matrix[1], matrix[1, 1], np.ones(4), np.zeros(4)), [1, 1, 1])
    additions = [Addition(name, np.zeros((1, 1, 1)), np.ones(1)) for name in ("same", "other")]
    ((name, gain),) = rivals_of(columns, additions).items()
    assert name == "same"
    assert gain.estimate == pytest.approx([2.0], rel=0.05)  # it has the size of the part


def test_the_effects_most_like_another_one_are_tried_in_its_place():
    rng = np.random.default_rng(1)
    part, *others = np.linalg.qr(rng.standard_normal((400, 7)))[0].T
    shares = {"third": 0.45, "unlike": 0.2, "first": 0.9, "fourth": 0.4, "second": 0.6}  # correlation with the part
    alike = [c * part + np.sqrt(1.0 - c**2) * other for c, other in zip(shares.values(), others, strict=False)]
    rows = 1e3 * np.stack([part, *alike], axis=1)
    matrix = rows.T @ rows
    columns = Projected.of(NormalEquations(matrix, matrix[0], matrix[0, 0], np.ones(6), np.zeros(6)), [1] * 6)
    additions = [Addition(name, np.zeros((1, 1, 1)), np.ones(1)) for name in shares]
    assert list(rivals_of(columns, additions)) == ["first", "second", "third"]
    few = NormalEquations(matrix[:3, :3], matrix[0, :3], matrix[0, 0], np.ones(3), np.zeros(3))
    assert list(rivals_of(Projected.of(few, [1] * 3), additions[:2])) == ["third"]


def test_the_answer_is_a_distribution_over_explanations():
    evidences = {(): 0.0, ("conicity",): 3.0, ("conicity", UNKNOWN): 1.0, ("plysteer",): 2.0}
    answer = answer_of(evidences, ["conicity", "plysteer", "wear_drift"])
    probabilities = [one.probability for one in answer.explanations]
    assert sum(probabilities) == pytest.approx(1.0)
    assert probabilities == sorted(probabilities, reverse=True)
    assert answer.explanations[0].effects == ("conicity",)
    weights = np.exp([0.0, 3.0, 1.0, 2.0]) / np.exp([0.0, 3.0, 1.0, 2.0]).sum()
    expected = {"conicity": weights[1] + weights[2], "plysteer": weights[3], "wear_drift": 0.0, UNKNOWN: weights[2]}
    assert answer.probabilities == pytest.approx(expected)


def test_probabilities_are_averaged_over_recordings():
    """What is certain in each half and contradicted by the other half is not certain."""
    halves = {("conicity",): np.array([20.0, 0.0]), ("plysteer",): np.array([0.0, 20.0])}
    answer = answer_of(halves, ["conicity", "plysteer"])
    assert answer.probabilities["conicity"] == pytest.approx(0.5)
    assert answer.one_of(["conicity"])[0].effects == ("conicity", "plysteer")


def test_a_class_has_exactly_one_missing_effect():
    """Neither a certain effect nor one that is missing together with another one is in a class."""
    sets = {("a", "b"): 0.0, ("a", "c"): 0.0, ("a", "b", "d"): -0.5, ("a", "c", "d"): -0.5}
    answer = answer_of(sets, list("abcd"))
    assert [one.effects for one in answer.one_of("abd")] == [("b", "c")]
    assert answer.one_of("a") == ()
    assert answer.one_of("d") == ()  # nothing takes its place
    assert answer_of({("b",): 0.0, ("c",): 0.0, (): 0.0}, list("bc")).one_of("b") == ()


def test_no_effect_is_in_two_classes():
    """Over random evidences of all explanations with up to three of five effects."""
    rng, several = np.random.default_rng(4), 0
    explanations = [parts for number in range(4) for parts in itertools.combinations("abcde", number)]
    for _ in range(300):
        answer = answer_of(dict(zip(explanations, rng.normal(0.0, 6.0, len(explanations)), strict=True)), list("abcde"))
        classes = answer.one_of("abcde")
        names = [name for alternatives in classes for name in alternatives.effects]
        assert len(names) == len(set(names))
        assert all(0.9 < alternatives.probability <= 1.0 for alternatives in classes)
        several += len(classes) > 1
    assert several


def test_the_simplest_of_equal_effects_is_delivered():
    """Fewest states, then most probable; an explanation that is much less probable than the leader is not taken."""
    sets = {("history", "lag"): 0.0, ("lag", "temperature"): -0.6, ("lag", "pressure"): -0.3}
    table, names = compared_table(sets), ["history", "lag", "temperature", "pressure"]
    assert _simplest(table, answer_of(sets, names)).explanation.effects == ("lag", "pressure")
    far = {**sets, ("lag", "temperature"): -4.0, ("lag", "pressure"): -4.0}
    assert _simplest(table, answer_of(far, names)) is table.leader
    alone = answer_of({("history", "lag"): 0.0}, ["history", "lag", "temperature"])
    assert _simplest(table, alone) is table.leader


@pytest.mark.parametrize(
    ("lead", "cautious", "delivered"), [(2.0, 0.3, ("a",)), (2.6, 0.3, ("a", "b")), (2.0, 0.6, ("a", "b"))]
)
def test_what_only_weak_evidence_adds_is_not_delivered_unless_it_is_called_missing(lead, cautious, delivered):
    """Evidence of less than ten to one is weak: a logarithm of 2.3."""
    table = compared_table({("a", "b"): 0.0, ("a",): -lead, (): -90.0})
    answer = answer_of({("a", "b"): np.log(cautious), ("a",): np.log(1.0 - cautious)}, ["a", "b"])
    assert _simplest(table, answer).explanation.effects == delivered


def test_what_is_called_missing_is_delivered():
    """Probabilities are more cautious than scores: they may prefer an effect that the leader lacks."""
    table = compared_table({("a", "b"): 0.0, ("c",): -8.0, ("c", "d"): -9.0})
    answer = answer_of({("a", "b"): 0.0, ("c",): 2.0, ("c", "d"): -2.0}, list("abcd"))
    assert _simplest(table, answer).explanation.effects == ("c",)


def test_a_rival_shares_what_exactly_one_of_both_explains_and_nothing_else_changes():
    """Over random evidences of all explanations with up to three of three effects and an unknown one."""
    rng, parts = np.random.default_rng(5), ("a", "b", "c", UNKNOWN)
    explanations = [some for number in range(4) for some in itertools.combinations(parts, number)]
    for better in (True, False):
        evidences = dict(zip(explanations, rng.normal(0.0, 2.0, len(explanations)), strict=True))
        before = answer_of(evidences, list("abc"))
        after = before.with_rival("a", "b", better=better)
        assert {one.parts for one in after.explanations} == set(explanations)
        assert len(after.explanations) == len(explanations)
        others = [[of.probabilities[name] for name in ("c", UNKNOWN)] for of in (before, after)]
        assert others[0] == pytest.approx(others[1])
        alone = [
            sum(one.probability for one in after.explanations if {*one.effects} & {"a", "b"} == {name}) for name in "ab"
        ]
        assert alone[0] / alone[1] == pytest.approx(2.0 if better else 0.5)
        assert after._exactly_one("ab") == pytest.approx(before._exactly_one("ab"))


OF_EVIDENCE = rival_of.__module__
RIVALS_COMPARED = {
    ("heat", "lag"): 0.0, ("history", "lag"): -20.0, ("lag", "pressure"): -70.0, ("lag",): -100.0,
    ("heat",): -30.0, ("history",): -50.0, (): -200.0,
}  # fmt: skip


def test_a_rival_is_confounded_and_explains_half_of_what_an_effect_does(monkeypatch):
    """Beside the same others, in the most probable explanation with the effect."""
    alike = {"history": 0.9, "pressure": 0.95, "lag": 0.1}

    def correlation(effect, refit, other):
        (rival,) = {*other.explanation.effects} - {*refit.explanation.effects}
        return alike[rival]

    monkeypatch.setattr(f"{OF_EVIDENCE}.alike", correlation)
    table = compared_table(RIVALS_COMPARED)
    pair = rival_of("heat", table, ())
    assert pair is not None
    assert [of.explanation.effects for of in pair] == [("heat", "lag"), ("history", "lag")]
    assert rival_of("heat", table, ("history",)) is None  # pressure explains a third of it
    assert rival_of("lag", table, ()) is None  # history would explain as much, but differently
    assert rival_of("wear", table, ()) is None


@pytest.mark.parametrize(
    ("proof", "heat", "delivered"),
    [(5.0, 1.0, "heat"), (0.0, 2.0 / 3.0, "heat"), (-1.9, 2.0 / 3.0, "heat"), (-2.1, 1.0 / 3.0, "history")],
)
def test_between_rivals_the_prediction_of_the_tires_has_to_agree(monkeypatch, proof, heat, delivered):
    monkeypatch.setattr(f"{OF_EVIDENCE}.alike", lambda effect, refit, other: 0.9)
    monkeypatch.setattr(f"{OF_EVIDENCE}.fitted_as_tire", lambda *of: of)
    monkeypatch.setattr(f"{OF_EVIDENCE}.Screen", lambda *of: None)
    monkeypatch.setattr(f"{OF_EVIDENCE}.proof_over", lambda after, without: proof)
    sets = {parts: RIVALS_COMPARED[parts] for parts in (("heat", "lag"), ("history", "lag"), ("lag",))}
    table, names = compared_table(sets), ["heat", "history", "lag"]
    answer, leader = with_rivals(answer_of({("heat", "lag"): 0.0}, names), table.leader, table, None, None)
    assert answer.probabilities["heat"] == pytest.approx(heat)
    assert answer.probabilities["history"] == pytest.approx(1.0 - heat)
    assert answer.probabilities["lag"] == pytest.approx(1.0)
    assert leader.explanation.effects == tuple(sorted((delivered, "lag")))


def test_a_rival_takes_the_place_of_an_effect_and_the_rest_of_the_leader_stays(monkeypatch):
    """Also an unknown component; an explanation with both loses the effect."""
    monkeypatch.setattr(f"{OF_EVIDENCE}.alike", lambda effect, refit, other: 0.9)
    monkeypatch.setattr(f"{OF_EVIDENCE}.fitted_as_tire", lambda *of: of)
    monkeypatch.setattr(f"{OF_EVIDENCE}.Screen", lambda *of: None)
    monkeypatch.setattr(f"{OF_EVIDENCE}.proof_over", lambda after, without: -3.0)
    pair = {("heat",): -1.0, ("history",): -2.0, (): -90.0}
    for leading, left in ((("heat", UNKNOWN), ("history", UNKNOWN)), (("heat", "history", "lag"), ("history", "lag"))):
        table = compared_table({leading: -3.0, left: -4.0, **pair})
        _, leader = with_rivals(answer_of({("heat",): 0.0}, ["heat", "history"]), table.leader, table, None, None)
        assert leader is table.refits[left]


def compared_table(sets):
    """Of refits by their effects with their scores; the first one leads."""

    def refit(effects, score):
        forms = tuple((name, Form((), ())) for name in effects if name != UNKNOWN)
        explanation = Explanation(forms, ("term",) * (UNKNOWN in effects))
        linear = SimpleNamespace(solution=SimpleNamespace(free=()))
        return SimpleNamespace(explanation=explanation, score=score, linear=linear)

    refits = {parts: refit(parts, score) for parts, score in sets.items()}
    model = SimpleNamespace(added=[SimpleNamespace(name="history", states=("s",))])
    shared = SimpleNamespace(problem=SimpleNamespace(simulator=SimpleNamespace(symbolic_model=model)))
    leader = next(iter(refits.values()))
    return SimpleNamespace(refits=refits, leader=leader, shared=shared, scores=sets, divided=lambda: sets)


def test_the_reported_explanations_have_nearly_all_of_the_probability():
    evidences = {(f"effect_{i}",): -float(i) for i in range(30)}
    answer = answer_of(evidences, [f"effect_{i}" for i in range(30)])
    assert 0.99 <= sum(one.probability for one in answer.reported) < 0.999
    assert len(answer.reported) < len(answer.explanations)


def test_evidences_of_any_size_give_probabilities():
    answer = answer_of({(): -1e5, ("conicity",): -1e5 + 800.0}, ["conicity"])
    assert answer.probabilities["conicity"] == 1.0


def test_a_probability_is_never_certainty_in_words():
    texts = [percent(value) for value in (1.0, 0.91, 0.9, 0.5, 0.0)]
    assert texts == ["over 90 %", "over 90 %", "50 to 90 %", "50 to 90 %", "under 10 %"]


# ------------------------------------------------------------------ what every explanation contains


def test_smooth_functions_are_a_process_of_variance_one(at_true_values):
    named = at_true_values.problem.simulator.signals.named()
    inputs = {name: named[name] for name in ("alpha", "Fz")}
    many = smooth_functions(inputs, 4000)
    assert np.sum(many**2, axis=1) == pytest.approx(1.0, abs=0.1)
    np.testing.assert_array_equal(many, smooth_functions(inputs, 4000))


def test_discrepancies_are_proportional_to_what_they_belong_to(at_true_values):
    simulator = at_true_values.problem.simulator
    forces = simulator.forces(at_true_values.solution.parameters)
    columns = model_discrepancy(simulator.signals, forces)
    np.testing.assert_allclose(model_discrepancy(simulator.signals, 2.0 * forces), 2.0 * columns)
    response = np.zeros_like(forces)
    response[1] = forces[1]
    of_effect = effect_discrepancy(response, {"Fz": simulator.signals.named()["Fz"]})
    assert not of_effect[[0, 2]].any()
    assert of_effect[1].any()
    without_fy = forces.copy()
    without_fy[simulator.signals.channels.index("Fy")] = 0.0
    of_moment = model_discrepancy(simulator.signals, without_fy)[simulator.signals.channels.index("Mz")]
    assert of_moment.any()  # Fx, too, may act beside the center


def test_the_grip_of_every_explanation_may_drift_in_all_channels_alike(at_true_values):
    simulator = at_true_values.problem.simulator
    forces = simulator.forces(at_true_values.solution.parameters)
    columns, deviation = grip_drift(simulator.signals, forces)
    shares = columns / forces[:, :, None]
    np.testing.assert_allclose(shares, np.broadcast_to(shares[0], shares.shape))
    assert (np.abs(shares) <= 1.0 + 1e-12).all()
    assert (np.diff(deviation) < 0.0).all()  # slow drift is larger
    untimed = replace(simulator.signals, timed=False)
    assert grip_drift(untimed, forces)[0].shape == (*forces.shape, 0)


def test_final_fits_know_the_cross_talk_of_a_bench_and_no_larger_one(at_true_values, tire):
    problem, solution, name = at_true_values.problem, at_true_values.solution, "cross_talk_Fy_in_Fx"
    signals, column = (
        problem.simulator.signals,
        problem.disturbances.columns[:, :, problem.disturbances.names.index(name)],
    )
    for share, expected in ((0.02, pytest.approx(0.02, rel=0.1)), (0.05, 0.0)):
        recorded = replace(signals, measured=signals.measured + share * column)
        other = problem.over(problem.simulator.with_signals(recorded))
        at = other.at(solution.parameters, solution.free)
        errors = Linearization(Explanation(), other, at, candidates_for(tire)).errors_of_bench(CROSS_TALK)
        assert errors[name] == expected
        assert set(errors) == {one for one in problem.disturbances.names if one.startswith(CROSS_TALK)}


def test_a_coefficient_at_its_bound_is_a_constant(at_true_values, tire):
    problem = at_true_values.problem
    solution = at_true_values.solution
    candidates = candidates_for(tire)
    at_bound = solution.parameters.copy()
    at_bound[problem.simulator.index["PHY1"]] = problem.bounds(["PHY1"])[1][0]
    inside, outside = (
        Linearization(Explanation(), problem, one, candidates).equations()
        for one in (solution, replace(solution, parameters=at_bound))
    )
    assert len(outside.target) == len(inside.target) - 1


def test_terms_in_the_inputs_of_the_explanation_are_errors_of_form(at_true_values, tire):
    problem, solution = at_true_values.problem, at_true_values.solution
    candidates = candidates_for(replace(tire, effects=tuple(tire.has - {"camber_thrust"})))
    terms = unknown_terms(problem, solution)
    assert all(np.isfinite(one.column).all() and one.deviation > 0.0 for one in terms)
    errors = []
    for forms in ((), (("camber_thrust", candidates["camber_thrust"].forms[0]),)):
        of_form = Linearization(Explanation(forms), problem, solution, candidates).form_errors
        errors.append(
            {(one.location.name, one.feature.text): of_form.contain(one.location, one.depends_on) for one in terms}
        )
    nothing, leaning = errors
    assert nothing["friction", "Fz/FNOMIN - 1"]
    assert nothing["side force", "5*tan(alpha)"]
    assert not nothing["friction", "10*absolute(gamma)"]
    assert not nothing["side force", "10*gamma"]
    assert leaning["friction", "10*absolute(gamma)"]
    assert leaning["side force", "10*gamma"]
    assert not leaning["friction", "slip of the last 1 s"]


def test_an_explanation_without_a_part():
    term, other = (Term(None, None, np.zeros((1, 1)), 1.0, -2.0) for _ in range(2))
    one = Explanation((("conicity", Form((), ())),), (term, other))
    assert one.parts == ("conicity", UNKNOWN)
    assert one.without(UNKNOWN).parts == ("conicity",)
    assert one.without("conicity").terms == (term, other)
    assert one.log_prior == pytest.approx(2.0 * np.log(EFFECT_ODDS) - 4.0)
    assert [other.terms for other in one.with_a_term_less()] == [(other,), (term,)]
    assert one.with_effect("plysteer", Form((), ())).effects == ("conicity", "plysteer")
    assert one.with_term(term).terms == (term, other, term)


# ------------------------------------------------------------------ the comparison


def unlimited():
    return Budget(lambda sentence: None, None)


def of_case(hidden):
    """Return the baseline problem of a made recording, its solution, and some candidates."""
    case = make_case(13, hidden)
    recording = recording_from(case.table, signs=case.signs)
    start = with_library(_start_model(recording, "mf96", case.effects, case.nominal))
    problem, solution = fit_baseline(start, signals_of(case.table, start, case.signs), fitted=False)
    names = ("conicity", "plysteer", "camber_thrust", "pressure_friction", "load_lag")
    return problem, solution, {name: one for name, one in candidates_for(start).items() if name in names}


@pytest.fixture(scope="module")
def sideways():
    """Return the problem of a recording whose tire has a conicity."""
    return of_case(("conicity",))


@pytest.fixture(scope="module")
def complete():
    """Return the problem of a recording whose tire lacks nothing."""
    return of_case(())


def test_a_coefficient_beyond_its_bound_gains_nothing(sideways):
    """What a lag of the load gains is lost if the same forces have the other sign: its friction is at least 0."""
    problem, solution, candidates = sideways
    simulator, absent = problem.simulator, Linearization(Explanation(), problem, solution, candidates)
    addition, at = absent.of_effect("load_lag")[0], solution.parameters
    lagging = at.copy()
    lagging[simulator.index["LLMU"]] = 0.3
    change, gains = simulator.forces(lagging) - simulator.forces(at), []
    for sign, start in ((1.0, 0.3), (-1.0, 1e-4)):
        signals = replace(simulator.signals, measured=simulator.signals.measured + sign * change)
        moved = problem.over(simulator.with_signals(signals))
        near, free = at.copy(), (*solution.free, *addition.form.free)
        near[simulator.index["LLMU"]] = start
        explanation = Explanation((("load_lag", addition.form),))
        with_lag = Linearization(explanation, moved, moved.at(near, free), candidates)
        without = Linearization(Explanation(), moved, moved.at(at, solution.free), candidates)
        gains.append(with_lag.equations().solved()[1] - without.equations().solved()[1])
    assert gains[0] > 10.0
    assert gains[1] < 0.0


def test_a_coefficient_of_two_effects_belongs_to_both(sideways):
    """Whatever the explanation beside which one of them is added: both heat up with one time constant."""
    problem, solution, _ = sideways
    candidates = candidates_for(problem.simulator.tire)
    forms = {name: candidates[name].forms[0] for name in ("heat_friction", "heat_stiffness")}
    assert "HTAU" in forms["heat_friction"].free
    warm = Explanation((("heat_stiffness", forms["heat_stiffness"]),))
    at = problem.at(solution.parameters, (*solution.free, *forms["heat_stiffness"].free))
    beside = Linearization(warm, problem, at, candidates).of_effect("heat_friction")
    alone = Linearization(Explanation(), problem, solution, candidates).of_effect("heat_friction")
    assert {addition.form.free for addition in beside} == {addition.form.free for addition in alone}
    both = warm.with_effect("heat_friction", forms["heat_friction"])
    assert (both.owner("HTAU"), both.owner("HK")) == ("", "heat_stiffness")
    assert both.without("heat_stiffness").owner("HTAU") == "heat_friction"


def test_an_effect_takes_the_place_of_its_special_case():
    relaxation = SimpleNamespace(reads=frozenset({"alpha"}), contains="")
    with_load = SimpleNamespace(reads=frozenset({"alpha", "Fz"}), contains="lateral")
    candidates = {"lateral": relaxation, "with_load": with_load, "other": relaxation}
    problem = SimpleNamespace(simulator=SimpleNamespace(symbolic_model=SimpleNamespace(added=(), relaxing_effects=())))
    table = SimpleNamespace(shared=SimpleNamespace(candidates=candidates, problem=problem))
    two = Explanation((("lateral", Form((), ())), ("other", Form((), ()))))
    more = compare._with_form(table, two, "with_load", Form((), ()))
    assert more.effects == ("other", "with_load")
    relaxing = Explanation((("lateral", Form.each({"SIGY": 0.2})), ("other", Form.each({"PHY1": 0.1}))))
    index = {"SIGY": 0, "PHY1": 1, "SIGC": 2}
    linear = SimpleNamespace(solution=SimpleNamespace(parameters=np.ones(3)), simulator=SimpleNamespace(index=index))
    compared_before = Table(None, np.zeros(3), {})
    less = Explanation((("other", Form.each({"PHY1": 0.1})),))
    for other, expected in ((less, [0, 1, 1]), (less.with_effect("with_load", Form.each({"SIGY": 0.2})), [1, 1, 1])):
        start = compared_before.without(SimpleNamespace(explanation=relaxing, linear=linear), other)
        assert start.tolist() == expected  # no coefficient of an effect that is absent remains
    assert Linearization(more, problem, None, candidates).lacking == []


def test_what_a_formula_explains_is_no_evidence_of_an_effect_in_its_place():
    """An effect of which the formula is an error of form takes its place: its own evidence comes from other tables."""
    place = Location("friction", "factor", ("mu_y",), ("PDY1",))
    term = Term(place, Feature("p", frozenset({"p"}), np.ones(1)), np.ones((1, 1)), 1.0)
    candidates = {name: SimpleNamespace(reads=frozenset({name}), contains="") for name in ("p", "T")}
    problem = SimpleNamespace(simulator=SimpleNamespace(symbolic_model=SimpleNamespace(added=(), relaxing_effects=())))
    refit = SimpleNamespace(explanation=Explanation((), (term,)), evidence=50.0, linear=None)
    recorded = []
    table = SimpleNamespace(
        shared=SimpleNamespace(candidates=candidates, problem=problem), scores={(UNKNOWN,): 100.0}, refits={},
        report=lambda sentence: None,
        with_linear=lambda parts, evidence, prior: recorded.append(parts) or table,
    )  # fmt: skip
    alone = {name: Addition(name, np.zeros((1, 1, 1)), np.ones(1)) for name in candidates}
    added = {name: [Gain(1.0, addition, np.zeros(1), 1.0)] for name, addition in alone.items()}
    list(compare.extended(table, added, refit))
    assert recorded == [("T", UNKNOWN)]


def test_noise_alone_has_neither_an_effect_nor_a_formula():
    comparison = compared(*of_case(()), unlimited())
    assert comparison.leader.explanation.effects == ()
    assert max(comparison.answer.probabilities.values()) < 0.1


def test_an_error_of_the_form_of_a_moment_is_no_effect():
    problem, solution, candidates = of_case(())
    signals, values = problem.simulator.signals, problem.simulator.tire.values
    named, measured = signals.named(), signals.measured.copy()
    slip = np.hypot(np.tan(named["alpha"]), named["kappa"])
    measured[signals.channels.index("Mz")] += 0.02 * slip * named["Fz"] * values["UNLOADED_RADIUS"]
    moved = problem.over(problem.simulator.with_signals(replace(signals, measured=measured)))
    fitted = moved.solve(solution.parameters, solution.free)
    comparison = compared(moved, fitted, candidates, unlimited())
    assert comparison.leader.explanation.parts == ()


def test_the_best_explanation_is_the_true_one(sideways):
    comparison = compared(*sideways, unlimited())
    assert comparison.leader.explanation.effects == ("conicity",)
    assert comparison.answer.probabilities["conicity"] > 0.9
    assert comparison.answer.explanations[0].effects == ("conicity",)
    assert not comparison.stopped
    assert comparison.shared.explained == 0.0  # the error of its form is in the comparison


def table_of(evidences, static):
    """Return a table of refits with evidences by their effects; some effects are static."""

    def refit(names, evidence):
        explanations = [
            Explanation(tuple((name, Form((), ())) for name in some)) for some in (names, static & {*names})
        ]
        linear = SimpleNamespace(responses=SimpleNamespace(static=explanations[1]))
        return SimpleNamespace(explanation=explanations[0], evidence=evidence, score=evidence, linear=linear)

    refits = {names: refit(names, evidence) for names, evidence in evidences.items()}
    return Table(SimpleNamespace(explained=0.0), np.zeros(1), {}, refits)


def test_the_best_explanation_without_a_certain_part_is_searched_as_the_leading_ones_are():
    """Not without one that is not certain, nor one that is hopeless."""
    evidences = {(): 0.0, ("lag",): 40.0, ("heat", "lag"): 85.0, ("history", "lag"): 100.0, ("history",): 10.0}
    assert table_of(evidences, set()).doubts == [("heat", "lag")]
    assert table_of({**evidences, ("heat", "lag"): 99.0}, set()).doubts == []
    assert table_of({(): 0.0, ("lag",): 1.0}, set()).doubts == []


def test_two_similar_effects_begin_with_half_of_each_and_their_memories(monkeypatch):
    forms = {
        "history": Form.each({"SHMUY": 0.1}, grid={"SHWID": (0.02,)}),
        "heat": Form.each({"HMU": 0.1}, grid={"HTAU": (2.0,)}),
    }
    simulator = SimpleNamespace(index={"PDY1": 0, "SHMUY": 1, "SHWID": 2, "HMU": 3, "HTAU": 4})

    def refit(effect, parameters, score):
        linear = SimpleNamespace(solution=SimpleNamespace(parameters=np.array(parameters)), simulator=simulator)
        return SimpleNamespace(explanation=Explanation(((effect, forms[effect]),)), linear=linear, score=score)

    history = refit("history", [1.0, 0.4, 0.05, 0.0, 2.0], 5.0)
    heat = refit("heat", [1.2, 0.0, 0.02, 0.3, 8.0], 4.0)
    refits = {("history",): history, ("heat",): heat}
    requires = dict.fromkeys(forms, SimpleNamespace(reads=frozenset({"alpha"}), contains=""))
    model = SimpleNamespace(added=(), relaxing_effects=())
    problem = SimpleNamespace(simulator=SimpleNamespace(symbolic_model=model))
    shared = SimpleNamespace(candidates=requires, problem=problem)
    table = SimpleNamespace(
        refits=refits, shared=shared, is_far=lambda parts: False, compared=lambda more: False,
        report=lambda sentence: None, with_refit=lambda refit: refit,
        without=lambda refit, more: refit.linear.solution.parameters,
    )  # fmt: skip
    monkeypatch.setattr(compare, "refitted", lambda shared, more, begins, at: (more.effects, begins[0].tolist()))
    effects, start = next(compare._with_both(table, history, "history"))
    assert effects == ("heat", "history")
    assert start == pytest.approx([1.1, 0.2, 0.05, 0.15, 8.0])


def test_a_static_effect_that_is_found_counts_as_one_that_the_baseline_model_has():
    """What it explains does not hide a further effect, but probabilities are more cautious."""
    static = {"pressure"}
    found = table_of({(): 0.0, ("pressure",): 5000.0, ("lag", "pressure"): 5300.0}, static)
    known = table_of({(): 5000.0, ("lag",): 5300.0}, static)
    assert found.explained == known.explained == 300.0
    assert found.caution > known.caution
    assert (
        table_of({(): 0.0, ("lag", "pressure"): 5300.0}, static).explained == 5300.0
    )  # that part alone is not compared


def cancelled(sentence):
    raise KeyboardInterrupt


def ended(sentence):
    signal.raise_signal(signal.SIGTERM)


@pytest.mark.parametrize("how", [cancelled, ended])
def test_a_comparison_that_ends_early_has_the_best_so_far(sideways, how):
    with Budget(how, None) as budget:
        comparison = compared(*sideways, budget)
    assert comparison.stopped == "stopped on request"
    assert sum(explanation.probability for explanation in comparison.answer.explanations) == pytest.approx(1.0)
    comparison = compared(*sideways, Budget(lambda sentence: None, 1e-9))
    assert comparison.stopped == "stopped by the time limit of 1e-09 s"
    assert comparison.leader.explanation.parts in {one.parts for one in comparison.answer.explanations}


def test_a_comparison_that_ends_before_a_refit_has_what_was_complete_before(sideways):
    def ending_after(number):
        budget, checks = unlimited(), itertools.count()

        def check():
            if budget.answered and next(checks) >= number:
                raise Ended

        budget.check = check
        return compared(*sideways, budget)

    early, late = ending_after(0), ending_after(30)
    assert early.leader.explanation.parts == ()
    assert late.leader.score > early.leader.score
    assert late.leader.explanation.parts in {one.parts for one in late.answer.explanations}


def test_the_evidence_without_folds_is_that_of_as_many_rows(at_true_values, tire):
    """The mean over folds is near that of all rows, and a fold that says nothing changes nothing."""
    linear = Linearization(Explanation(), at_true_values.problem, at_true_values.solution, candidates_for(tire))
    whole = linear.equations()
    rows = np.arange(linear.problem.inverse_noise.shape[1])
    products = linear.products(rows)
    assert products[:-1, :-1] == pytest.approx(whole.matrix, rel=1e-6, abs=1e-6 * np.abs(whole.matrix).max())
    assert linear.products(rows[::2]) + linear.products(rows[1::2]) == pytest.approx(products, rel=1e-9, abs=1e-3)
    evidence, folds = whole.solved()[1], without_folds(linear)
    assert np.ptp(folds) > 0.0
    assert np.mean(folds) == pytest.approx(evidence, rel=0.1)


def test_formulas_of_slips_and_load_are_errors_of_form_where_no_effect_is_in_their_place(sideways):
    """A trail that differs between driving and braking: no effect of the library; plysteer: one of it."""
    problem, solution, candidates = sideways
    signals, forces = problem.simulator.signals, problem.simulator.forces(solution.parameters)
    of_trail = forces * (np.array(signals.channels) == "Mz")[:, None] * 8.0 * signals.named()["kappa"]
    steered = solution.parameters.copy()
    steered[problem.simulator.index["PHY1"]] += 0.01
    deviations = []
    for change in (of_trail, problem.simulator.forces(steered) - forces):
        recorded = replace(signals, measured=signals.measured + change)
        other = problem.over(problem.simulator.with_signals(recorded))
        linear = Linearization(Explanation(), other, other.at(solution.parameters, solution.free), candidates)
        additions = [addition for name in linear.lacking for addition in linear.of_effect(name)]
        disturbances = shared_problem(
            linear, linear.solution, additions, reproduced_terms(linear), 0.0, unlimited()
        ).problem.disturbances
        named = zip(disturbances.names, disturbances.deviation, strict=True)
        deviations.append({float(size) for name, size in named if name.startswith("discrepancy_formulas")})
    assert [len(sizes) for sizes in deviations] == [1, 1]
    assert min(deviations[0]) >= min(DISCREPANCIES) > 100.0 * max(deviations[1])


def test_the_gain_of_an_addition_is_that_of_the_explanation_with_it(sideways):
    """At the same coefficients, with what is not fitted of the effect: without its refinements it would gain less."""
    problem, solution, candidates = sideways
    without = Linearization(Explanation(), problem, solution, candidates)
    before, beyond_probes = without.equations().solved()[1], []
    for name in ("conicity", "plysteer", "camber_thrust"):
        addition = without.of_effect(name)[0]
        columns = projected(without, [addition])
        gain = Gain.of(addition, columns, columns.groups[0])
        free = tuple(sorted({*solution.free, *addition.form.free}, key=problem.simulator.names.index))
        explanation, at = Explanation(((name, addition.form),)), problem.at(solution.parameters, free)
        there = Linearization(explanation, problem, at, candidates).equations().solved()[1]
        assert there - before == pytest.approx(gain.gain, rel=0.01)
        beyond_probes.append(abs(gain.gain - gain.of_fitted))
    assert max(beyond_probes) > 1.0


def test_what_an_effect_of_slips_and_load_reproduces_is_no_error_of_form():
    """In a baseline model without load_stiffness, slip stiffness that follows the load is this effect."""
    case = make_case(13, ())
    recording = recording_from(case.table, signs=case.signs)
    effects = [name for name in case.effects if name != "load_stiffness"]
    start = with_library(_start_model(recording, "mf96", effects, case.nominal))
    problem, solution = fit_baseline(start, signals_of(case.table, start, case.signs), fitted=False)
    every = candidates_for(start)
    others = {name: candidate for name, candidate in every.items() if name != "load_stiffness"}
    linear = Linearization(Explanation(), problem, solution, every)
    alike, without = (reproduced_terms(replace(linear, candidates=some)) for some in (every, others))
    assert alike > without
    additions = [addition for name in linear.lacking for addition in linear.of_effect(name)]
    numbers = []
    for names in (frozenset[str](), alike):
        disturbances = shared_problem(linear, solution, additions, names, 0.0, unlimited()).problem.disturbances
        numbers.append(sum(name.startswith("discrepancy_formulas") for name in disturbances.names))
    assert numbers[0] == numbers[1] + len(alike)


def test_formulas_of_form_follow_the_skew(complete):
    """They are functions of the inputs that act, which are later than the recorded ones."""
    problem, solution, candidates = complete
    late = problem.over(problem.simulator.with_signals(problem.simulator.signals.delayed(0.02)))
    directions_of = []
    for of in (problem, late):
        linear = Linearization(Explanation(), of, of.at(solution.parameters, solution.free), candidates)
        additions = [addition for name in linear.lacking for addition in linear.of_effect(name)]
        shared = shared_problem(linear, solution, additions, frozenset(), 0.0, unlimited()).problem.disturbances
        formulas = [i for i, name in enumerate(shared.names) if name.startswith("discrepancy_formulas")]
        terms = terms_of_form(of, solution)
        assert len(terms) == len(formulas) > 0
        columns = np.stack([term.column for term in terms], axis=-1)
        unit = [values / np.linalg.norm(values, axis=(0, 1)) for values in (columns, shared.columns[:, :, formulas])]
        np.testing.assert_allclose(*unit, atol=1e-12)
        directions_of.append(unit[0])
    assert np.abs(directions_of[1] - directions_of[0]).max() > 1e-3


def test_a_formula_gains_beside_all_formulas_of_slips_and_load(complete):
    """A product of both slips is an error of the form of friction, and the temperature is none."""
    problem, solution, candidates = complete
    simulator = problem.simulator
    signals, friction = simulator.signals, directions(simulator, solution.parameters)["friction", False]
    alpha, kappa, temperature = (signals.named()[name] for name in ("alpha", "kappa", "T"))
    formulas = []
    for share in (7.5 * np.abs(np.tan(alpha)) * kappa, 0.05 * (temperature - temperature.mean()) / 20.0):
        recorded = replace(signals, measured=signals.measured + share * friction)
        other = problem.over(simulator.with_signals(recorded))
        linear = Linearization(Explanation(), other, other.at(solution.parameters, solution.free), candidates)
        additions = [addition for name in linear.lacking for addition in linear.of_effect(name)]
        shared = shared_problem(linear, linear.solution, additions, reproduced_terms(linear), 0.0, unlimited())
        formulas.append(best_formula(shared, refitted(shared, Explanation(), [solution.parameters], other.simulator)))
    assert formulas[0] is None
    assert frozenset({"T"}) in {term.depends_on for term in formulas[1].explanation.terms}


def test_a_misfit_counts_less_where_more_is_explained(sideways):
    problem, solution, candidates = sideways
    linear = Linearization(Explanation(), problem, solution, candidates)
    additions = [addition for name in linear.lacking for addition in linear.of_effect(name)]
    misfit = problem.misfit(solution.parameters)[:, :, None]
    squares = []
    for explained in (0.0, 1.0 / INEXACT_SHARE, 9.0 / INEXACT_SHARE):
        shared = shared_problem(linear, solution, additions, reproduced_terms(linear), explained, unlimited())
        squares.append(float(np.sum(shared.problem.weighted(misfit) ** 2)))
    assert squares == pytest.approx([squares[0], squares[0] / 2.0, squares[0] / 10.0], rel=1e-6)


def test_a_refit_that_begins_at_an_optimum_stays_there(sideways):
    problem, solution, candidates = sideways
    linear = Linearization(Explanation(), problem, solution, candidates)
    additions = [addition for name in linear.lacking for addition in linear.of_effect(name)]
    shared = shared_problem(linear, solution, additions, reproduced_terms(linear), 0.0, unlimited())
    first = refitted(shared, Explanation(), [solution.parameters], problem.simulator)
    again = refitted(shared, Explanation(), [first.linear.solution.parameters], first.linear.simulator)
    assert again.linear.solution.cost <= first.linear.solution.cost
    assert again.evidence == pytest.approx(first.evidence, abs=0.1)


@pytest.mark.slow
def test_what_is_compared_does_not_depend_on_the_order_of_the_candidates(sideways):
    problem, solution, candidates = sideways
    reverse = dict(reversed(candidates.items()))
    both = [compared(problem, solution, one, unlimited()).answer for one in (candidates, reverse)]
    assert both[0].probabilities == pytest.approx(both[1].probabilities, abs=1e-6)


def test_a_step_between_two_rows_is_not_a_measurement(at_true_values, problem):
    """The polynomial through the neighbors of a row misses half of a step, and nothing of most rows of a slow sweep."""
    simulator, parameters = problem.simulator, at_true_values.solution.parameters
    slow = between_rows(simulator, parameters)
    inputs = simulator.signals.inputs.copy()
    load = simulator.signals.names.index("Fz")
    inputs[load, 1000:] *= 1.5
    stepped = simulator.with_signals(replace(simulator.signals, inputs=inputs))
    wide = between_rows(stepped, parameters)
    jump = np.abs(stepped.forces(parameters) - simulator.forces(parameters))[:, 1000]
    at_step, far = wide[:, 998:1002].max(axis=1), np.r_[0:950, 1050:2300]
    assert at_step == pytest.approx(0.5 * jump / np.sqrt(3.0), rel=0.1)
    largest = 1e-3 * np.abs(simulator.forces(parameters)).max(axis=1)
    assert np.all(np.median(slow, axis=1) < largest)  # Mz of this model has a kink at alpha = 0 in combined slip
    assert np.all(np.median(wide[:, far], axis=1) < largest)


def test_the_evidence_without_an_effect_does_not_depend_on_its_size(at_true_values, tire):
    """It is that of the explanation without it, exactly if the effect is zero; else but for what is not linear."""
    problem, solution, candidates = at_true_values.problem, at_true_values.solution, candidates_for(tire)
    without = Linearization(Explanation(), problem, solution, candidates).equations().solved()[1]
    form, values = candidates["camber_stiffness"].forms[0], []
    for size in (0.0, 0.05):
        parameters = solution.parameters.copy()
        parameters[problem.simulator.index["PKY3"]] = size
        at = problem.at(parameters, (*solution.free, *form.free))
        linear = Linearization(Explanation((("camber_stiffness", form),)), problem, at, candidates)
        values.append(linear.evidence_without("camber_stiffness"))
    assert values[0] == pytest.approx(without, rel=1e-9)
    power = float(np.sum(problem.weighted(linear.responses.of("camber_stiffness")) ** 2))
    assert values[1] == pytest.approx(without, abs=1e-3 * power)


def test_an_explanation_is_far_if_neither_its_score_nor_its_probability_is_near():
    table = table_of({(): 0.0, ("lag",): 2000.0, ("heat", "lag"): 2100.0, ("heat",): 1000.0}, set())
    assert table.caution > 10.0
    assert [parts for parts in table.refits if not table.is_far(parts)] == [("lag",), ("heat", "lag")]


def test_what_the_linear_problem_shows_to_be_far_behind_is_not_refitted():
    table = table_of({(): 0.0, ("heat", "lag"): 2000.0}, set())
    refit = table.refits["heat", "lag"]
    refit.linear.evidence_without = {"heat": 300.0, "lag": 200.0}.__getitem__
    with pytest.raises(StopIteration) as end:  # without a refit
        next(reduced(table, refit))
    scores = end.value.value.scores
    assert scores["lag",] == pytest.approx(300.0 + np.log(EFFECT_ODDS))
    assert scores["heat",] == pytest.approx(200.0 + np.log(EFFECT_ODDS))
