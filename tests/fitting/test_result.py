"""The result of a fit: goodness of fit by its definition, status, strict JSON."""

from __future__ import annotations

import json
from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tirefmu.boundary.errors import FitError, UnknownName
from tirefmu.fitting.constraints import Margin
from tirefmu.fitting.results.records import quality
from tirefmu.fitting.uncertainty.sandwich import QUANTILE
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
    failed = replace(result.stages[-1], name="late", converged=False, reason="iteration limit")
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


def test_a_result_draws_the_fitted_rows_and_the_tire(side_fit):
    result, recording = side_fit
    (panel,) = [ax for ax in result.plot().axes if ax.get_ylabel().startswith("Fy")]
    points = [line for line in panel.get_lines() if line.get_linestyle() == "None"]
    drawn = np.concatenate([line.get_ydata() for line in points])
    assert set(np.round(drawn, 6)) <= set(np.round(recording.with_signs("iso").table["Fy"], 6))
    assert not panel.patches
    (banded,) = [ax for ax in result.plot(bands=True).axes if ax.get_ylabel().startswith("Fy")]
    assert banded.patches
    assert "<img" in result._repr_html_()
    assert "stiffness" in result.plot("stiffness").get_suptitle().lower()
    with pytest.raises(UnknownName, match="did you mean stiffness"):
        result.plot("stifness")
    empty = replace(result, residuals=None)
    assert "<img" not in empty._repr_html_()
    with pytest.raises(FitError, match="no fitted rows"):
        empty.plot()


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
