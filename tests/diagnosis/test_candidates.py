"""Candidate effects and their forms depend on the effect files only."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import tirefmu.symbolic.effects as effects
from tirefmu.diagnosis.diagnose import with_library
from tirefmu.diagnosis.probing import baseline_coefficients, candidates_for, refinements_for
from tirefmu.diagnosis.probing.effect_probing import probed
from tirefmu.diagnosis.signals import FORMULA_SIGNS, signals_of
from tirefmu.symbolic.added import folder, library, packaged_library, read_effect
from tirefmu.symbolic.detection import Form
from tirefmu.symbolic.models import MODELS, model_named
from tirefmu.tires import Tire

from .conftest import sweeps

NEW = """
name = "wet_grip"
physics = "water on the road"
[coefficients]
WET1 = {description = "friction lost at nominal speed", unit = "1", lower = -1.0, upper = 1.0}
[[acts]]
on = "friction_y"
factor = "1 - WET1*abs(V)/LONGVL"
"""
DECLARED = NEW + '[diagnosis]\nrequires = ["V"]\nchannels = ["Fy"]\n[[diagnosis.forms]]\nsizes = {WET1 = 0.05}\n'


def started(model="mf61", has=(), own=()):
    tire = Tire(model, {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}, effects=has, signs=FORMULA_SIGNS)
    return with_library(tire, own)


def forget_library():
    library.cache_clear()
    packaged_library.cache_clear()


@pytest.fixture
def library_folder(tmp_path, monkeypatch):
    """Return a copy of the library folder that replaces it."""
    copy = tmp_path / "effects"
    shutil.copytree(Path(effects.__file__).parent, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(folder, "FOLDER", copy)
    forget_library()
    yield copy
    forget_library()


def test_a_new_file_in_the_library_folder_is_a_candidate(library_folder):
    assert "wet_grip" not in candidates_for(started())
    (library_folder / "wet_grip.toml").write_text(DECLARED, encoding="utf-8")
    forget_library()
    offered = candidates_for(started())["wet_grip"]
    assert (offered.forms, offered.requires, offered.channels) == ((Form.each({"WET1": 0.05}),), ("V",), ("Fy",))
    assert started().symbolic_model.prior_spread["WET1"] == pytest.approx(0.25)


def test_a_user_defined_effect_is_treated_like_one_of_the_library():
    declared = candidates_for(started(own=(read_effect(DECLARED, "own.toml"),)))["wet_grip"]
    assert (declared.forms[0].probes, declared.requires, declared.channels) == (({"WET1": 0.05},), ("V",), ("Fy",))
    plain = candidates_for(started(own=(read_effect(NEW, "own.toml"),)))["wet_grip"]
    assert (plain.forms[0].probes, plain.requires, len(plain.channels)) == (({"WET1": 0.125},), (), 5)


def test_forms_contain_the_coefficients_of_the_model():
    fiala, brush = candidates_for(started("fiala")), candidates_for(started("brush"))
    assert fiala["relax_lat"].requires == ("t", "alpha")
    assert fiala["relax_lat"].forms[0].free == ("REL_LEN_LAT",)
    assert brush["load_friction"].forms[0].free == ("NMU",)
    assert brush["load_friction"].requires == ("Fz",)
    assert brush["load_stiffness"].forms[0].probes == ({"NSTIFF": 0.125},)  # of a neutral value of 1


def test_errors_of_a_form_depend_on_what_lines_of_the_effect_read():
    offered = candidates_for(started("mf61"))
    assert {"phit", "gamma", "V"} <= offered["turn_slip"].reads  # the spin of the wheel, also by its inclination
    assert offered["pressure_friction"].reads & {"gamma", "T", "phit"} == set()
    assert {"t"} <= offered["heat_friction"].reads
    assert offered["heat_friction"].reads & {"gamma", "p"} == set()  # a state reads forces, which read everything


def test_special_cases_of_present_effects_are_no_candidates():
    assert {"relax_lat", "relax_load"} <= candidates_for(started()).keys()
    lag = candidates_for(started(has=["relax_lat"]))
    assert "relax_lat" not in lag
    assert lag["relax_load"].forms == (Form.each({"SIGC": 0.5}, given="relax_lat"),)
    assert not {"relax_lat", "relax_load"} & candidates_for(started(has=["relax_load"])).keys()


def test_refinements_belong_to_the_baseline_and_to_present_effects():
    tire = started(has=["conicity"])
    assert {name for name, _ in refinements_for(tire, frozenset())} == {"core", "conicity"}
    assert {name for name, _ in refinements_for(tire, frozenset({"temp_friction"}))} == {
        "core", "conicity", "temp_friction"
    }  # fmt: skip
    assert refinements_for(started("brush"), frozenset()) == []


def test_a_probe_of_load_stiffness_preserves_the_nominal_stiffness(without_camber, tire):
    """Without load_stiffness the cornering stiffness is proportional to load. The probe changes the curvature only."""
    form = model_named("mf96").detections["load_stiffness"].forms[0]
    simulator = without_camber.problem.simulator
    free = tuple(name for name in without_camber.solution.free if name != "PKY2")
    assert free == without_camber.solution.free
    before = without_camber.solution.parameters
    for probe in form.probes:
        after = probed(without_camber.problem.simulator, without_camber.solution, form, probe)
        assert after[simulator.index["PKY2"]] == probe["PKY2"]
        assert after[simulator.index["PKY1"]] != before[simulator.index["PKY1"]]
        held = [simulator.at_nominal("stiffness_y", each) for each in (before, after)]
        np.testing.assert_allclose(held[1], held[0], rtol=1e-12)


@pytest.mark.parametrize("model", [name for name, model in MODELS.items() if model.default_effects])
def test_a_baseline_fit_has_no_coefficient_that_a_fit_does_not_free(model):
    tire = started(model, has=model_named(model).default_effects)
    table = sweeps(400).assign(**dict.fromkeys(("Fx", "Fy", "Mz", "Mx", "My"), 1.0))
    free = baseline_coefficients(tire, signals_of(table, tire, "adapted-sae", smooth=False))
    assert len(free) > 5
    assert not [name for name in free if not tire.symbolic_model.coefficients[name].fitted]
