"""A fit finds the tire that made the data, whatever its signs, keeps what it promises, and says what it cannot know."""

from __future__ import annotations

import json
from functools import partial
from math import inf, radians

import numpy as np
import pandas as pd
import pytest

from tirefmu.fitting import fit, session
from tirefmu.measurements import Noise, Recording, write_table
from tirefmu.symbolic import model
from tirefmu.symbolic.errors import DataError, FitError, TirefmuError, UnknownName
from tirefmu.tires import Tire, read_tir
from tirefmu.tires.code import code_for

BOOK = model("mf96")


def told(result):
    return {coefficient.name: coefficient for coefficient in result.coefficients}


def differences(tire, truth, inputs):
    """Return the largest difference of each force, as a share of the largest force."""
    found, true = (t.in_signs("iso").forces(**inputs) for t in (tire, truth))
    return {name: float(np.max(np.abs(found[name] - true[name])) / np.max(np.abs(true[name]))) for name in true}


def recipe(folder, text):
    path = folder / "own.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


# ------------------------------------------------------------------ what made the data is found


@pytest.mark.parametrize("seed", [None, 0, 1, 2])
def test_known_coefficients_are_recovered_from_generic_values(known, make, seed):
    truth = known if seed is None else make.other_tire(seed)
    result = fit([make.bench(truth)], effects=make.effects, nominal=make.nominal)
    assert result.status == "converged"
    assert [channel.channel for channel in result.channels] == ["Fx", "Fy", "Mz"]
    for channel in result.channels:
        assert channel.r2 > 0.99999
    # Also between the loads, cambers and slips of the program.
    for name, share in differences(result.tire, truth, make.anywhere()).items():
        assert share < 1e-3, name
    for name in ("PCY1", "PDY1", "PDY2", "PKY1", "PKY2", "PCX1", "PDX1", "PKX1", "PVY3", "QBZ1", "QDZ1"):
        assert told(result)[name].value == pytest.approx(truth.values[name], rel=0.01), name
        assert told(result)[name].determined


def test_noise_does_not_lead_it_astray(known, make):
    recording = make.bench(known, noise=Noise())
    result = fit([recording], effects=make.effects, nominal=make.nominal)
    assert result.ok
    program = make.bench(known).table[list(known.inputs)]
    for name, share in differences(result.tire, known, dict(program)).items():
        assert share < 0.06, name
    assert min(channel.r2 for channel in result.channels) < 0.9999  # it is noisy


@pytest.mark.parametrize("data", ["iso", "adapted-sae", "sae"])
def test_the_signs_of_the_data_do_not_matter(side_fit, make, data):
    reference, recording = side_fit
    result = fit([recording.with_signs(data)], effects=make.effects, nominal=make.nominal)
    assert result.tire.signs == "iso"
    for name, value in reference.tire.values.items():
        assert result.tire.values[name] == pytest.approx(value, rel=1e-9, abs=1e-12), name
    assert result.signs == ("iso" if data == "iso" else "adapted-sae")
    # Coefficients and bounds are told in the convention of the data: those that flip are mirrored.
    for name, ours in told(result).items():
        card, theirs = BOOK.coefficients[name], told(reference)[name]
        assert reference.signs == "adapted-sae"
        expected = (theirs.guess, theirs.lower, theirs.upper, theirs.value)
        if data == "iso" and card.flips:
            expected = (-theirs.guess, -theirs.upper, -theirs.lower, -theirs.value)
        assert (ours.guess, ours.lower, ours.upper, ours.value) == pytest.approx(expected, rel=1e-9, abs=1e-12), name
        assert (ours.at_bound, ours.determined, ours.stage) == (theirs.at_bound, theirs.determined, theirs.stage)
    side = result.channel(recording.source, "Fy")
    assert side.rmse == pytest.approx(reference.channel(recording.source, "Fy").rmse, rel=1e-6, abs=1e-9)


def test_recordings_of_different_signs_go_together(known, make):
    whole = make.sideways(known)
    half = np.arange(len(whole)) < len(whole) // 2
    parts = [Recording(whole.table[rows], whole.signs, name) for rows, name in ((half, "one"), (~half, "two"))]
    result = fit([parts[0].with_signs("iso"), parts[1].with_signs("sae")], effects=make.effects, nominal=make.nominal)
    assert result.signs == "adapted-sae"
    assert {channel.recording for channel in result.channels} == {"one", "two"}
    assert all(channel.r2 > 0.99999 for channel in result.channels)
    assert {"one", "two"} == set(result.tire.about["data"].split(", "))


