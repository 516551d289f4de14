"""The result of a fit: goodness of fit by its definition, status, strict JSON."""

from __future__ import annotations

import json
from dataclasses import replace
from math import inf, nan
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tirefmu.boundary.errors import UnknownName
from tirefmu.fitting import fit
from tirefmu.fitting.constraints.physical import chosen_constraints
from tirefmu.fitting.constraints.verification import Margin
from tirefmu.fitting.data.fit_data import ExcludedRows
from tirefmu.fitting.evidence.characteristics import Characteristic
from tirefmu.fitting.evidence.clipping import Clipped
from tirefmu.fitting.evidence.continuity import Discontinuity
from tirefmu.fitting.evidence.diagnostics import Findings
from tirefmu.fitting.evidence.slip_stiffness import SlipStiffness
from tirefmu.fitting.results.records import ChannelFit, StageFit, quality
from tirefmu.fitting.results.solved_stage import FitSolution
from tirefmu.fitting.results.verdict import verdict_of
from tirefmu.fitting.uncertainty.sandwich import QUANTILE
from tirefmu.measurements import Noise, Recording, VirtualBench, alpha_sweeps
from tirefmu.tires import read_tir

NUMBERS = arrays(np.float64, st.integers(2, 30), elements=st.floats(-1e4, 1e4))


@given(measured=NUMBERS, data=st.data())
def test_quality_is_its_definition(measured, data):
    computed = data.draw(arrays(np.float64, len(measured), elements=st.floats(-1e4, 1e4)))
    gaps = data.draw(arrays(np.bool_, len(measured)))
    y = np.where(gaps, np.nan, measured)
    n, rmse, centred, uncentred = quality(y, computed)
    assert n == np.sum(~gaps)
    if not n:
        assert np.isnan([rmse, centred, uncentred]).all()
        return
    residual = (computed - measured)[~gaps]
    assert rmse == pytest.approx(np.sqrt(np.mean(residual**2)), rel=1e-9, abs=1e-12)
    variance = np.var(measured[~gaps])
    if variance > 1e-12:
        assert 1 - centred == pytest.approx(np.mean(residual**2) / variance, rel=1e-6)
    # The data's mean explains nothing in the one and something in the other.
    if np.isfinite(centred) and np.isfinite(uncentred):
        assert centred <= uncentred + 1e-9 * abs(centred)


def test_quality_of_a_perfect_fit_and_of_the_mean():
    measured = np.array([1.0, 2.0, 4.0, 7.0])
    assert quality(measured, measured) == (4, 0.0, 1.0, 1.0)
    assert quality(measured, np.full(4, 3.5))[2] == 0.0
    assert quality(measured, np.zeros(4))[3] == 0.0
    assert np.isnan(quality(np.full(4, 3.0), np.zeros(4))[2])  # no variation: nothing to explain
    assert np.isnan(quality(np.zeros(4), np.zeros(4))[3])


def test_a_computed_nan_is_not_ignored():
    """A NaN of the tire at a measured row is not ignored."""
    n, rmse, centred, uncentred = quality(np.array([1.0, 2.0, 4.0, nan]), np.array([1.0, nan, 4.0, 5.0]))
    assert n == 3
    assert np.isnan([rmse, centred, uncentred]).all()


def test_ok_requires_converged_stages_and_satisfied_constraints(side_fit):
    result, _ = side_fit
    assert result.ok
    assert result.status == "converged"
    failed = StageFit("late", 10, 2, 300, False, "iteration limit", 1.0, 0.5)
    late = replace(result, run=replace(result.run, stages=(*result.stages, failed)))
    assert not late.ok
    assert late.status == "not converged: stage 'late' ended: iteration limit"
    violated = replace(result, margins=(*result.margins, Margin("E_y <= 1", 1.25, -0.25, {"Fz": 1120.0})))
    assert not violated.ok
    assert violated.status == "constraint E_y <= 1 violated by 0.25"
    hairline = replace(result, margins=(Margin("E_y <= 1", 1.0, -1e-9, {}),))
    assert hairline.ok


