"""A fit recovers the true tire from data in any signs, and satisfies its bounds and constraints."""

from __future__ import annotations

import json
from math import inf

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError, FitError
from tirefmu.fitting import fit
from tirefmu.measurements import Noise, Recording, VirtualBench, alpha_sweeps, write_table
from tirefmu.symbolic.models import model_named
from tirefmu.tires import Tire


def differences(tire, truth, inputs):
    """Return the largest difference of each force, relative to the largest force."""
    found, true = (t.in_signs("iso").forces(**inputs) for t in (tire, truth))
    return {name: float(np.max(np.abs(found[name] - true[name])) / np.max(np.abs(true[name]))) for name in true}


# ------------------------------------------------------------------ recovery


@pytest.mark.parametrize("seed", [None, 1])
def test_known_coefficients_are_recovered_from_generic_values(known, make, seed):
    truth = known if seed is None else make.other_tire(seed)
    result = make.fit(make.bench(truth))
    assert result.status == "converged"
    assert [channel.channel for channel in result.channels] == ["Fx", "Fy", "Mz"]
    for channel in result.channels:
        assert channel.r2 > 0.99999
    # Also between the loads, cambers and slips of the program.
    for name, share in differences(result.tire, truth, make.anywhere()).items():
        assert share < 1e-3, name
    for name in ("PCY1", "PDY1", "PDY2", "PKY1", "PKY2", "PCX1", "PDX1", "PKX1", "PVY3", "QBZ1", "QDZ1"):
        assert make.coefficients(result)[name].value == pytest.approx(truth.values[name], rel=0.01), name
        assert make.coefficients(result)[name].determined


@pytest.mark.parametrize("data", ["iso", "adapted-sae", "sae"])
def test_the_signs_of_the_data_do_not_matter(side_fit, make, data):
    reference, recording = side_fit
    result = make.fit(recording.with_signs(data))
    assert result.tire.signs == "iso"
    for name, value in reference.tire.values.items():
        assert result.tire.values[name] == pytest.approx(value, rel=1e-9, abs=1e-12), name
    assert result.signs == "iso"
    for ours, theirs in zip(result.coefficients, reference.coefficients, strict=True):
        expected = (theirs.guess, theirs.lower, theirs.upper, theirs.value)
        assert (ours.guess, ours.lower, ours.upper, ours.value) == pytest.approx(expected, rel=1e-9, abs=1e-12), ours
        assert (ours.at_bound, ours.determined, ours.stage) == (theirs.at_bound, theirs.determined, theirs.stage)
    side = result.channel(recording.source, "Fy")
    assert side.rmse == pytest.approx(reference.channel(recording.source, "Fy").rmse, rel=1e-6, abs=1e-9)


def test_recordings_of_different_signs_are_combined(known, make):
    whole = make.sideways(known)
    half = np.arange(len(whole)) < len(whole) // 2
    parts = [Recording(whole.table[rows], whole.signs, name) for rows, name in ((half, "one"), (~half, "two"))]
    result = make.fit([parts[0].with_signs("iso"), parts[1].with_signs("sae")])
    assert result.signs == "iso"
    assert {channel.recording for channel in result.channels} == {"one", "two"}
    assert all(channel.r2 > 0.99999 for channel in result.channels)
    assert {"one", "two"} == set(result.tire.about["data"].split(", "))


def test_files_are_read_like_recordings(side_fit, make, tmp_path):
    reference, recording = side_fit
    path = tmp_path / "sideways.csv"
    write_table(recording.table, path)
    result = make.fit(path, signs=recording.signs)
    assert dict(result.tire.values) == dict(reference.tire.values)  # to the last digit
    assert result.channels[0].recording == "sideways.csv"


# ------------------------------------------------------------------ bounds and constraints