def test_files_are_read_like_recordings(side_fit, make, tmp_path):
    reference, recording = side_fit
    path = tmp_path / "sideways.csv"
    write_table(recording.table, path)
    result = fit([path], effects=make.effects, nominal=make.nominal, signs=recording.signs)
    assert dict(result.tire.values) == dict(reference.tire.values)  # to the last digit
    assert result.channels[0].recording == "sideways.csv"


def test_a_fit_is_repeatable(side_fit, make):
    reference, recording = side_fit
    again = fit([recording], effects=make.effects, nominal=make.nominal)
    assert dict(again.tire.values) == dict(reference.tire.values)


# ------------------------------------------------------------------ bounds and constraints


def test_bounds_are_kept_and_named(known, make, tmp_path):
    path = recipe(
        tmp_path,
        """
        [[stage]]
        name = "tight"
        channels = ["Fy"]
        [stage.free]
        PCY1 = { guess = 1.3, lower = 1, upper = 2 }
        PDY1 = { guess = 1.5, lower = 0.5, upper = 1.7 }
        PKY1 = { guess = 30, lower = 10, upper = 100 }
        PKY2 = { guess = 9, lower = 2.6, upper = 5 }
        """,
    )
    result = fit([make.sideways(known)], effects=make.effects, nominal=make.nominal, recipe=path)
    coefficients = told(result)
    assert set(coefficients) == {"PCY1", "PDY1", "PKY1", "PKY2"}
    for coefficient in coefficients.values():
        assert coefficient.lower <= coefficient.value <= coefficient.upper
    assert {name for name, c in coefficients.items() if c.at_bound} == {"PDY1", "PKY2"}
    assert coefficients["PDY1"].value == pytest.approx(1.7, rel=1e-3)  # the tire has 1.9
    assert coefficients["PKY2"].value == pytest.approx(2.6, rel=1e-3)  # and 2.2
    assert coefficients["PKY2"].guess == 5.0  # a guess beyond its bounds is moved onto them


def test_a_curvature_above_one_is_refused_over_the_whole_range(known, make):
    """E_x of the tire arches above 1 between the loads at which the condition is first imposed."""
    values = {**known.values, "FNOMIN": 500.0, "PEX1": 0.3, "PEX2": 4.0, "PEX3": -4.0}
    effects = ("load_friction", "load_stiffness", "load_curvature")
    odd = Tire("mf96", values, effects=effects, signs="adapted-sae")
    whole = make.bench(odd, loads=(220.0, 500.0, 650.0, 750.0, 850.0, 1120.0), cambers=(0.0,))
    recording = Recording(whole.table.drop(columns=["Fy", "Mz"]), whole.signs, "drive and brake")
    result = fit([recording], effects=effects, nominal={"Fz0": 500.0, "R0": 0.23})
    assert result.status == "converged"
    for margin in result.margins:
        assert margin.margin >= -1e-6, margin
    (curvature,) = (margin for margin in result.margins if margin.constraint == "E_x <= 1")
    assert curvature.margin == pytest.approx(0.0, abs=1e-3)
    assert curvature.worst == pytest.approx(1.0, abs=1e-3)
    assert 500.0 < curvature.at["Fz"] < 1000.0
    coefficients = told(result)
    assert not any(coefficients[name].at_bound for name in ("PEX1", "PEX2", "PEX3"))  # it is the condition that holds
    # The data want more: with the condition lifted, E_x of their best fit arches to 1.3.
    loads = np.linspace(220.0, 1120.0, 400)
    rows = np.stack([np.full(400, 0.1), np.zeros(400), np.zeros(400), loads])
    code = code_for("mf96", "numpy")
    place = code.quantities_names.index("E_x")
    kept, true = (code.quantities(rows, tire.in_signs("iso").parameters())[place] for tire in (result.tire, odd))
    assert true.max() == pytest.approx(1.3, abs=0.01)
    assert kept.max() < 1.02  # between the verified loads, too


