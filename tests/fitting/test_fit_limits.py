"""A fit reports coefficients that the data do not determine, and rejects invalid input with one line."""

from __future__ import annotations

import json
from math import inf

import pytest

from tirefmu.boundary.errors import FitError
from tirefmu.fitting import fit
from tirefmu.measurements import Noise, Recording, VirtualBench, alpha_sweeps
from tirefmu.symbolic.models import model_named

MODEL = model_named("mf96")


def test_cornering_does_not_determine_drive_and_brake(known, make):
    result = make.fit(make.bench(known, kappa=False))
    coefficients = make.coefficients(result)
    for name in ("RBY1", "RBY2", "RBY3", "RCY1", "RHY1"):
        assert not coefficients[name].determined, name
        assert not coefficients[name].at_bound
        assert result.tire.values[name] == MODEL.coefficients[name].default
    assert any("Fx is not fitted, kappa does not vary" in note for note in result.notes)
    assert [channel.channel for channel in result.channels] == ["Fy", "Mz"]
    # Without variation of kappa, Mz depends on Fy only and contains no information on Fx.
    for name in ("PCX1", "PDX1", "PKX1", "RBX1"):
        assert name not in coefficients or not coefficients[name].determined
        assert result.tire.values[name] == MODEL.coefficients[name].default
    named = next(note for note in result.notes if note.startswith("not determined"))
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


def test_a_table_without_load_is_the_table_at_the_nominal_load(known, make):
    recording = VirtualBench(known, Noise.none()).run(alpha_sweeps([700.0], sample_rate=20.0))
    held = recording.table[["t", "alpha", "Fy"]].assign(Fz=700.0)
    fits = [make.fit(Recording(table, recording.signs, "a")) for table in (held, held.drop(columns="Fz"))]
    with_load, without = ([vars(one) for one in result.findings.stiffnesses] for result in fits)
    assert with_load == without
    assert len(without) == 1
    assert fits[0].tire.values == fits[1].tire.values


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