def test_json_is_strict_and_complete(side_fit):
    result, recording = side_fit
    unbounded = replace(result.coefficients[0], lower=-inf, upper=inf)
    odd = replace(
        result, coefficients=(unbounded, *result.coefficients[1:]), channels=(replace(result.channels[0], r2=nan),)
    )
    plain = json.loads(json.dumps(odd.to_json(), allow_nan=False))
    assert (plain["coefficients"][0]["lower"], plain["coefficients"][0]["upper"]) == (None, None)
    assert plain["channels"][0]["r2"] is None
    assert plain["values"] == dict(result.tire.values)
    assert plain["effects"] == sorted(result.tire.has)
    assert plain["ok"] is True
    assert (plain["model"], plain["signs"], plain["recipe"]) == ("mf96", "iso", "progressive")
    assert [stage["name"] for stage in plain["stages"]] == [stage.name for stage in result.stages]
    assert {margin["constraint"] for margin in plain["margins"]} == {margin.constraint for margin in result.margins}
    assert plain["channels"][0]["recording"] == recording.source
    assert plain["notes"] == list(result.notes)


def test_the_table_has_a_row_per_coefficient(side_fit):
    result, _ = side_fit
    table = result.table().set_index("name")
    assert list(table.index) == [coefficient.name for coefficient in result.coefficients]
    assert table.loc["PDY1", "value"] == result.tire.values["PDY1"]
    assert table.loc["PKY1", "value"] == result.tire.values["PKY1"] < 0
    assert table.loc["PKY1", "unit"] == "1/rad"
    order = list(result.tire.symbolic_model.coefficients)
    assert [order.index(name) for name in table.index] == sorted(order.index(name) for name in table.index)


def test_coefficients_in_other_signs_are_those_of_the_tire_in_other_signs(side_fit):
    result, _ = side_fit
    other = result.in_signs("adapted-sae")
    assert (result.signs, other.signs) == ("iso", "adapted-sae")
    values = result.tire.in_signs("adapted-sae").values
    declarations = result.tire.symbolic_model.coefficients
    flipped = {name for name in result.covariance if declarations[name].flips}
    assert {"PKY1"} <= flipped < set(result.covariance)
    for ours, theirs in zip(result.coefficients, other.coefficients, strict=True):
        assert theirs.value == values[theirs.name]
        assert theirs.lower <= theirs.value <= theirs.upper
        assert (ours.interval == theirs.interval) or np.isnan(ours.interval)
        if ours.name in flipped:
            assert (ours.lower, ours.upper) == (-theirs.upper, -theirs.lower)
    known = result.covariance.notna() & (result.covariance != 0.0)
    for one, two in zip(*np.nonzero(known), strict=True):
        sign = -1.0 if (result.covariance.index[one] in flipped) != (result.covariance.index[two] in flipped) else 1.0
        assert other.covariance.iloc[one, two] == sign * result.covariance.iloc[one, two]
    back = other.in_signs("iso")
    assert back.coefficients == result.coefficients
    assert back.findings.conditions == result.findings.conditions
    assert other.findings.conditions[0].mean == -result.findings.conditions[0].mean != 0.0  # of Fy
    with pytest.raises(UnknownName, match="'sae': known are iso, adapted-sae"):
        result.in_signs("sae")


def test_intervals_are_those_of_the_covariance(side_fit):
    result, _ = side_fit
    names = [c.name for c in result.coefficients]
    assert list(result.covariance.index) == list(result.covariance.columns) == names
    deviation = np.sqrt(np.diag(result.covariance))
    for c, sigma in zip(result.coefficients, deviation, strict=True):
        if np.isfinite(c.interval):
            assert c.interval == pytest.approx(QUANTILE * sigma, rel=1e-12)
        else:
            assert result.covariance[c.name].isna().all()
    known = [c.name for c in result.coefficients if np.isfinite(c.interval)]
    assert len(known) > 8
    matrix = result.covariance.loc[known, known]
    assert matrix.notna().all(axis=None)
    assert np.linalg.eigvalsh(result.correlation.loc[known, known])[0] > -1e-9
    np.testing.assert_allclose(np.diag(result.correlation.loc[known, known]), 1.0)
    stage = {c.name: c.stage for c in result.coefficients}
    for one in known:
        for two in known:
            if stage[one] != stage[two]:
                assert matrix.loc[one, two] == 0.0
    saved = result.to_json()["covariance"]
    assert saved["coefficients"] == known
    assert np.array_equal(saved["matrix"], matrix)


