"""Two tires compared: differences, errors, sweeps without mixed conditions, figures of the tires, page and command."""

from __future__ import annotations

import json
from dataclasses import replace
from math import radians

import numpy as np
import pandas as pd
import pytest

from tests.hostile import EACH_PAGE, Skeleton
from tirefmu import compare
from tirefmu.applications.comparison.figures import comparison_figures, write_comparison
from tirefmu.applications.comparison.sweeps import sweeps
from tirefmu.commands.cli import main
from tirefmu.drawing.style import DASHED, SOLID
from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps, concatenate, kappa_sweeps, write_table
from tirefmu.tires import published, read_tir

LOADS = (440.0, 900.0)


@pytest.fixture(scope="module")
def old():
    return published("trento_hoosier")


@pytest.fixture(scope="module")
def new(old):
    return replace(old.with_values(PDY1=2.5, PKY2=3.9), effects=old.has - {"camber_thrust"}, name="new tire")


@pytest.fixture(scope="module")
def bench(old):
    """Return a recording without noise, in adapted SAE, at two loads, with and without camber and the other slip."""
    alpha = alpha_sweeps(LOADS, [0.0, radians(3.0)], sample_rate=8.0)
    return VirtualBench(old, Noise.none()).run(concatenate([alpha, kappa_sweeps(LOADS, [0.0, 0.05], sample_rate=8.0)]))


@pytest.mark.parametrize(
    ("ranges", "begin"),
    [
        ((100.0, 1000.0), "at 220 N, new against old"),
        ((60.0, 160.0), "at 160 N, new against old"),
        ((300.0, 9000.0), "at 300 N, new against old"),
        ((60.0, 90.0), "at 90 N, outside the range of old, new against old"),
        ((8000.0, 9000.0), "at 220 N, outside the range of new, new against old"),
    ],
)
def test_quantities_are_compared_at_a_load_of_both_tires(old, new, ranges, begin):
    result = compare(old, replace(new, ranges={**new.ranges, "Fz": ranges}), names=("old", "new"))
    assert result.verdict.startswith(begin)


def test_differences_are_those_of_the_values(old, new):
    result = compare(old, new, names=("old", "new"))
    iso = old.in_signs("iso").values, new.in_signs("iso").values
    assert {difference.name for difference in result.differences} == {
        name for name in iso[0] if iso[0][name] != iso[1][name]
    }
    assert {"PDY1", "PKY2", "PVY3"} <= {difference.name for difference in result.differences}
    for difference in result.differences:
        assert (difference.first, difference.second) == (iso[0][difference.name], iso[1][difference.name])
    assert result.effects == (("camber_thrust",), ())
    assert compare(old, old, names=("a", "a")).differences == ()
    assert compare(old, old, names=("a", "a")).names == ("a (1)", "a (2)")


def test_characteristics_are_those_of_each_tire_at_the_nominal_load(old, new):
    nominal = {"Fz": [old.values["FNOMIN"]]}
    values = [tire.evaluate(pd.DataFrame(nominal), signs="iso", steady=True).loc[0] for tire in (old, new)]
    characteristics = compare(old, new, names=("old", "new")).characteristics
    pairs = {(characteristic.first, characteristic.second) for characteristic in characteristics}
    for name in ("mu_y", "K_yalpha"):
        assert values[0][name] != values[1][name]
        assert (values[0][name], values[1][name]) in pairs


def test_tires_of_other_models_lack_coefficients(old, golden):
    result = compare(old, read_tir(golden / "MagicFormula61_Parameters.tir"), names=("old", "new"))
    values = {difference.name: (difference.first, difference.second) for difference in result.differences}
    assert values["PPY1"][0] is None
    assert None not in values["PDY1"]
    json.dumps(result.to_json(), allow_nan=False)


def test_errors_are_those_of_the_evaluation(old, new, bench):
    result = compare(old, new, [bench.with_signs("iso")], names=("old", "new"))
    assert [error.channel for error in result.errors] == ["Fx", "Fy", "Mz"]
    side = result.errors[1]
    assert 0.9 * len(bench) < side.rows <= len(bench)
    assert side.rmse[0] < 1e-9
    assert side.r2[0] == pytest.approx(1.0, abs=1e-12)
    all_rows = new.evaluate(bench.table, signs=bench.signs)["Fy"] - bench.table["Fy"]
    assert side.rmse[1] == pytest.approx(np.sqrt(np.mean(all_rows**2)), rel=0.1)


