"""Some cases of the benchmark, and checks of the benchmark itself; `make discovery` runs all cases."""

import re

import numpy as np
import pandas as pd
import pytest
import sympy as sp

from tirefmu.diagnosis import diagnose
from tirefmu.diagnosis.signals import signals_of
from tirefmu.diagnosis.unexplained.features import features
from tirefmu.diagnosis.verdict import composition, reasons_against
from tirefmu.symbolic.added.folder import declared_effects
from tirefmu.symbolic.added.formula import formula

from .independent import kinds as independent
from .independent.memory_kinds import FAST, SINGLES
from .kinds import CONFOUNDED, NUMBER_OF_CASES, case_of
from .suite import ARTEFACTS, BENT, SIZES, UNKNOWN, make_case


def answer(case):
    return diagnose(case.table, signs=case.signs, effects=case.effects, nominal=case.nominal)


def closed(case, diagnosis, *channels):
    """Return the share of the squared error on other manoeuvres, in some or all channels, that is removed."""
    inputs = case.test.drop(columns=list(diagnosis.gap["train"]))
    before, after = (
        sum(
            np.mean((tire.evaluate(inputs, signs=case.signs)[name] - case.test[name]) ** 2) / part["floor"] ** 2
            for name, part in diagnosis.gap["train"].items()
            if name in (channels or diagnosis.gap["train"])
        )
        for tire in (diagnosis.base_tire, diagnosis.tire)
    )
    return 1.0 - after / before


def test_the_benchmark_hides_every_candidate_effect():
    declared = {name for name, effect in declared_effects().items() if effect.detection}
    in_memory_suite = {*SINGLES, *(name for name, _ in FAST if name)}
    assert in_memory_suite & set(SIZES) == {"turn_slip"}  # there without a recorded phit
    assert declared == in_memory_suite | set(SIZES)
    assert NUMBER_OF_CASES["single"] >= 2 * len(SIZES)
    assert NUMBER_OF_CASES["null"] >= 30
    assert NUMBER_OF_CASES["double"] >= 5
    assert NUMBER_OF_CASES["bent"] >= 10
    assert NUMBER_OF_CASES["confounded"] == len(CONFOUNDED)


def test_a_case_number_always_gives_the_same_recording():
    first, again = case_of("null", 3), case_of("null", 3)
    pd.testing.assert_frame_equal(first.table, again.table)
    assert not first.table.equals(case_of("null", 4).table)


@pytest.mark.parametrize("artefacts", ARTEFACTS)
def test_every_artefact_changes_the_recording_only(artefacts):
    plain, troubled = (make_case(5, sweeps=2, artefacts=names) for names in ((), (artefacts,)))
    pd.testing.assert_frame_equal(plain.truth, troubled.truth)
    assert not plain.table.equals(troubled.table)


@pytest.mark.parametrize("bent", BENT)
def test_a_form_error_changes_the_forces_by_a_few_percent(bent):
    plain, other = (make_case(5, sweeps=4, bent=name).truth[["Fx", "Fy"]] for name in ("", bent))
    assert 0.003 < np.sqrt(((other - plain) ** 2).mean() / (plain**2).mean()).max() < 0.15


def test_the_text_of_a_feature_evaluates_to_its_values():
    case = make_case(5, sweeps=6)
    tire = case.tire.in_signs("adapted-sae")
    signals = signals_of(case.table, tire, "adapted-sae")
    named = signals.named()
    known = {**tire.values, **named}
    for feature in [one for many in features(signals, tire) for one in many if not one.states]:
        expression = formula(feature.text, "a feature")
        names = sorted(symbol.name for symbol in expression.free_symbols)
        compute = sp.lambdify(
            [sp.Symbol(name, real=True) for name in names], expression, [{"absolute": np.abs}, "numpy"]
        )
        np.testing.assert_allclose(compute(*(known[name] for name in names)), feature.values, rtol=1e-9, atol=1e-12)
        assert set(feature.depends_on) <= set(named)


def test_a_tire_that_differs_by_refinements_only_is_judged_on_the_hold_out_set():
    """300 rows: finer forms of the pressure fit their noise, with PPX2 at a bound."""
    diagnosis = answer(independent.case_of("null", 3))
    assert diagnosis.found == ()
    assert not diagnosis.delivered
    assert dict(diagnosis.tire.values) == dict(diagnosis.base_tire.values)
    assert "efinement needed" not in diagnosis.verdict
    assert "predicts the hold-out set worse" in diagnosis.verdict


@pytest.mark.slow
def test_an_unexplained_effect_is_added_to_the_model():
    case = case_of("unknown", list(UNKNOWN).index("crown"))
    diagnosis = answer(case)
    assert [one.effect for one in diagnosis.found] == ["UNKNOWN"]
    assert diagnosis.unknown[0].added
    assert set(diagnosis.unknown[0].depends_on) == UNKNOWN["crown"]
    assert closed(case, diagnosis) > 0.9


@pytest.mark.slow
def test_a_formula_that_prevents_delivery_is_left_out(monkeypatch):
    """The first tire, with the formula, is refused; the second one has none and is judged as any other."""
    judged = []

    def reasons(*given):
        judged.append(given)
        return ("its residual is larger",) if len(judged) == 1 else reasons_against(*given)

    monkeypatch.setattr(composition, "reasons_against", reasons)
    diagnosis = answer(case_of("unknown", list(UNKNOWN).index("crown")))
    assert len(judged) == 1  # without the formula nothing is added, and nothing is to be judged
    assert not diagnosis.unknown[0].added
    assert diagnosis.unknown[0].not_added_because == "with it, its residual is larger"
    assert diagnosis.delivered
    assert diagnosis.tire.has == diagnosis.base_tire.has


@pytest.mark.slow
def test_confounded_effects_are_reported_with_the_separating_measurement():
    _, hidden, others, confounded, words = CONFOUNDED[1]
    diagnosis = answer(case_of("confounded", 1))
    names = {hidden, *others.split()}
    assert diagnosis.found[0].effect in names
    reported = {diagnosis.found[0].effect, *diagnosis.confounded_with[diagnosis.found[0].effect]}
    assert {hidden, *confounded.split()} <= reported
    assert any(re.search(words, text) for text in diagnosis.next_measurement)


@pytest.mark.slow
def test_turn_slip_is_identified_if_it_was_recorded():
    case = case_of("single", list(SIZES).index("turn_slip"))
    diagnosis = answer(case)
    assert [one.effect for one in diagnosis.found] == ["turn_slip"]
    assert closed(case, diagnosis, "Fy") > 0.9
    assert closed(case, diagnosis, "Mz") > 0.0  # it errs by less than its noise also without turn slip