def test_the_curvature_is_not_held_where_no_condition_is(known, make, monkeypatch):
    """The counterpart: without conditions the same kind of data lead beyond 1."""
    values = {**known.values, "PEY1": 0.6, "PEY2": 1.2}
    odd = Tire("mf96", values, effects=make.effects, signs="adapted-sae")
    recording = make.sideways(odd)
    kept = fit([recording], effects=make.effects, nominal=make.nominal)
    monkeypatch.setattr(session, "VALIDITY", {})
    broken = fit([recording], effects=make.effects, nominal=make.nominal)
    at_top = {"Fz": 1120.0, "alpha": 0.2}

    def curvature(result):
        return float(result.tire.evaluate(pd.DataFrame([at_top]))["E_y"].iloc[0])

    assert curvature(broken) > 1.2
    assert curvature(kept) <= 1.0 + 1e-6
    assert min(margin.margin for margin in kept.margins) >= -1e-6
    assert broken.channels[0].rmse < kept.channels[0].rmse


# ------------------------------------------------------------------ effects


def test_the_coefficients_of_absent_effects_stay_neutral(known, make):
    result = fit([make.sideways(known)], without=["camber_thrust", "plysteer"], nominal=make.nominal)
    assert result.tire.has == frozenset(BOOK.effects) - {"camber_thrust", "plysteer"}
    absent = BOOK.owned("camber_thrust", "plysteer")
    assert {"PHY3", "PVY3", "PVY4", "PHY1", "PHY2"} <= absent
    for name in absent:
        assert result.tire.values[name] == BOOK.coefficients[name].neutral
    assert not absent & set(told(result))


def test_the_core_alone_and_other_tools_read_the_same_tire(known, make, tmp_path):
    """Without load_stiffness the file has another PKY1 and PKY2, for readers that know no effects."""
    core = Tire("mf96", known.values, effects=(), signs="adapted-sae")
    result = fit([make.sideways(core)], effects=(), nominal=make.nominal)
    assert result.status == "converged"
    assert result.tire.has == frozenset()
    assert result.channels[0].r2 > 0.99999
    assert -result.tire.values["PKY1"] == pytest.approx(core.values["PKY1"], rel=1e-4)
    assert told(result)["PKY1"].value == pytest.approx(core.values["PKY1"], rel=1e-4)
    path = tmp_path / "core.tir"
    result.tire.save(path)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert "PKY2 = 1000000.0" in [line.partition("  $")[0] for line in lines]
    bare = tmp_path / "bare.tir"
    bare.write_text("\n".join(lines[: lines.index("[TIREFMU]")]), encoding="utf-8")
    inputs = make.anywhere(200)
    forces = result.tire.forces(**inputs)
    for read in (read_tir(path), read_tir(bare)):
        for name, values in read.forces(**inputs).items():
            np.testing.assert_allclose(values, forces[name], rtol=1e-9, atol=1e-9)
    assert read_tir(path).has == frozenset()


@pytest.mark.parametrize("stiffness", [(), ("load_stiffness",)], ids=["proportional", "saturating"])
def test_constraints_and_influence_know_what_an_absent_effect_rescales(make, known, stiffness):
    effects = ("camber_thrust", "load_friction", *stiffness)
    truth = Tire("mf96", known.values, effects=effects, signs="adapted-sae")
    result = fit([make.sideways(truth)], effects=effects, nominal=make.nominal)
    assert result.ok
    assert result.channels[0].r2 > 0.99999
    (stiff,) = (margin for margin in result.margins if margin.constraint == "B_y > 0")
    assert 1.0 < stiff.worst < 100.0
    assert told(result)["PKY1"].determined


# ------------------------------------------------------------------ what the data cannot tell


def test_cornering_alone_leaves_drive_and_brake_undetermined(known, make):
    result = fit([make.bench(known, kappa=False)], effects=make.effects, nominal=make.nominal)
    coefficients = told(result)
    for name in ("RBY1", "RBY2", "RBY3", "RCY1", "RHY1"):
        assert not coefficients[name].determined, name
        assert not coefficients[name].at_bound
        assert result.tire.values[name] == BOOK.coefficients[name].default
    assert any("Fx is not fitted, kappa does not vary" in note for note in result.notes)
    assert [channel.channel for channel in result.channels] == ["Fy", "Mz"]
    # Mz lies on Fy alone where kappa does not vary, so that nothing tells of Fx.
    for name in ("PCX1", "PDX1", "PKX1", "RBX1"):
        assert name not in coefficients or not coefficients[name].determined
        assert result.tire.values[name] == BOOK.coefficients[name].default
    named = next(note for note in result.notes if note.startswith("not determined"))
    for coefficient in coefficients.values():
        assert (coefficient.name in named.partition(": ")[2].split(", ")) == (not coefficient.determined)


