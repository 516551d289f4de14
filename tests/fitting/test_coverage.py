"""What the data never show: each kind is stated by the verdict, by fit.json and in the tire file."""

from __future__ import annotations

from math import radians
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest

from tirefmu import compare
from tirefmu.applications.comparison.figures import comparison_figures
from tirefmu.applications.explorer.tire_data import tire_data
from tirefmu.commands.terminal import Terminal
from tirefmu.drawing.style import DOTTED
from tirefmu.fitting import fit
from tirefmu.fitting.reporting import figures_of
from tirefmu.fmu.packaging.export import contents
from tirefmu.measurements import Recording
from tirefmu.tires import Tire, read_tir
from tirefmu.tires.description import limits_of
from tirefmu.tires.property_file.names import not_measured, unmeasured_coefficients

LOADS, CAMBERS, PRESSURES, ANGLES = (1500.0, 3000.0, 4500.0), (0.0, 0.05), (180e3, 220e3), (-12.0, 12.0)
TRUTH = Tire("mf61", {
    "FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3, "NOMPRES": 200e3, "INFLPRES": 200e3,
    "PCX1": 1.6, "PDX1": 1.1, "PKX1": 22.0, "PEX1": -0.4, "RBX1": 12.0, "RBX2": 10.0, "RCX1": 1.0,
    "PCY1": 1.35, "PDY1": 1.02, "PDY2": -0.1, "PEY1": -0.8, "PKY1": 18.0, "PKY2": 1.9, "PKY4": 2.0, "PPY1": 0.5,
    "PKY6": 1.0, "RBY1": 12.0, "RBY2": 10.0, "RCY1": 1.0, "QDZ1": 0.1, "QBZ1": 8.0, "QCZ1": 1.1, "QBZ9": 10.0,
}, signs="adapted-sae")  # fmt: skip
EFFECTS = ["load_friction", "load_stiffness", "camber_thrust", "pressure_stiffness", "combined_Gxa", "combined_Gyk"]


def measured(loads=LOADS, cambers=CAMBERS, pressures=PRESSURES, angles=ANGLES, slips=(0.0,), outputs=("Fy", "Mz")):
    """Return sweeps of the slip angle at each condition, with noise, in adapted SAE."""
    rng, parts = np.random.default_rng(3), []
    for load in loads:
        for camber in cambers:
            for pressure in pressures:
                for kappa in slips:
                    alpha = np.radians(np.linspace(*angles, 60))
                    held = {"kappa": kappa, "gamma": camber, "Fz": load, "p": pressure, "V": 16.7}
                    forces = TRUTH.forces(alpha=alpha, **held)
                    rows = {name: forces[name] + rng.normal(0.0, 8.0, len(alpha)) for name in outputs}
                    parts.append(pd.DataFrame({"alpha": alpha, **held, **rows}))
    table = pd.concat(parts, ignore_index=True)
    return table.assign(t=0.02 * np.arange(len(table)))


def fitted(table):
    options = {"effects": EFFECTS, "recipe": "joint", "nominal": {"Fz0": 3000.0, "R0": 0.3, "p0": 200e3}}
    return fit(table, "mf61", signs="adapted-sae", **options)


KINDS = {
    "peak": ({"angles": (-2.0, 2.0)}, "peak friction", "the slope of Fy at the end of the data is"),
    "small slips": ({"angles": (4.0, 14.0)}, "slip stiffness", "at the smallest slips"),
    "one load": ({"loads": (3000.0,)}, "influence of load", "one load, 3000 N"),
    "one camber": ({"cambers": (0.05,)}, "influence of camber", "one inclination, 2.9 deg"),
    "one pressure": ({"pressures": (180e3,)}, "influence of pressure", "one pressure, 180 kPa"),
    "no trail": ({"outputs": ("Fy",)}, "", "neither moment nor pneumatic trail"),
    "cornering": ({}, "combined slip", "no rows have kappa and alpha"),
}


