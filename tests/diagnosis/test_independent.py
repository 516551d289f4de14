"""Laws of the second suite of recordings: formulas, effects, programs, errors and cases. No test runs a diagnosis."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.symbolic.added.folder import declared_effects

from .independent import brush, brush_kinds, memory_kinds, tmeasy
from .independent.effects import EFFECTS, LAGS, MOMENTS
from .independent.formulas import forces
from .independent.kinds import (
    CONFOUNDED,
    IN_BOOK_FORM,
    NUMBER_OF_CASES,
    SINGLES,
    UNKNOWN,
    _relaxed,
    case_of,
    library_tire,
)
from .independent.programs import operating_range, program
from .independent.recording_errors import CROSS_TALK, ERRORS, SKEW, recorded
from .independent.tires import BOOK_SIZES, CLASSES, specimen

#: Effects that tell left from right.
ASYMMETRIC = {"plysteer", "conicity", "curvature_asym", "residual_torque_Mzr", "kappa_sideforce_SVyk"}
#: Effects in the form of the book that are in the equations of MF6.1 itself.
OF_THE_BOOK = tuple(set(BOOK_SIZES) - {"speed_friction"})
CASES = [(kind, number) for kind, count in NUMBER_OF_CASES.items() for number in range(count)]


def tire(kind="passenger", effects=()):
    return specimen(np.random.default_rng(7), kind, effects, {})


def bench(one, kind="turning", rows=2000, rate=50.0):
    return program(np.random.default_rng(8), one, rate, rows, kind)


def arrays(table):
    return {name: table[name].to_numpy() for name in table}


def conditions(one):
    return operating_range(np.random.default_rng(9), one, bench(one).inputs)


@pytest.fixture(scope="module")
def cases():
    return {case: case_of(*case) for case in CASES}


@pytest.mark.parametrize(("kind", "effects"), [("passenger", ()), ("formula_student", OF_THE_BOOK)])
def test_the_core_formula_is_that_of_the_library(kind, effects):
    one = tire(kind, effects)
    table = conditions(one)
    inputs = table.drop(columns=["phit", "sliding", "heat", "largest_slip"])
    computed = library_tire(one, effects).evaluate(inputs, signs="adapted-sae", code="numpy")
    for name, values in forces(one, arrays(table)).items():
        np.testing.assert_allclose(computed[name], values, rtol=1e-9, atol=1e-9 * np.abs(values).max())


def test_the_book_form_of_speed_friction_scales_friction():
    one = tire(effects=("speed_friction",))
    x = {**arrays(conditions(one)), "V": np.full(1500, 1.4 * one.speed)}
    factor = 1.0 + 0.4 * one.values["VMU1"]
    values = {name: value * (factor if name in ("PDX1", "PDY1") else 1.0) for name, value in one.values.items()}
    scaled = replace(one, values={**values, "VMU1": 0.0})
    for name, values in forces(scaled, x).items():
        np.testing.assert_allclose(forces(one, x)[name], values, rtol=1e-12)


@pytest.mark.parametrize("effect", [None, *sorted(set(EFFECTS) - ASYMMETRIC)])
def test_a_tire_without_asymmetric_effects_is_symmetric(effect):
    one = tire(effects=("load_stiffness", "camber_thrust", "camber_stiffness", "combined_Gxa", "combined_Gyk"))
    effects = [EFFECTS[effect](1.0)] if effect else []
    x = arrays(conditions(one))
    left, right = forces(one, x, effects), forces(one, {**x, "alpha": -x["alpha"], "gamma": -x["gamma"]}, effects)
    for name, sign in (("Fx", 1.0), ("Fy", -1.0), ("Mz", -1.0)):
        np.testing.assert_allclose(right[name], sign * left[name], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("effect", sorted(ASYMMETRIC))
def test_an_asymmetric_effect_breaks_the_symmetry(effect):
    one = tire()
    x = arrays(conditions(one))
    mirrored = {**x, "alpha": -x["alpha"], "gamma": -x["gamma"]}
    left, right = (forces(one, inputs, [EFFECTS[effect](1.0)]) for inputs in (x, mirrored))
    assert max(np.abs(right[name] - sign * left[name]).max() / np.abs(left[name]).max()
               for name, sign in (("Fx", 1.0), ("Fy", -1.0), ("Mz", -1.0))) > 0.003  # fmt: skip


@pytest.mark.parametrize("effect", sorted(EFFECTS))
def test_an_effect_of_size_0_vanishes_and_a_typical_one_changes_forces_by_some_percent(effect):
    one = tire()
    x = arrays(conditions(one))
    without, none, typical = (forces(one, x, effects) for effects in ((), *([EFFECTS[effect](s)] for s in (0.0, 1.0))))
    change = []
    for name, values in without.items():
        np.testing.assert_allclose(none[name], values, rtol=1e-12)
        change.append(np.sqrt(np.mean((typical[name] - values) ** 2) / np.mean(values**2)))
    assert 0.004 < max(change) < 0.6


def test_a_lag_follows_a_step_exponentially():
    t = np.arange(200) / 100.0
    found = _relaxed(t, np.where(t > 0.0, 1.0, 0.0), np.full(200, 8.0))
    ramp = t[1]  # the step is a ramp between the first two rows
    expected = 1.0 - np.exp(-8.0 * t) * (np.exp(8.0 * ramp) - 1.0) / (8.0 * ramp)
    np.testing.assert_allclose(found[1:], expected[1:], atol=1e-4)


@pytest.mark.parametrize("error", [error for error in ERRORS if error != "columns"])
def test_every_error_changes_the_recording_only(error):
    one = tire()
    run = bench(one)
    internal = pd.concat([run.inputs, pd.DataFrame(forces(one, arrays(run.inputs)))], axis=1)
    before = internal.copy()
    plain, troubled = (
        recorded(np.random.default_rng(3), internal, run.every, one, 1.0, errors) for errors in ((), (error,))
    )
    pd.testing.assert_frame_equal(internal, before)
    assert not plain.equals(troubled)
    assert list(plain) == list(troubled)


def test_cross_talk_and_skew_are_within_their_limits():
    one = tire()
    run = bench(one)
    internal = pd.concat([run.inputs, pd.DataFrame(forces(one, arrays(run.inputs)))], axis=1)
    for seed in range(5):
        table = recorded(np.random.default_rng(seed), internal, run.every, one, 0.0, ("cross_talk", "skew"))
        t, true = internal["t"], internal["Fy"]
        delays = np.linspace(0.0, 2.0 * SKEW, 51)
        late = [np.interp(t - delay, t, true)[run.rows] for delay in delays]
        best = int(np.argmin([np.std(table["Fy"] - one_late) for one_late in late]))
        assert 0.2 * SKEW < delays[best] < 1.2 * SKEW
        fx = np.interp(t - delays[best], t, internal["Fx"])[run.rows]
        share = np.polyfit(late[best], table["Fx"] - fx, 1)[0]
        assert 0.2 * CROSS_TALK < abs(share) < 1.1 * CROSS_TALK


def test_the_suite_hides_every_candidate_effect_in_another_form():
    declared = {name for name, effect in declared_effects().items() if effect.detection}
    in_memory_suite = {*memory_kinds.SINGLES, *(name for name, _ in memory_kinds.FAST if name)}
    assert in_memory_suite & set(SINGLES) == {"turn_slip"}  # there without a recorded phit
    assert declared == in_memory_suite | set(SINGLES)
    assert set(SINGLES) == (set(EFFECTS) | set(MOMENTS) | set(LAGS)) - set(UNKNOWN)
    assert set(IN_BOOK_FORM) <= set(BOOK_SIZES)
    assert NUMBER_OF_CASES["confounded"] == len(CONFOUNDED)
    assert NUMBER_OF_CASES["null"] >= 30
    assert sum(NUMBER_OF_CASES.values()) >= 60


def test_every_case_is_a_finite_recording_of_what_its_baseline_lacks(cases):
    signs, rates, rows, nominal = set(), set(), set(), set()
    for (kind, number), case in cases.items():
        for table in (case.table, case.truth, case.test, case.operating):
            assert np.isfinite(table.to_numpy(dtype=float)).all(), (kind, number)
        assert not set(case.hidden) & set(case.effects)
        assert bool(case.hidden or case.unknown) == (kind != "null")
        assert case.same_form <= set(case.hidden)
        signs.add(case.signs)
        rates.add(round(1.0 / case.table["t"].iloc[1]))
        rows.add(len(case.table))
        nominal.add(round(case.nominal["p0"]))
    assert signs == {"iso", "sae", "adapted-sae"}
    assert (min(rates), max(rates)) == (4, 200)
    assert (min(rows), max(rows)) == (200, 60000)
    assert len(nominal) == len(CLASSES)


def test_some_recordings_have_foreign_and_missing_columns(cases):
    tables = [case.table for (kind, _), case in cases.items() if kind == "null"]
    assert any("TreadTempC" in table for table in tables)
    assert any("RunNo" in table for table in tables)
    for name in ("T", "p", "V", "gamma", "Fx", "Mz"):
        assert any(name not in table for table in tables)


def test_a_case_number_always_gives_the_same_recording(cases):
    again = case_of("null", 8)
    pd.testing.assert_frame_equal(again.table, cases["null", 8].table)
    pd.testing.assert_frame_equal(again.operating, cases["null", 8].operating)
    assert not again.table.equals(cases["null", 6].table)


@pytest.mark.parametrize("number", [1, 4, 12])
def test_the_truth_of_a_null_is_its_baseline_model(cases, number):
    case = cases["null", number]
    true = case.tire
    assert set(true.has) == set(case.effects)
    for table in (case.truth, case.test, case.operating):
        channels = [name for name in ("Fx", "Fy", "Mz") if name in table]
        computed = true.evaluate(table.drop(columns=channels), signs=case.signs, code="numpy")
        for name in channels:
            np.testing.assert_allclose(computed[name], table[name], rtol=1e-9, atol=1e-9 * table[name].abs().max())


@pytest.mark.parametrize("kind", list(CLASSES))
def test_a_program_excites_loads_pressures_speeds_and_inclinations(kind):
    one = tire(kind)
    inputs = bench(one, "full", rows=4000).inputs
    for name, of in (("Fz", one.load), ("p", one.pressure), ("V", one.speed)):
        assert inputs[name].max() / of > 1.15
        assert inputs[name].min() / of < 0.85
    assert inputs["gamma"].min() < 0.0 < inputs["gamma"].max()
    assert inputs["alpha"].abs().max() > 0.15
    assert inputs["kappa"].abs().max() > 0.12


# ------------------------------------------------------------------ the tires of brushes and of points of curves


def brushes(core=brush, **inputs):
    given = {name: np.atleast_1d(np.asarray(value, dtype=float)) for name, value in inputs.items()}
    rows = {name: np.zeros(1) for name in ("kappa", "alpha", "gamma")} | {"Fz": np.array([4200.0])} | given
    length = max(len(row) for row in rows.values())
    return core.forces(tire(), {name: np.broadcast_to(row, length) for name, row in rows.items()})


def test_brushes_have_the_given_slopes_and_friction():
    one, small = tire(), 1e-5
    load, values = one.load, one.values
    assert brushes(Fz=load, kappa=small)["Fx"] / small == pytest.approx(values["PKX1"] * load, rel=1e-3)
    assert brushes(Fz=load, alpha=small)["Fy"] / small == pytest.approx(values["PKY1"] * load, rel=1e-3)
    whole = brushes(Fz=load, alpha=np.linspace(0.0, 0.6, 200))
    assert whole["Fy"].max() < values["PDY1"] * load
    assert 0.85 * values["PDY1"] * load < whole["Fy"][-1] < whole["Fy"].max()  # friction falls in sliding
    assert whole["Mz"][-1] == 0.0  # no brush adheres
    assert brushes(Fz=load, alpha=small)["Mz"] == pytest.approx(
        -values["QDZ1"] * one.radius * values["PKY1"] * load * small, rel=1e-3
    )


def test_a_curve_goes_through_its_points():
    one, small = tire(), 1e-5
    load, values, slips = one.load, one.values, np.linspace(0.0, 1.2, 4801)
    for name, slip, stiffness, peak, shape in (
        ("Fx", "kappa", "PKX1", "PDX1", tmeasy.ALONG), ("Fy", "alpha", "PKY1", "PDY1", tmeasy.ACROSS),
    ):  # fmt: skip
        assert brushes(tmeasy, Fz=load, **{slip: small})[name] / small == pytest.approx(
            values[stiffness] * load, rel=1e-3
        )
        whole = brushes(tmeasy, Fz=load, **{slip: slips})[name]
        assert whole.max() == pytest.approx(values[peak] * load, rel=1e-4)
        assert whole[-1] == pytest.approx(shape[2] * values[peak] * load)
        assert (np.diff(whole[: whole.argmax()]) > 0.0).all()
        assert (np.diff(whole[whole.argmax() :]) <= 1e-9).all()
        assert np.abs(np.diff(whole)).max() < 1.1 * values[stiffness] * load * slips[1]  # no jump
    moment = brushes(tmeasy, Fz=load, alpha=slips)["Mz"]
    assert moment.min() < 0.0 < moment.max()
    assert moment[-1] == pytest.approx(0.0, abs=1e-9)
    assert brushes(tmeasy, Fz=load, alpha=small)["Mz"] == pytest.approx(
        -values["QDZ1"] * one.radius * values["PKY1"] * load * small, rel=1e-3
    )


@pytest.mark.parametrize("core", [brush, tmeasy])
def test_a_symmetric_tire_is_alike_on_both_sides(core):
    angles = np.linspace(-0.2, 0.2, 41)
    for slip in np.linspace(-0.15, 0.15, 7):
        both = brushes(core, alpha=angles, kappa=slip)
        for name, sign in (("Fx", 1.0), ("Fy", -1.0), ("Mz", -1.0)):
            np.testing.assert_allclose(both[name], sign * both[name][::-1], atol=1e-9)


def test_brushes_slide_in_the_direction_of_their_stress():
    one, both = tire(), brushes(alpha=np.linspace(-0.2, 0.2, 41), kappa=0.15)
    used = np.hypot(both["Fx"] / one.values["PDX1"], both["Fy"] / one.values["PDY1"]) / 4200.0
    assert (used < (4200.0 / one.load) ** brush.OF_LOAD["friction"] + 1e-9).all()


@pytest.mark.parametrize("core", [brush, tmeasy])
def test_such_a_tire_takes_effects_where_a_formula_does(core):
    table = conditions(tire())
    x, effect = arrays(table), EFFECTS["camber_thrust"](1.0)
    without, with_effect = core.forces(tire(), x), core.forces(tire(), x, [effect])
    np.testing.assert_allclose(with_effect["Fy"] - without["Fy"], effect(tire(), x)["camber_thrust"], atol=1e-9)
    hot = EFFECTS["temp_friction"](1.0)
    small = {**x, "alpha": 1e-4 * x["alpha"], "kappa": 1e-4 * x["kappa"]}
    for name in ("Fx", "Fy"):
        np.testing.assert_allclose(core.forces(tire(), small, [hot])[name], core.forces(tire(), small)[name], rtol=1e-2)


@pytest.mark.parametrize("core", [brush, tmeasy])
@pytest.mark.parametrize("number", range(4))
def test_a_case_of_such_a_tire_hides_one_effect_or_none(core, number):
    for kind in brush_kinds.NUMBER_OF_CASES:
        case = brush_kinds.case_of(kind, number, core.forces)
        again = brush_kinds.case_of(kind, number, core.forces)
        pd.testing.assert_frame_equal(case.table, again.table)
        assert len(case.hidden) == (kind == "single")
        assert not set(case.hidden) & set(case.effects)
        assert np.isfinite(case.table.to_numpy()).all()
        assert np.isfinite(case.operating.to_numpy()).all()
