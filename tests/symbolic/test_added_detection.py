"""The table [diagnosis] of effect files: the declarations of the package, and the rejection of invalid ones."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tirefmu.boundary.errors import EffectError
from tirefmu.diagnosis.probing import EXPLANATIONS
from tirefmu.symbolic.added import effect_text, folder, library, read_effect
from tirefmu.symbolic.added.detection_file import FORM_KEYS, INPUTS, KEYS, OUTPUTS
from tirefmu.symbolic.added.file import read_declared
from tirefmu.symbolic.detection import Detection
from tirefmu.symbolic.effects import EFFECTS
from tirefmu.symbolic.models import MODELS

OWN = """
name = "wet_grip"
physics = "water on the road"
[coefficients]
WET1 = {description = "friction lost", unit = "1", lower = -1.0, upper = 1.0}
WET2 = {description = "at what speed", unit = "1", lower = 0.0, upper = 4.0, neutral = 1.0}
[[acts]]
on = "mu_y"
factor = "1 - WET1*tanh(WET2*V/LONGVL)"
[diagnosis]
requires = ["V"]
rate = 20.0
channels = ["Fy"]
contains = "speed_friction"
separate_by = "repeat it on a dry road"
spread = {WET2 = 0.5}
[[diagnosis.forms]]
free = ["WET1", "WET2"]
starts = [{WET1 = 0.1}, {WET1 = 0.1, WET2 = 1.0}]
[[diagnosis.forms]]
given = "speed_friction"
holds = "stiffness_y"
sizes = {WET1 = 0.1}
grid = {WET2 = [0.5, 2.0]}
[[diagnosis.refinements]]
sizes = {WET2 = -0.5}
[[diagnosis.confounded]]
with = "temp_friction"
separate_by = "measure at two temperatures"
"""
DECLARED = {name: effect.detection for name, effect in folder.declared_effects().items() if effect.detection}


def test_a_user_file_has_the_keys_of_a_library_file_and_survives_a_round_trip():
    effect = read_effect(OWN, "own.toml")
    assert effect.detection is not None
    assert read_effect(effect_text(effect), "again.toml") == effect
    assert effect.detection.prior_center == {"WET1": 0.1}
    assert effect.detection.prior_spread == {"WET2": 0.5}  # the second form is for tires that have another effect
    empty = read_effect(OWN[: OWN.index("requires")], "own.toml")
    assert empty.detection == Detection()
    assert read_effect(effect_text(empty), "again.toml") == empty


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("requires", "require", "unknown key 'require' in diagnosis: did you mean requires"),
        ('["V"]', '["v_x"]', "unknown word 'v_x' in diagnosis.requires"),
        ('["Fy"]', '["Fyy"]', "unknown word 'Fyy' in diagnosis.channels[1]: did you mean Fy"),
        ('contains = "speed_friction"', 'contains = "nul"', "contains 'nul' is a device of Windows"),
        (
            'contains = "speed_friction"',
            f'contains = "{"a" * 65}"',
            "expected a word of letters",
        ),
        ("{WET2 = 0.5}", "{WET3 = 0.5}", "WET3 is not a coefficient of this effect: did you mean WET"),
        ("sizes = {WET1 = 0.1}", "sizes = {WET1 = 0}", "WET1 is 0: expected a number other than 0"),
        ("{WET2 = [0.5, 2.0]}", "{WET1 = [1]}", "'WET1' is also in sizes"),
        (
            "{WET2 = [0.5, 2.0]}",
            "{wet = [1]}",
            "the name 'wet' in diagnosis.forms[2].grid is not a word of",
        ),
        ("sizes = {WET1 = 0.1}", "sizes = {WET1 = 1.1}", "neutral 0.0 and size 1.1 exceed its bounds"),
        ("sizes = {WET2 = -0.5}", "sizes = {WET2 = -1.5}", "neutral 1.0 and size -1.5 exceed its bounds"),
        ("sizes = {WET1 = 0.1}", "size = {WET1 = 0.1}", "unknown key 'size' in diagnosis.forms[2]: did you mean sizes"),
        ("sizes = {WET1 = 0.1}", 'free = ["WET1"]', "either sizes, or free and starts are required"),
        ('free = ["WET1", "WET2"]', 'free = ["WET1"]', "starts contains WET2, which is not in free"),
        ('free = ["WET1", "WET2"]', 'free = ["WET1", ["WET2"]]', "expected a word of capital"),
        (
            '"stiffness_y"',
            '"stiffness"',
            "'stiffness' in diagnosis.forms[2].holds: did you mean stiffness_",
        ),
        ('with = "temp_friction"', 'other = "temp_friction"', "unknown key 'other'"),
        ('with = "temp_friction"', "", "with is missing in diagnosis.confounded[1]"),
        ("[[diagnosis.refinements]]", "[[diagnosis.refinements]]\n[[diagnosis.refinements]]", "either sizes"),
    ],
)
def test_a_wrong_declaration_is_one_line_with_the_file(old, new, message):
    assert old in OWN
    with pytest.raises(EffectError, match=re.escape(message)) as caught:
        read_effect(OWN.replace(old, new), "own.toml")
    assert str(caught.value).startswith("own.toml: ")
    assert "diagnosis" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_counts_are_bounded():
    many = OWN + '[[diagnosis.confounded]]\nwith = "conicity"\nseparate_by = "turn the tire"\n' * 20
    with pytest.raises(EffectError, match="expected a list of at most 20 tables"):
        read_effect(many, "own.toml")


def test_the_document_explains_every_key():
    document = (Path(__file__).parents[2] / "docs" / "effects.md").read_text(encoding="utf-8")
    for key in (*KEYS, *FORM_KEYS, "with"):
        assert f"`{key}`" in document or f"`[[diagnosis.{key}]]`" in document, key
    for name in (*INPUTS, *OUTPUTS, *EXPLANATIONS):
        assert name in document, name


# ------------------------------------------------------------------ the files of the package


def test_every_declared_coefficient_belongs_to_the_effect_in_some_model():
    owned = {name: {declaration.name for declaration in effect.declarations} for name, effect in library().items()}
    for model in (MODELS[name] for name in ("mf96", "mf52", "mf61")):
        for name in DECLARED.keys() & model.effects.keys():
            related = {other for other, detection in DECLARED.items() if detection.contains == name} | {
                DECLARED[name].contains
            }
            owned.setdefault(name, set()).update(model.owned(name, *(related & model.effects.keys())))
    for name, detection in DECLARED.items():
        forms = (*detection.forms, *detection.refinements)
        assert detection.forms, name
        assert {key for form in forms for key in form.free} | detection.spread.keys() <= owned[name], name


def test_every_other_explanation_exists_and_each_pair_is_declared_once():
    pairs = [frozenset({name, pair.other}) for name, detection in DECLARED.items() for pair in detection.confounded]
    assert len(set(pairs)) == len(pairs)
    for name in {name for pair in pairs for name in pair} | {
        detection.contains for detection in DECLARED.values() if detection.contains
    }:
        assert name in DECLARED or name in EXPLANATIONS


def test_effects_agree_on_the_prior_of_a_coefficient():
    for prior in ("prior_center", "prior_spread"):
        declared = [item for detection in DECLARED.values() for item in getattr(detection, prior).items()]
        assert len(dict(declared)) == len(set(declared))


def test_chapters_and_library_share_the_folder():
    assert EFFECTS.keys() | library().keys() == folder.declared_effects().keys()
    assert not EFFECTS.keys() & library().keys()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('name = "snow"\nphysics = "cold"', "ice.toml: the file of the effect 'snow' must have the effect's name"),
        ('name = "ice"\nphysics = "cold"\noptional = 1', "optional is 1: expected true or false"),
        ('name = "ice"\nphysics = "cold"\nrescales = {PKY1 = "a"}', "rescales.PKY1 is 'a': expected a number"),
        ('name = "ice"\nphysics = "cold"\nsource = "a"', "unknown key 'source'"),
    ],
)
def test_a_wrong_file_of_the_package_is_named(text, message):
    with pytest.raises(EffectError, match=message):
        read_declared(text, "ice.toml")