def test_the_verdict_weighs_recordings_by_their_rows(old, new, bench):
    """The first tire is exact for the long recording; the second one is exact for the short one, with larger errors."""
    short = VirtualBench(new, Noise.none()).run(alpha_sweeps(LOADS[1:], [0.0], sample_rate=4.0))
    result = compare(old, new, [bench, short], names=("old", "new"))
    errors = [error for error in result.errors if error.channel == "Fy"]
    assert errors[0].rows > 4 * errors[1].rows
    assert errors[0].rmse[1] < errors[1].rmse[0]
    assert "old in Fy" in result.verdict


def test_sweeps_are_upright_and_not_mixed(old, bench):
    for slip, other in (("alpha", "kappa"), ("kappa", "alpha")):
        found = sweeps([old], slip, [bench])
        assert [round(condition.load, -1) for condition in found] == list(LOADS)
        for sweep in found:
            assert sweep.rows["gamma"].abs().max() < radians(1.0)
            assert sweep.rows[other].abs().max() < 0.02
            assert np.ptp(sweep.rows["Fz"]) < 100.0
    assert len(sweeps([old], "alpha", [])) == 3


@pytest.mark.parametrize("signs", ["iso", "adapted-sae", "sae"])
def test_curves_are_those_of_the_tires(old, new, bench, signs):
    given = comparison_figures(compare(old, new, names=("old", "new")), [bench], signs)
    figures = {figure.name: figure.panels for figure in given}
    found = sweeps([new], "alpha", [bench.with_signs(signs)])
    lines = [series for series in figures["Fy_over_alpha"][0].series if series.kind == "line"]
    for tire, dashes in ((old, DASHED), (new, SOLID)):
        curves = [series for series in lines if series.dashes == dashes]
        assert len(curves) == len(LOADS)
        for series, sweep in zip(curves, found, strict=True):
            x, y = series.points
            table = sweep.rows.iloc[:1].assign(**sweep.held).loc[np.zeros(len(x), int) + sweep.rows.index[0]]
            expected = tire.evaluate(table.assign(alpha=np.radians(x)).drop(columns="t"), signs=signs)["Fy"]
            np.testing.assert_allclose(y, expected, rtol=1e-9)
    slopes = [series for series in figures["Fy_slope_over_alpha"][0].series if series.dashes == SOLID]
    curve = next(series for series in figures["stiffness_y_over_load"][0].series if series.label.startswith("new"))
    for series, sweep in zip(slopes, found, strict=True):
        steepest = series.points[1].max()  # positive at zero slip, in the unit of the stiffness
        assert steepest == pytest.approx(np.interp(abs(sweep.load), *curve.points), rel=0.05)


def test_one_figure_has_one_pressure_and_one_curve_for_each_load(new, bench):
    """Two runs at the same pressure are one sweep; the shorter run at another pressure is not drawn."""
    iso = bench.with_signs("iso")
    first, second, other = (replace(iso, table=iso.table.assign(p=p)) for p in (83e3, 83.5e3, 55e3))
    other = replace(other, table=other.table.iloc[: len(iso) // 2])
    found = sweeps([new], "alpha", [other, first, second])
    assert [round(condition.load, -1) for condition in found] == list(LOADS)
    assert all(condition.held["p"] == pytest.approx(83e3, abs=1e3) for condition in found)
    alone = sweeps([new], "alpha", [first])
    assert [len(condition.rows) for condition in found] == [2 * len(condition.rows) for condition in alone]
    assert set().union(*(condition.rows["p"] for condition in found)) == {83e3, 83.5e3}


@pytest.mark.parametrize("text", EACH_PAGE)
def test_texts_do_not_change_the_page(old, new, bench, tmp_path, monkeypatch, text):
    monkeypatch.setattr("tirefmu.applications.comparison.figures.comparison_figures", lambda *_: [])

    def page(name):
        result = compare(old, new, [replace(bench, source=name)], names=(name, "second"))
        (path,) = write_comparison(result, [], tmp_path / "x")
        return path.read_text(encoding="utf-8")

    assert Skeleton(page(text)).parts == Skeleton(page("plain")).parts


def test_the_command(bench, new, tmp_path, capsys):
    write_table(bench.with_signs("iso").table, tmp_path / "run.csv")
    new.save(tmp_path / "new.tir")
    out = tmp_path / "out"
    arguments = ["compare", "trento_hoosier", str(tmp_path / "new.tir"), str(tmp_path / "run.csv"), "-o", str(out)]
    assert main([*arguments, "--json", str(tmp_path / "x.json")]) == 0
    printed = capsys.readouterr().out
    assert "effects of trento_hoosier only: camber_thrust" in printed
    written = json.loads((tmp_path / "x.json").read_text())["files"]
    assert sorted(path.name for path in out.iterdir()) == sorted(path.rpartition("/")[2] for path in written)