def test_one_load_and_no_camber_leave_their_coefficients_undetermined(known, make):
    recording = make.sideways(known, loads=(700.0,), cambers=(0.0,))
    result = fit([recording], effects=make.effects, nominal=make.nominal)
    coefficients = told(result)
    for name in ("PDY2", "PEY2", "PHY2", "PVY2", "PHY3", "PVY3", "PVY4", "PDY3"):
        assert not coefficients[name].determined, name
        assert result.tire.values[name] == 0.0
    for name in ("PCY1", "PDY1", "PEY1", "PKY1", "PHY1", "PVY1"):
        assert coefficients[name].determined, name
    assert result.channels[0].r2 > 0.99999
    assert result.tire.ranges.keys() == {"alpha"}  # what did not vary has no range


def test_a_later_stage_does_not_forget_what_an_earlier_one_measured(known, make, tmp_path):
    path = recipe(
        tmp_path,
        """
        [[stage]]
        name = "all loads"
        [[stage]]
        name = "one load"
        [stage.where]
        Fz = "700 +- 1 N"
        """,
    )
    recording = make.sideways(known, loads=(220.0, 700.0, 1120.0))
    result = fit([recording], effects=make.effects, nominal=make.nominal, recipe=path)
    coefficients = told(result)
    assert result.tire.values["PDY2"] == pytest.approx(known.values["PDY2"], rel=1e-3)
    assert coefficients["PDY2"].determined
    assert coefficients["PDY2"].stage == "all loads"  # the last that saw it
    assert coefficients["PDY1"].stage == "one load"
    for name, coefficient in coefficients.items():  # told is what the fit started from
        if coefficient.determined:
            assert coefficient.guess == BOOK.coefficients[name].generic


# ------------------------------------------------------------------ start, nominal, progress


def test_a_start_tire_gives_values_and_effects(known, make):
    recording = make.sideways(known)
    result = fit([recording], start=known.in_signs("iso"))
    assert result.tire.has == known.has
    assert result.tire.name == "known"
    assert result.tire.values["FNOMIN"] == 700.0
    assert result.channels[0].rmse < 1e-3
    assert told(result)["PDY1"].guess == known.values["PDY1"]
    # What these data cannot see is still the start's.
    assert not told(result)["RBY1"].determined
    for name in ("PCX1", "PKX1", "QBZ1", "RBY1"):
        assert result.tire.values[name] == known.values[name]
    less = fit([recording], start=known, without=["camber_thrust"])
    assert less.tire.has == known.has - {"camber_thrust"}
    assert less.channels[0].rmse > 10.0


def test_nominal_values(known, make):
    recording = make.sideways(known)
    result = fit([recording], effects=make.effects, nominal={"Fz0": 900.0, "R0": 0.25, "p0": 1e5})
    assert result.tire.values["FNOMIN"] == 900.0
    assert result.tire.values["UNLOADED_RADIUS"] == 0.25
    assert any("nominal p0 has no place in mf96" in note for note in result.notes)
    assert result.channels[0].r2 > 0.9999  # the same curve, told about another load
    generic = fit([recording], effects=())
    assert generic.tire.values["FNOMIN"] == float(f"{np.median(recording.table['Fz']):.2g}")
    assert sum("not given" in note for note in generic.notes) == 2


def test_progress_is_told_stage_by_stage(known, make):
    calls = []
    result = fit([make.sideways(known)], effects=(), nominal=make.nominal, progress=lambda *call: calls.append(call))
    stages = [stage.name for stage in result.stages]
    assert list(dict.fromkeys(stage for stage, _, _ in calls)) == stages
    for stage in stages:
        assert next(count for name, count, _ in calls if name == stage) == 1
    assert all(np.isfinite(cost) for _, _, cost in calls)