def test_a_result_is_shown_in_a_few_lines(side_fit):
    result, recording = side_fit
    shown = repr(result)
    assert len(shown.splitlines()) < 10
    assert "converged" in shown
    assert "iso signs" in shown
    assert recording.source in shown
    hostile = replace(result.channels[0], recording="<script>alert(1)</script>\x1b[2J")
    page = replace(result, channels=(hostile,))._repr_html_()
    assert "<script" not in page
    assert "\x1b" not in page + repr(replace(result, channels=(hostile,)))
    assert "<td>PKY1</td>" in page


def test_the_stages_report_rows_and_coefficients(side_fit):
    result, recording = side_fit
    first, *_, last = result.stages
    assert last.rows == len(recording)
    assert first.free <= last.free == sum(coefficient.determined for coefficient in result.coefficients)
    assert all(stage.iterations > 0 for stage in result.stages[:-1])
    assert last.converged  # it continues the stage before it, here with the same rows, and may start at the optimum
    assert last.r2_uncentred == pytest.approx(result.channels[0].r2_uncentred, abs=1e-9)


def test_a_result_is_saved_and_has_its_errors_and_coefficients(side_fit, tmp_path):
    result, _ = side_fit
    result.save(tmp_path / "side.tir")
    assert read_tir(tmp_path / "side.tir")["PDY1"] == result.tire["PDY1"] == result.tire.values["PDY1"]
    assert result.rmse == {"Fy": pytest.approx(result.channels[0].fitted_rmse)}
    with pytest.raises(UnknownName, match="PDY1"):
        result.tire["PDYI"]


# -------------------------------- The verdict on a fit: what makes a tire unusable, what limits it, in order of weight


def stiffness(error, load=500.0):
    return SlipStiffness("a.csv", "Fy", "alpha", "N/rad", load, 1e4, 1e4 * (1.0 + error), 3)


def lacking(share):
    """Return a fit of Fy whose error is 5 times its floor and this share of the spread of the values."""
    return ChannelFit(
        "a.csv", "Fy", "N", 900, 49.0, 0.9, 0.9, 9.8, 300.0, 900, 49.0, 1.0 - (0.98 * share) ** 2, 1.0, 48.0, 2.0
    )


@pytest.fixture
def judged(side_fit):
    """Return a function that gives the verdict on a good fit with some attributes changed."""
    result, _ = side_fit
    good = {
        "ok": True, "status": "converged", "tire": result.tire, "coefficients": (),
        "channels": tuple(replace(result.channels[0], channel=name, recording="a.csv") for name in ("Fx", "Fy")),
        "excluded_rows": (), "bounds": (), "solution": FitSolution(),
        "findings": Findings(stiffnesses=(stiffness(0.02),)),
    }  # fmt: skip
    names = [each.name for own in chosen_constraints(result.tire.model).values() for each in own]
    good["margins"] = [Margin(name, 0.0, 1.0, {}, name) for name in names]

    def verdict(**changed):
        return verdict_of(SimpleNamespace(**{**good, **changed}))

    return verdict


def test_a_good_fit_has_no_reasons(judged):
    verdict = judged()
    assert (verdict.word, verdict.reasons, verdict.usable) == ("good", (), True)