@pytest.mark.parametrize(("missing", "characteristic", "reason"), KINDS.values(), ids=KINDS)
def test_what_the_data_never_show_is_stated(missing, characteristic, reason):
    result = fitted(measured(**missing))
    (entry,) = [c for c in result.findings.coverage if reason in c.reason and c.channel in ("Fy", "Mz")][:1]
    assert (entry.characteristic, entry.determined) == (characteristic, False)
    assert any(reason in text for text in result.verdict.reasons)
    assert any(reason in text for text in not_measured(result.tire).values())
    one_side = "the other side of Fy is not determined: slip angles from 4 to 14 deg only"
    assert (one_side in result.verdict.reasons) == (missing.get("angles") == (4.0, 14.0))
    frictions = [c for c in result.findings.characteristics if c.quantity == "peak friction"]
    if characteristic == "peak friction":
        for c in frictions:  # an estimate from the slope, no reading of the largest measured ratio
            assert c.reached < 0.9
            assert abs(c.read - 1.02) < 2.0 * c.error
            assert not c.shown
    else:
        assert all(c.shown for c in frictions)


def test_a_peak_that_was_not_measured_is_drawn_as_extrapolation_with_an_interval_that_contains_it():
    table = measured(angles=(-2.0, 2.0), pressures=(200e3,), cambers=(0.0,))
    result = fitted(table)
    (figure,) = (f for f in figures_of(result, Recording(table, "adapted-sae", "a.csv")) if f.name == "pure_Fy")
    panel = figure.panels[0]
    dotted = [series for series in panel.series if series.dashes == DOTTED]
    assert len(dotted) == len(LOADS)
    assert all(np.nanmax(np.abs(series.x)) > 4.0 for series in dotted)
    assert "extrapolation" in figure.note
    at = pd.DataFrame({"alpha": [radians(8.0)], "Fz": [3000.0], "p": [200e3]})
    interval = result.interval("Fy", at, signs="adapted-sae").iloc[0]
    true = TRUTH.forces(alpha=radians(8.0), Fz=3000.0, p=200e3)["Fy"]
    assert interval["lower"] < true < interval["upper"]
    assert interval["error"] > 0.05 * true


@pytest.fixture(scope="module")
def cornering():
    """Return a fit of a cornering test, and one that has measured everything."""
    both = measured(slips=(-0.1, 0.0, 0.1), outputs=("Fx", "Fy", "Mz"))
    return fitted(measured()), fitted(both)


def test_what_was_measured_is_not_marked(cornering):
    whole = cornering[1]
    marked = {c.characteristic for c in whole.findings.coverage if c.reason and c.channel == "Fy"}
    assert not marked
    assert not {"PDY1", "PKY1"} & unmeasured_coefficients(whole.tire)


@pytest.mark.parametrize(("angles", "stated"), [((-2.0, 2.0), True), ((-10.0, 10.0), False)])
def test_combined_slip_far_below_the_peak_of_the_side_force_is_extrapolated(angles, stated):
    outputs, upright = ("Fx", "Fy"), {"cambers": (0.0,), "pressures": (200e3,)}
    combined = measured(angles=angles, slips=(-0.1, -0.05, 0.05, 0.1), outputs=outputs, **upright)
    table = pd.concat([measured(outputs=outputs, **upright), combined], ignore_index=True)
    result = fitted(table.assign(t=0.02 * np.arange(len(table))))
    entries = [c for c in result.findings.coverage if c.characteristic == "combined slip"]
    assert all(c.determined for c in entries)
    assert entries
    assert all(bool(c.reason) == stated for c in entries)
    assert any("is extrapolated: measured up to 2.0 deg" in text for text in result.verdict.reasons) == stated


