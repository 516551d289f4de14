"""The correction of the formula's own form: within the tested range, and only if it predicts what no fit has used."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from tirefmu.diagnosis.diagnose import _start_model, with_library
from tirefmu.diagnosis.explanations import FORM, balanced, form_effect, form_of
from tirefmu.diagnosis.probing import fit_baseline
from tirefmu.diagnosis.reporting.effect_figures import form_figure
from tirefmu.diagnosis.signals import signals_of
from tirefmu.diagnosis.verdict import tire_of
from tirefmu.fitting import fit
from tirefmu.measurements import recording_from
from tirefmu.tires import tire_from

from .suite import make_case


@pytest.fixture(scope="module")
def made():
    """Return the problem of a recording whose tire is of the model, and the solution."""
    case = make_case(13, ())
    recording = recording_from(case.table, signs=case.signs)
    start = with_library(_start_model(recording, "mf96", case.effects, case.nominal))
    return fit_baseline(start, signals_of(case.table, start, case.signs), fitted=False)


def distorted(problem, share, channel="Fy"):
    """Return a problem of which a measured channel is larger at a medium load."""
    signals = problem.simulator.signals
    load, measured = signals.named()["Fz"], signals.measured.copy()
    place = (load - load.min()) / np.ptp(load)
    measured[signals.channels.index(channel)] *= 1.0 + share * np.exp(-(((place - 0.4) / 0.2) ** 2))
    return problem.over(problem.simulator.with_signals(replace(signals, measured=measured)))


def test_an_exact_form_is_not_corrected(made):
    assert form_of(*made) is None


@pytest.mark.slow
def test_what_the_formula_errs_by_is_corrected_on_rows_that_no_fit_used(made):
    problem, solution = made
    wrong = distorted(problem, 0.08)
    fitted = wrong.solve(solution.parameters, solution.free)
    wider, corrected, change = form_of(wrong, fitted)
    signals = wrong.simulator.signals
    side = signals.channels.index("Fy")
    held = signals.present[side] & signals.holdout
    before, after = (np.sqrt(np.mean(one.residual[side][held] ** 2)) for one in (fitted, corrected))
    assert after < 0.8 * before
    assert np.sqrt(np.mean(change[side] ** 2)) > 0.3 * before
    assert FORM in tire_of(wider, corrected, [FORM]).has


def test_a_force_does_not_correct_the_formula_of_a_moment(made):
    """Nor is it fitted to it: the trail takes what is wrong in the moment."""
    problem, solution = made
    wrong = distorted(problem, 0.5, "Mz")
    fitted = wrong.solve(solution.parameters, solution.free)
    side, noise = wrong.simulator.signals.channels.index("Fy"), wrong.inverse_noise
    for _ in range(2):
        wrong, fitted = balanced(wrong, fitted, noise).fitted(fitted.parameters, fitted.free)
    _, corrected, change = form_of(wrong, fitted)
    assert {name[: len("FORM_T")] for name in corrected.free if name.startswith(FORM.upper())} == {"FORM_T"}
    size = np.sqrt(np.mean(wrong.simulator.signals.measured[side] ** 2))
    for moved in (fitted.residual[side] - solution.residual[side], change[side]):
        assert np.sqrt(np.mean(moved**2)) < 0.005 * size


def test_the_correction_is_zero_outside_the_tested_range():
    tire = tire_from("trento_hoosier")
    geometry = {"FORMF0": 0.5, "FORMFW": 0.25, "FORMS0": 0.03, "FORMSW": 0.06}
    effect = form_effect(("friction_y", "stiffness_y"))
    shares = {one.name: 0.1 for one in effect.declarations if one.name not in geometry}
    corrected = replace(tire, added=(*tire.added, effect), effects=(*tire.has, FORM)).with_values(**geometry, **shares)
    nominal = tire.values["FNOMIN"]
    ratios = {}
    for share in (0.15, 0.8, 1.6):  # of the nominal load; bumps are from 0.19 to 1.56 of it
        table = pd.DataFrame({"Fz": share * nominal, "alpha": [-0.1, 0.02, 0.1]})
        before, after = (one.evaluate(table)["Fy"] for one in (tire, corrected))
        ratios[share] = np.abs(after / before - 1.0).max()
    assert ratios[0.15] == ratios[1.6] == 0.0
    assert ratios[0.8] > 0.02


def test_friction_at_combined_slip_tells_driving_from_braking():
    tire = tire_from("trento_hoosier")
    geometry = {"FORMF0": 0.5, "FORMFW": 0.25, "FORMS0": 0.03, "FORMSW": 0.06, "FORMLW": 0.1, "FORMKW": 0.15}
    effect = form_effect(("friction_x",), combined=True)
    driving = {f"FORM_MX{load}5": 0.05 for load in (1, 2, 3, 4)}
    corrected = replace(tire, added=(*tire.added, effect), effects=(*tire.has, FORM)).with_values(**geometry, **driving)
    table = pd.DataFrame(
        {
            "Fz": 0.8 * tire.values["FNOMIN"],
            "kappa": [0.15, -0.15, 0.15, 0.0, 0.15],
            "alpha": [0.05, 0.05, -0.05, 0.1, 0.0],
        }
    )
    before, after = (one.evaluate(table)["Fx"].to_numpy() for one in (tire, corrected))
    change = after - before
    assert change[0] > 0.01 * before[0]
    assert change[2] == pytest.approx(change[0], rel=0.2)  # the tire itself is not symmetric
    np.testing.assert_allclose(change[[1, 3, 4]], 0.0, atol=1e-9)  # braking, and one slip alone


def test_a_correction_of_one_force_is_drawn_over_the_slip_that_it_follows():
    """Also where the other slip varies more, and at combined slip."""
    tire = tire_from("trento_hoosier")
    geometry = {"FORMF0": 0.5, "FORMFW": 0.25, "FORMS0": 0.03, "FORMSW": 0.06}
    corrected = replace(tire, added=(*tire.added, form_effect(("friction_x",))), effects=(*tire.has, FORM)).with_values(
        **geometry, FORM_MX22=0.03
    )
    slips, none = np.linspace(-0.1, 0.1, 9), np.zeros(9)
    for together in (True, False):
        kappa, alpha = (slips, 0.5 * slips) if together else (np.append(slips, none), np.append(none, 2.0 * slips))
        rows = pd.DataFrame({"Fz": 0.75 * tire.values["FNOMIN"], "kappa": kappa, "alpha": alpha})
        diagnosis = SimpleNamespace(
            rows=rows, tire=corrected, recording_signs="adapted-sae",
            run=SimpleNamespace(tested=corrected.added), form=SimpleNamespace(channels={"Fx": {}, "Fy": {}}),
        )  # fmt: skip
        panels = [panel for row in form_figure(diagnosis).rows for panel in row if panel]
        assert {panel.y for panel in panels} == {"correction of Fx (N)"}
        assert "\u03ba (-)" in {panel.x for panel in panels}
        assert any(not panel.title.endswith(": 0") for panel in panels) == together


def test_a_fit_keeps_the_loads_and_slips_of_the_bumps():
    tire = tire_from("trento_hoosier")
    geometry = {"FORMF0": 0.5, "FORMFW": 0.25, "FORMS0": 0.03, "FORMSW": 0.06}
    corrected = replace(tire, added=(*tire.added, form_effect(("friction_y",))), effects=(*tire.has, FORM)).with_values(
        **geometry, FORM_MY22=0.03
    )
    load, alpha = (grid.ravel() for grid in np.meshgrid([110.0, 165.0, 220.0], np.linspace(-0.2, 0.2, 81)))
    table = pd.DataFrame({"Fz": load, "alpha": alpha})
    table["Fy"] = corrected.with_values(FORM_MY22=0.06).evaluate(table)["Fy"]
    fitted = fit(table, start=corrected, effects=sorted(corrected.has)).tire
    assert {name: fitted.values[name] for name in geometry} == geometry
    assert fitted.values["FORM_MY22"] > corrected.values["FORM_MY22"]