def test_each_reason_has_its_consequence(judged, side_fit):
    result, _ = side_fit
    cut = Clipped("a.csv", "Fy", "N", float("nan"), 2300.0, 0.16)
    low = Characteristic("a.csv", "Fy", "peak friction", "1", 500.0, 2.0, 1.6, 0.02, {"Fz": 500.0})
    step = Discontinuity("Mx", "N m", "jump", -28.0, "alpha", 0.0017, {"Fz": 2750.0})
    force, moment = result.channels[0], replace(result.channels[0], channel="Mz", fitted_r2=-1.0)
    excluded = ExcludedRows("a.csv", "warm-up", "cold tread", 400, 1000, ())
    bounded = replace(result.coefficients[0], at_bound=True)
    cases = [
        ({"ok": False, "status": "not converged"}, "not usable", "not converged"),
        ({"channels": (force, replace(force, channel="Fx", fitted_r2=-0.63))}, "not usable", "Fx is not described"),
        ({"findings": Findings(stiffnesses=(stiffness(-0.999),))}, "not usable", "Fy differs by -100% over all loads"),
        ({"findings": Findings(stiffnesses=(stiffness(-0.16),))}, "usable with limits", "differs by -16% at 500 N"),
        ({"channels": (force,)}, "usable with limits", "Fx is not fitted"),
        ({"channels": (force, replace(force, channel="Fx", fitted_r2=0.3))}, "usable with limits", "described poorly"),
        ({"channels": (force, replace(force, channel="Fx"), moment)}, "usable with limits", "Mz is not described"),
        (
            {"channels": (lacking(0.05), replace(force, channel="Fx"))},
            "usable with limits",
            "is 5.0 times the noise floor (48 N depends on time",
        ),
        (
            {"channels": (lacking(0.5), replace(force, channel="Fx"))},
            "not usable",
            "Fy: RMSE 49 N is 5.0 times the noise floor",
        ),
        ({"findings": Findings(clipped=(cut,))}, "not usable", "Fy is cut off at 2300 N in 16% of the rows"),
        (
            {"findings": Findings(characteristics=(low,))},
            "usable with limits",
            "the peak friction of Fy differs by -20% at Fz 500 N",
        ),
        (
            {"findings": Findings(discontinuities=(step,))},
            "usable with limits",
            "Mx of the tire jumps by 28 N m at alpha 0.1 deg, Fz 2750 N",
        ),
        ({"margins": ()}, "usable with limits", "physical constraints not imposed: curvature:E_x"),
        ({"coefficients": (bounded,)}, "usable with limits", f"1 of 1 coefficients at bounds: {bounded.name}"),
        ({"excluded_rows": (excluded,)}, "usable with limits", "a.csv: 40% of the rows excluded (warm-up)"),
    ]
    for changed, word, reason in cases:
        verdict = judged(**changed)
        assert verdict.word == word, changed
        assert verdict.usable == (word != "not usable")
        assert reason in verdict.reasons[0]
        assert len(verdict.reasons) == 1 or "stiffness" in verdict.reasons[1]
    poor = judged(channels=(replace(lacking(0.05), fitted_r2=0.3), replace(force, channel="Fx")))
    assert poor.word == "not usable"
    assert "Fy is described poorly" in poor.reasons[0]


def test_reasons_are_in_order_of_weight(judged, side_fit):
    result, _ = side_fit
    wrong = replace(result.channels[0], channel="Fx", fitted_r2=-0.1)
    bounded = replace(result.coefficients[0], at_bound=True)
    verdict = judged(
        channels=(result.channels[0], wrong), coefficients=(bounded,),
        findings=Findings(stiffnesses=(stiffness(0.2), stiffness(0.3, 900.0))),
    )  # fmt: skip
    assert verdict.word == "not usable"
    for text, reason in zip(("Fx is not described", "+30% at 900 N", "at bounds"), verdict.reasons, strict=True):
        assert text in reason


def test_side_force_alone_is_a_limit(side_fit):
    result, _ = side_fit
    assert result.verdict.word == "usable with limits"
    assert result.verdict.reasons[0] == "Fx is not fitted: no measured values vary with kappa"
    plain = result.to_json()
    assert plain["ok"] is True
    assert (plain["verdict"], plain["reasons"]) == ("usable with limits", list(result.verdict.reasons))


def test_combined_slip_beyond_the_measured_slip_angle_is_extrapolated(known, make):
    """The bench drives and brakes at up to 6 deg of slip angle, and sweeps to 12 deg."""
    result = make.fit(make.bench(known), recipe="joint")
    (reason,) = [each for each in result.verdict.reasons if "combined slip" in each]
    assert reason.startswith(
        "combined slip is extrapolated beyond 6.0 deg of slip angle (pure slip was measured up to "
    )


def test_spikes_do_not_affect_the_quality_of_the_fitted_rows(known):
    """One row in a hundred is wrong and excluded: over all rows the error is that of the spikes."""
    program = alpha_sweeps((500.0, 1000.0), (0.0,), sample_rate=20.0)
    table = VirtualBench(known, Noise.none(), seed=1).run(program).table[["t", "alpha", "Fz", "Fy"]].copy()
    table.loc[5::100, "Fy"] = 3e4
    effects = ["load_friction", "load_stiffness", "plysteer", "conicity"]
    result = fit(Recording(table, "adapted-sae", "spiked"), "mf96", effects=effects, nominal={"Fz0": 700.0})
    (channel,) = result.channels
    assert channel.rows - channel.fitted_rows >= len(table) // 100
    assert channel.rmse > 2000.0
    assert channel.r2 < 0.5
    assert channel.fitted_rmse < 30.0
    assert channel.fitted_r2 > 0.999
    assert result.verdict.usable