def test_a_cornering_test_says_nothing_of_fx_in_any_file(cornering, tmp_path):
    tire = cornering[0].tire
    tire.save(tmp_path / "a.tir")
    again = read_tir(tmp_path / "a.tir")
    assert not_measured(again) == not_measured(tire)
    assert {"Fx, Mx, My", "combined slip of Fy"} <= not_measured(again).keys()
    assert {"PDX1", "PKX1", "RBX1", "RBY1"} <= unmeasured_coefficients(again)
    assert not {"PDY1", "PKY1"} & unmeasured_coefficients(again)
    lines = (tmp_path / "a.tir").read_text(encoding="utf-8").splitlines()
    (friction,), (cornering_friction,) = ([x for x in lines if x.startswith(f"{n} =")] for n in ("PDX1", "PDY1"))
    assert friction.endswith(", not measured")
    assert not cornering_friction.endswith("measured")
    description = contents(again, 3, "a")["modelDescription.xml"]
    assert b"not determined by its data: combined slip of Fy" in description
    (listed,) = ElementTree.fromstring(description).iter("ModelVariables")
    remarks = {v.get("name"): "not measured" in v.get("description") for v in listed}
    assert all(remarks[name] for name in ("Fx", "PDX1", "PKX1", "RBX1"))
    assert not any(remarks[name] for name in ("Fy", "Mz", "PDY1", "PKY1", "kappa"))
    assert set(not_measured(again).values()) <= set(limits_of(again))


def test_what_was_not_measured_is_marked_beside_sliders_and_dotted_in_comparisons(cornering):
    side, whole = (result.tire for result in cornering)
    shown = tire_data(side, "side", side.values, {}, ())
    marks = {each["name"]: each["measured"] for kind in ("outputs", "coefficients") for each in shown[kind]}
    assert not any(marks[name] for name in ("Fx", "PDX1", "PKX1"))
    assert all(marks[name] for name in ("Fy", "PDY1", "PKY1"))
    assert not shown["roles"]["friction_x"]["measured"]
    assert shown["roles"]["friction_y"]["measured"]
    figures = comparison_figures(compare(side, whole, names=("side", "whole")), [], "iso")
    for figure in figures:
        of_fx = "Fx" in figure.name or "_x_" in figure.name
        lines = [series for panel in figure.panels for series in panel.series if series.kind == "line"]
        assert any(series.dashes == DOTTED for series in lines) == of_fx, figure.name
        assert ("dotted: side, not measured" in figure.note) == of_fx


def test_a_comparison_marks_what_was_not_measured_and_lists_it_last(cornering):
    one, other = (result.tire for result in cornering)
    result = compare(one, other, names=("one", "other"))
    remarks = {d.name: d.unmeasured for d in result.differences}
    assert "one" in remarks["PDX1"]
    assert remarks["PDY1"] == ()
    marked = [bool(d.unmeasured) for d in result.differences]
    assert marked == sorted(marked)
    titles = {c.title: c.unmeasured for c in result.characteristics}
    assert "one" in titles["longitudinal friction"]
    assert titles["lateral friction"] == ()


def test_an_effect_that_does_nothing_is_named(capsys):
    idle = Tire("mf61", {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3}, effects=["relax_mf", "temp_friction"])
    assert {text.split()[2] for text in limits_of(idle)} == {"relax_mf", "temp_friction"}
    assert limits_of(idle.with_values(SIGK=1.0, TMU1=0.1)) == []
    result = fit(
        measured(cambers=(0.0,), pressures=(200e3,)), "mf61", signs="adapted-sae", recipe="joint",
        effects=["load_friction", "relax_mf"], nominal={"Fz0": 3000.0, "R0": 0.3},
    )  # fmt: skip
    assert any("relax_mf does nothing" in note for note in result.notes)
    assert not any("load_friction does nothing" in note for note in result.notes)
    Terminal().fit_result(result)
    assert "note: the effect relax_mf does nothing: its coefficients have neutral values\n" in capsys.readouterr().out