def test_a_fit_that_does_not_converge_is_a_result(known, make, monkeypatch):
    monkeypatch.setattr(session, "solve", partial(session.solve, max_iterations=1))
    result = fit([make.sideways(known)], effects=make.effects, nominal=make.nominal)
    assert not result.ok
    assert result.status.startswith("not converged: stage 'core")
    assert result.status.endswith("Maximum_Iterations_Exceeded")
    assert not any(stage.converged for stage in result.stages)
    plain = json.loads(json.dumps(result.to_json(), allow_nan=False))
    assert plain["ok"] is False
    assert np.isfinite(list(result.tire.values.values())).all()


def test_the_operating_range_is_kept_with_the_tire(side_fit):
    result, recording = side_fit
    ranges = result.tire.ranges
    assert ranges["Fz"] == (220.0, 1120.0)
    assert ranges["gamma"] == pytest.approx((0.0, radians(4.0)))
    assert ranges["alpha"] == (recording.table["alpha"].min(), recording.table["alpha"].max())
    assert "kappa" not in ranges


# ------------------------------------------------------------------ bad input


def test_bad_requests_are_told_in_one_line(known, make):
    recording = make.sideways(known)
    cases = [
        (UnknownName, "unknown model 'mf69': did you mean mf96", {"model": "mf69"}),
        (UnknownName, "'camber_trust': did you mean camber_thrust", {"effects": ["camber_trust"]}),
        (UnknownName, "'camber_trust': did you mean camber_thrust", {"without": ["camber_trust"]}),
        (UnknownName, "unknown recipe 'jiont': did you mean joint", {"recipe": "jiont"}),
        (UnknownName, "unknown nominal value 'Fz': did you mean Fz0", {"nominal": {"Fz": 700.0}}),
        (FitError, "nominal Fz0 = -1 is not positive", {"nominal": {"Fz0": -1.0}}),
        (FitError, "nominal Fz0 = nan is not positive", {"nominal": {"Fz0": float("nan")}}),
        (TirefmuError, "FNOMIN is inf", {"nominal": {"Fz0": inf}}),
    ]
    for kind, message, options in cases:
        with pytest.raises(kind) as caught:
            fit([recording], **options)
        assert message in str(caught.value)
        assert "\n" not in str(caught.value)


def test_tables_that_cannot_be_fitted(known, make):
    whole = make.sideways(known)
    table = whole.table
    cases = [
        (DataError, r"row 6: alpha is nan", table.assign(alpha=table["alpha"].where(table.index != 5))),
        (DataError, r"row 6: Fz is inf", table.assign(Fz=table["Fz"].where(table.index != 5, inf))),
        (DataError, r"row 6: Fy is inf", table.assign(Fy=table["Fy"].where(table.index != 5, inf))),
        (DataError, "in degrees", table.assign(alpha=np.degrees(table["alpha"]))),
        (DataError, "Fz is negative in 100 %", table.assign(Fz=-table["Fz"])),
        (DataError, "no rows", table[:0]),
        (DataError, "no measured output", table.drop(columns="Fy")),
        (FitError, "nothing to fit", table.assign(alpha=0.0)),
        (FitError, "say --nominal Fz0", table.drop(columns="Fz")),
    ]
    for kind, message, odd in cases:
        with pytest.raises(kind, match=message) as caught:
            fit([Recording(odd, whole.signs, "odd")])
        assert "\n" not in str(caught.value)
    with pytest.raises(FitError, match="no table"):
        fit([])


def test_a_recipe_that_finds_no_rows(known, make, tmp_path):
    path = recipe(tmp_path, '[[stage]]\nname = "far"\n[stage.where]\nFz = "9 +- 1 kN"\n')
    with pytest.raises(FitError, match="no stage of the recipe found rows.*'far' skipped: no row of the data"):
        fit([make.sideways(known)], recipe=path, effects=())


def test_rows_at_lift_off_do_not_disturb(known, make):
    whole = make.sideways(known)
    lifted = whole.table.assign(
        Fz=whole.table["Fz"].where(whole.table.index % 50 != 0, 0.0),
        Fy=whole.table["Fy"].where(whole.table.index % 50 != 0, 0.0),
    )
    result = fit([Recording(lifted, whole.signs, "lifted")], effects=make.effects, nominal=make.nominal)
    assert result.ok
    assert result.channels[0].r2 > 0.9999
    json.dumps(result.to_json(), allow_nan=False)