def test_bounds_are_satisfied_and_reported(known, make, tmp_path):
    path = make.recipe(
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
    result = make.fit(make.sideways(known), recipe=path)
    coefficients = make.coefficients(result)
    assert set(coefficients) == {"PCY1", "PDY1", "PKY1", "PKY2"}
    for coefficient in coefficients.values():
        assert coefficient.lower <= coefficient.value <= coefficient.upper
    assert {name for name, c in coefficients.items() if c.at_bound} == {"PDY1", "PKY2"}
    assert coefficients["PDY1"].value == pytest.approx(1.7, rel=1e-3)  # the tire has 1.9
    assert coefficients["PKY2"].value == pytest.approx(2.6, rel=1e-3)  # and 2.2
    assert coefficients["PKY2"].guess == 5.0  # a guess beyond its bounds is moved onto them


def test_without_constraints_the_curvature_exceeds_one(known, make):
    """The counterpart: without constraints similar data lead to values above 1."""
    values = {**known.values, "PEY1": 0.6, "PEY2": 1.2}
    odd = Tire("mf96", values, effects=make.effects, signs="adapted-sae")
    recording = make.sideways(odd)
    constrained = make.fit(recording)
    unconstrained = make.fit(recording, without_constraints=["all"])
    assert unconstrained.margins == ()
    at_top = {"Fz": 1120.0, "alpha": 0.2}

    def curvature(result):
        return float(result.tire.evaluate(pd.DataFrame([at_top]))["E_y"].iloc[0])

    assert curvature(unconstrained) > 1.2
    assert curvature(constrained) <= 1.0 + 1e-6
    assert min(margin.margin for margin in constrained.margins) >= -1e-6
    assert unconstrained.channels[0].rmse < constrained.channels[0].rmse


# ------------------ A fit reports coefficients that the data do not determine, and rejects invalid input with one line


MODEL = model_named("mf96")


def test_cornering_does_not_determine_drive_and_brake(known, make):
    result = make.fit(make.bench(known, kappa=False))
    coefficients = make.coefficients(result)
    for name in ("RBY1", "RBY2", "RBY3", "RCY1", "RHY1"):
        assert not coefficients[name].determined, name
        assert not coefficients[name].at_bound
    assert any("keeps to the friction ellipse" in note and "RBY1" in note for note in result.notes)
    assert any("Fx is not fitted, kappa does not vary" in note for note in result.notes)
    assert [channel.channel for channel in result.channels] == ["Fy", "Mz"]
    # Without variation of kappa, Mz depends on Fy only and contains no information on Fx.
    assert "RBX1" not in coefficients or not coefficients["RBX1"].determined
    for name in ("PCX1", "PDX1", "PKX1"):
        assert name not in coefficients or not coefficients[name].determined
        assert result.tire.values[name] == MODEL.coefficients[name].default
    named = next(note for note in result.notes if note.startswith("no influence on these data"))
    for coefficient in coefficients.values():
        assert (coefficient.name in named.partition(": ")[2].split(", ")) == (not coefficient.determined)


def test_one_load_without_inclination_does_not_determine_their_coefficients(known, make):
    recording = make.sideways(known, loads=(700.0,), cambers=(0.0,))
    result = make.fit(recording)
    coefficients = make.coefficients(result)
    for name in ("PDY2", "PEY2", "PHY2", "PVY2", "PHY3", "PVY3", "PVY4", "PDY3"):
        assert not coefficients[name].determined, name
        assert result.tire.values[name] == 0.0
    for name in ("PCY1", "PDY1", "PEY1", "PKY1", "PHY1", "PVY1"):
        assert coefficients[name].determined, name
    assert result.channels[0].r2 > 0.99999
    assert result.tire.ranges.keys() == {"alpha"}  # constant inputs have no range


def test_a_table_without_load_is_refused_also_with_a_nominal_load(known, make):
    table = VirtualBench(known, Noise.none()).run(alpha_sweeps([700.0], sample_rate=20.0)).table.drop(columns="Fz")
    with pytest.raises(DataError, match=r"a: no load Fz: name its column \(--columns Fz=NAME\)"):
        make.fit(Recording(table, "adapted-sae", "a"))


def test_a_later_stage_preserves_values_that_it_does_not_determine(known, make, tmp_path):
    path = make.recipe(
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
    result = make.fit(recording, recipe=path)
    coefficients = make.coefficients(result)
    assert result.tire.values["PDY2"] == pytest.approx(known.values["PDY2"], rel=1e-3)
    assert coefficients["PDY2"].determined
    assert coefficients["PDY2"].stage == "all loads"  # the last stage that determined it
    assert coefficients["PDY1"].stage == "one load"
    for name, coefficient in coefficients.items():  # the guess is the initial value of the fit
        if coefficient.determined:
            assert coefficient.guess == MODEL.coefficients[name].generic


# ------------------------------------------------------------------ bad input


def test_invalid_arguments_give_a_message_of_one_line(known, make):
    recording = make.sideways(known)
    cases = [
        ("nominal Fz0 = nan is not positive", {"nominal": {"Fz0": float("nan")}}),
        ("nominal Fz0 = inf N is far from the median of Fz, 650 N: in another unit?", {"nominal": {"Fz0": inf}}),
        ("nominal R0 = 230 m is outside 0.01 .. 3 m: in another unit?", {"nominal": {"R0": 230.0}}),
        ("nominal p0 = 80 Pa is far from the median of p", {"model": "mf61", "nominal": {"p0": 80.0}}),
    ]
    for message, options in cases:
        with pytest.raises(FitError) as caught:
            fit([recording], **{"model": "mf96", **options})
        assert message in str(caught.value)
        assert "\n" not in str(caught.value)


def test_nominal_values_of_a_table_without_their_channels_are_within_their_bounds(known, make):
    recording = make.sideways(known)
    bare = Recording(recording.table[["alpha", "Fy"]], recording.signs, "bare")
    for name, value in (("Fz0", 0.7), ("R0", 230.0), ("p0", 80.0)):
        with pytest.raises(FitError, match=rf"^nominal {name} = {value:g} \w+ is outside .*: in another unit\?$"):
            fit([bare], "mf61", nominal={"Fz0": 700.0, **{name: value}})


def test_a_recipe_that_finds_no_rows(known, make, tmp_path):
    path = make.recipe(tmp_path, '[[stage]]\nname = "far"\n[stage.where]\nFz = "9 +- 1 kN"\n')
    with pytest.raises(FitError, match=r"no stage of the recipe found rows.*'far' skipped: no row of the data"):
        fit([make.sideways(known)], "mf96", recipe=path, effects=())


def test_rows_without_load_have_no_effect(known, make):
    whole = make.sideways(known)
    lifted = whole.table.assign(
        Fz=whole.table["Fz"].where(whole.table.index % 50 != 0, 0.0),
        Fy=whole.table["Fy"].where(whole.table.index % 50 != 0, 0.0),
    )
    result = make.fit(Recording(lifted, whole.signs, "lifted"))
    assert result.ok
    assert result.channels[0].r2 > 0.9999
    json.dumps(result.to_json(), allow_nan=False)
