"""``tirefmu info``: contents of a tire, sources of its values, and implausible values."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest

from tirefmu.commands.cli import main
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire, published
from tirefmu.tires.description import describe
from tirefmu.tires.implausible import implausible, loads
from tirefmu.tires.property_file.reading import read_tir_with_notes

FILES = ["MagicFormula52", "MagicFormula61", "MagicFormula62"]
#: The models with the coefficients that these tests change.
MAGIC = [name for name, model in MODELS.items() if "PDX1" in model.coefficients]
#: Effects with states: those of tests/fmu/conftest.py, so that their code is printed once for both.
STATEFUL = ("heat_friction", "slip_history", "hysteresis_force", "break_in", "load_lag", "carcass_2nd_order")


def generic(model="mf61", **values):
    """Return a tire of plausible generic values, except for those given."""
    declarations = MODELS[model].coefficients
    start = {name: declared.generic for name, declared in declarations.items() if declared.neutral is None}
    return Tire(model, {**start, **values}, signs="adapted-sae")


def doubts(tire):
    """Return the reasons by name."""
    found = {}
    for doubt in implausible(tire):
        found[doubt.name] = f"{found.get(doubt.name, '')} {doubt.reason}".strip()
    return found


def test_the_states_of_effects_are_no_inputs_with_a_nominal_value(tmp_path, capsys):
    tire = replace(generic(), effects=STATEFUL)
    assert len(tire.states) > 3
    assert describe(tire)["nominal"].keys() == set(tire.inputs) - set(tire.states)
    tire.save(tmp_path / "memory.tir")
    assert main(["info", str(tmp_path / "memory.tir")]) == 0
    assert tire.states[0] not in capsys.readouterr().out


@pytest.mark.parametrize("model", MODELS)
def test_a_generic_tire_has_no_doubts(model):
    """But that forces keep to no ellipse, if the model has coefficients of combined slip and the tire has none."""
    assert set(doubts(generic(model))) == ({"G_xa, G_yk"} if model.startswith("mf") else set())


@pytest.mark.parametrize("model", MAGIC)
@pytest.mark.parametrize(
    ("values", "name", "reason"),
    [
        ({"PDX1": -1.0}, "PDX1", "wrong sign?"),
        ({"PDX1": -1.0}, "mu_x", "is not positive"),
        ({"PDY1": 0.3, "PDY2": -0.9}, "mu_y", "changes sign within the range of loads"),
        ({"PDY2": 0.2}, "mu_y", "increases with load, from "),
        ({"PKX1": 10.0, "PKX2": 15.0}, "K_xkappa", "changes sign within the range of loads"),
        ({"PKY1": -20.0}, "K_yalpha", "is not positive"),
        ({"PKY1": -20.0}, "PKY1", "outside "),
        ({"PEY1": 3.0}, "E_y", "above 1 at Fz = "),
        ({"PEX1": 0.9, "PEX4": 0.9}, "E_x", "above 1 at Fz = "),
        ({"UNLOADED_RADIUS": 310.0}, "UNLOADED_RADIUS", "in mm?"),
        ({"FNOMIN": 0.5}, "FNOMIN", "in kN?"),
    ],
)
def test_each_doubt_has_its_reason(model, values, name, reason):
    assert reason in doubts(generic(model, **values))[name]


@pytest.mark.parametrize(
    ("values", "hint"),
    [
        ({"INFLPRES": 2.2}, "in bar?"),
        ({"NOMPRES": 220.0}, "in kPa?"),
        ({"ALPMIN": -12.0, "ALPMAX": 12.0}, "in degrees?"),
        ({"KPUMIN": -100.0, "KPUMAX": 100.0}, "in percent?"),
        ({"VERTICAL_STIFFNESS": 210.0}, "in N/mm?"),
        ({"LATERAL_STIFFNESS": 100.0}, "in N/mm?"),
        ({"VERTICAL_STIFFNESS": 1200.0}, "in "),
        ({"INFLPRES": 32.0}, "in psi?"),
        ({"WIDTH": 8.0}, "in inches?"),
        ({"RIM_RADIUS": 190.0}, "in mm?"),
        ({"PHY1": 0.5}, "in degrees?"),
        ({"PKY1": 0.35}, "in 1/deg?"),
        ({"LONGVL": 0.0112}, "in mm/s?"),
        ({"LONGVL": 60.0}, "in km/h?"),
        ({"RIM_RADIUS": 8.0}, "in inches?"),
        ({"PRESMAX": 3e7}, "the range of p exceeds"),
    ],
)
def test_a_unit_that_was_mistaken_is_guessed(values, hint):
    found = doubts(generic(**values))
    assert all(hint in found[name] for name in values)


@pytest.mark.parametrize(
    ("values", "name"),
    [
        ({"RHX1": 0.05, "RBX1": 20.0, "RCX1": 1.0}, "G_xa"),
        ({"RHY1": 0.05, "RBY1": 20.0, "RCY1": 1.0}, "G_yk"),
        ({"PDX1": 5.0, "PDX2": -0.5}, "mu_x"),
        ({"PVY1": 0.5}, "S_Vy"),
        ({"PHX1": 0.09}, "S_Hx"),
        ({"QDZ1": 0.9}, "D_t"),
        ({"QDZ6": 0.5}, "D_r"),
        ({"PVX1": 0.5}, "Fx"),
        ({"RVY1": 1.0, "RVY4": 5.0, "RVY5": 1.5, "RVY6": 10.0}, "Fy"),
        ({"RBX1": 0.5, "RCX1": 1.0, "RBY1": 0.5, "RCY1": 1.0}, "G_xa, G_yk"),
    ],
)
@pytest.mark.parametrize("model", MAGIC)
def test_quantities_that_no_tire_has_are_named_though_each_coefficient_is_within_its_bounds(model, values, name):
    assert_named_alone(model, values, name)


@pytest.mark.parametrize(
    ("values", "name"),
    [
        ({"QSX3": 5.0}, "Mx"),
        ({"QSY1": 0.02}, "My"),  # it drives the wheel
        ({"PDY3": 60.0, "CAMMIN": -0.2, "CAMMAX": 0.2}, "mu_y"),
        ({"PPY3": 4.0, "PPY4": -5.0, "PRESMIN": 1e5, "PRESMAX": 4e5}, "mu_y"),
    ],
)
def test_so_are_those_at_the_ends_of_camber_and_pressure(values, name):
    assert_named_alone("mf61", values, name)


def assert_named_alone(model, values, name):
    found = doubts(generic(model, **values))
    assert name in found
    assert not set(values) & set(found)


@pytest.mark.parametrize("name", FILES)
def test_published_tires_have_plausible_sizes(name, golden):
    tire = read_tir_with_notes(golden / f"{name}_Parameters.tir").tire
    assert {doubt.name for doubt in implausible(tire)} <= {"E_x", "E_xalpha"}


def test_a_pressure_range_in_bar_is_named():
    assert "in bar?" in doubts(generic(PRESMIN=1.5, PRESMAX=3.0))["PRESMAX"]


def test_ranges_are_judged_where_the_model_has_no_coefficient_for_them():
    tire = replace(published("trento_hoosier"), ranges={"alpha": (-12.0, 12.0), "Fz": (300.0, 900.0)})
    assert doubts(tire)["ALPMAX"] == "the range of alpha exceeds 1.6: in degrees?"
    assert doubts(tire)["FNOMIN"] == "outside the range of Fz, 300 .. 900 N"


@pytest.mark.parametrize("model", MAGIC)
def test_doubts_do_not_depend_on_the_signs_in_which_a_tire_is_written(model):
    tire = generic(model, PKY1=-20.0, PDX1=-1.0, PEY1=3.0)
    assert doubts(tire).keys() == doubts(tire.in_signs("iso")).keys()


def test_loads_are_those_for_which_the_tire_is_known():
    tire = generic("mf96", FNOMIN=1000.0)
    assert (loads(tire)[0], loads(tire)[-1]) == (200.0, 2000.0)
    assert (loads(replace(tire, ranges={"Fz": (0.0, 500.0)}))[[0, -1]] == [25.0, 500.0]).all()


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_the_field_is_reported_in_full(name, golden):
    reading = read_tir_with_notes(golden / f"{name}_Parameters.tir")
    reported = describe(reading.tire, reading.notes)
    assert json.loads(json.dumps(reported, allow_nan=False)) == reported
    assert reported["unknown"] == []
    assert {entry["key"] for entry in reported["unused"]} >= {"USE_MODE", "VERTICAL_DAMPING", "RIM_WIDTH"}
    assert set(reported["effects"]) | set(reported["effects_at_neutral"]) == reading.tire.has
    assert set(reported["effects_absent"]) == reading.tire.symbolic_model.effects.keys() - reading.tire.has
    assert reported["nominal"]["Fz"] == reading.tire.values["FNOMIN"]
    assert all(reported["values"][key] == value for key, value in reported["missing"].items())


def test_a_quantity_that_is_not_finite_is_reported_as_none():
    reported = describe(generic("mf96", PKX3=-2.0, PKX1=0.0, PDX1=0.0, PCX1=0.0))
    assert json.dumps(reported, allow_nan=False)
    assert not any(value is not None and math.isnan(value) for value in [d["value"] for d in reported["implausible"]])


FILE = """[UNITS]
LENGTH = 'mm'
[MODEL]
PROPERTY_FILE_FORMAT = 'PAC2002'
TYRESIDE = 'RIGHT'
[DIMENSION]
UNLOADED_RADIUS = 310
[VERTICAL]
FNOMIN = 4000
[OPERATING_CONDITIONS]
INFLPRES = 2.2
[LATERAL_COEFFICIENTS]
PDYI = 3
[INERTIA]
MASS = 9
[SHAPE]
{radial width}
1 0
[SHOP]
PRICE = 2
"""


def test_the_command_reports_missing_values(command, tmp_path):
    path = tmp_path / "field.tir"
    path.write_text(FILE, encoding="utf-8")
    short, full = command("info", path), command("info", path, "--all")
    assert short.status == full.status == 0
    for word in (
        "field: Magic Formula 5.2 (mf52), coefficients in iso, right side",
        "Fz: nominal 4000 N",
        "no FITTYP: mf52 by PROPERTY_FILE_FORMAT 'PAC2002'",
        "LENGTH is in mm: converted to SI",
        "unknown keys: PDYI (near PDY1), PRICE",
        "in bar?",
        "UNLOADED_RADIUS",
    ):
        assert word in short.out, word
        assert word in full.out, word
    assert "PKY2" not in short.out  # missing in the file: reported on request
    for word in ("PKY2", "missing", "known keys that this model does not read: ", "MASS = 9", "other tables: SHAPE"):
        assert word in full.out, word


def test_coefficients_that_the_model_ignores_are_named(command, golden, tmp_path):
    """PKY6 and PKY7 have no influence in MF5.2; a value of 0 is not worth a line."""
    text = (golden / "MagicFormula52_Parameters.tir").read_text(encoding="utf-8")
    section = "[LATERAL_COEFFICIENTS]"
    path = tmp_path / "given.tir"
    path.write_text(text.replace(section, f"{section}\nPKY6 = -0.9\nPKY7 = 0.0"), encoding="utf-8")
    reading = read_tir_with_notes(path)
    assert [coefficient["key"] for coefficient in describe(reading.tire)["ignored"]] == ["PKY6"]
    assert "given but ignored by mf52: PKY6 = -0.9\n" in command("info", path).out
