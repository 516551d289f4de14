"""Every accepted form of a table or a tire has the same result, and anything else gives one clear sentence."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import tirefmu
from tirefmu.boundary.errors import DataError, FmuError, TirefmuError, TirError, UnknownName, WrongType
from tirefmu.fitting import assign_folds, cross_validate, draw_figures, fit
from tirefmu.fmu.packaging.export import fmi_version
from tirefmu.measurements import Noise, Recording, alpha_sweeps, recording_from, recordings_from

NAME = "trento_hoosier"


@pytest.fixture(scope="module")
def bench():
    """Return a recording in ISO signs."""
    program = alpha_sweeps([220.0, 700.0], [0.0, 0.05], sample_rate=2.0)
    recording = tirefmu.VirtualBench(NAME, Noise.none()).run(program).with_signs("iso")
    return Recording(recording.table.drop(columns=["Fx", "Mz"]), "iso", "bench.csv")


@pytest.fixture(scope="module")
def forms(bench, tmp_path_factory):
    """Return the recording in every form that is accepted."""
    path = tmp_path_factory.mktemp("tables") / "bench.csv"
    bench.table.to_csv(path, index=False)
    return {"Recording": bench, "DataFrame": bench.table, "Path": path, "str": str(path)}


@pytest.fixture(scope="module")
def tires(tmp_path_factory):
    """Return the published tire in every form that is accepted."""
    path = tmp_path_factory.mktemp("tires") / "tire.tir"
    tirefmu.published(NAME).save(path)
    return {"Tire": tirefmu.published(NAME), "name": NAME, "Path": path, "str": str(path)}


def test_every_form_of_a_table_is_the_same_recording(forms, bench):
    for form, table in forms.items():
        found = recording_from(table)
        assert found.signs == "iso", form
        pd.testing.assert_frame_equal(found.table, bench.table, rtol=1e-12)
    (single,) = recordings_from(forms["DataFrame"])
    assert [len(recording) for recording in recordings_from(list(forms.values()))] == [len(single)] * 4


def test_every_form_of_a_tire_evaluates_every_form_of_a_table(forms, tires, bench):
    expected = tires["Tire"].evaluate(bench.table)["Fy"]
    for tire in tires.values():
        pd.testing.assert_series_equal(tirefmu.evaluate(tire, bench.table)["Fy"], expected, rtol=1e-9)
    for table in forms.values():
        pd.testing.assert_series_equal(tirefmu.evaluate(NAME, table)["Fy"], expected, rtol=1e-9)
    pd.testing.assert_series_equal(tires["Tire"].evaluate(bench)["Fy"], expected, rtol=1e-9)
    turned = tirefmu.evaluate(NAME, bench.with_signs("sae"))
    np.testing.assert_allclose(turned["Fy"], -expected, rtol=1e-12)
    pd.testing.assert_frame_equal(tirefmu.evaluate(NAME, bench.with_signs("sae").table, signs="sae"), turned)


def test_signs_are_those_of_the_table_and_a_contradiction_is_refused(bench):
    assert recording_from(bench.table, signs="adapted-sae").signs == "adapted-sae"
    assert recording_from(bench, signs="iso") is bench
    with pytest.raises(DataError, match=r"^bench\.csv: the recording is in iso signs, not sae"):
        recording_from(bench, signs="sae")
    with pytest.raises(DataError, match="not sae"):
        fit(bench, signs="sae")
    with pytest.raises(UnknownName, match="unknown sign convention 'isso'"):
        recording_from(bench.table, signs="isso")


@pytest.mark.parametrize("wrong", [None, 3, {"alpha": [0.1]}, np.zeros((3, 2))], ids=["None", "int", "dict", "array"])
def test_invalid_tables_are_rejected_by_name(wrong):
    for function in (fit, cross_validate, lambda t: assign_folds(t, 2), lambda t: draw_figures(NAME, t, "figures")):
        with pytest.raises(WrongType, match=r"^tables is .* it has to be the path of a file, a DataFrame or a Rec"):
            function(wrong)
    for function in (recording_from, lambda t: tirefmu.evaluate(NAME, t)):
        with pytest.raises(WrongType, match=r"^table is .* the path of a file, a DataFrame or a Recording$"):
            function(wrong)
    with pytest.raises(WrongType, match=r"^tables\[0\] is "):
        fit([wrong])
    with pytest.raises(TypeError):  # WrongType is also a TypeError
        fit(wrong)


@pytest.mark.parametrize("wrong", [None, 3, [NAME]], ids=["None", "int", "list"])
def test_invalid_tires_are_rejected_by_name(wrong, bench, tmp_path):
    functions = {
        "evaluate": lambda: tirefmu.evaluate(wrong, bench),
        "draw": lambda: tirefmu.draw(wrong, tmp_path / "figures"),
        "export": lambda: tirefmu.export(wrong, tmp_path / "x.fmu"),
        "bench": lambda: tirefmu.VirtualBench(wrong),
    }
    for name, function in functions.items():
        with pytest.raises(WrongType, match=r"^tire is .* the name of a published tire$"):
            function()
        assert list(tmp_path.iterdir()) == [], name
    if wrong is not None:
        with pytest.raises(WrongType, match=r"^start is .* or 'features'$"):
            fit(bench, start=wrong)


def test_names_and_files_that_do_not_exist(bench, tmp_path):
    for function in (lambda tire: tirefmu.evaluate(tire, bench), lambda tire: tirefmu.export(tire, tmp_path / "x.fmu")):
        with pytest.raises(UnknownName, match="'trento_hosier': did you mean trento_hoosier"):
            function("trento_hosier")
        with pytest.raises(TirError, match=r"missing\.tir"):
            function(tmp_path / "missing.tir")
    with pytest.raises(UnknownName, match="unknown start 'feature': did you mean features"):
        fit(bench, start="feature")


def test_a_folder_with_a_published_name_does_not_hide_the_tire(tmp_path, monkeypatch, bench):
    monkeypatch.chdir(tmp_path)
    (tmp_path / NAME).mkdir()
    assert len(tirefmu.evaluate(NAME, bench)) == len(bench)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.assign(Fy="x"), "row 1: column Fy: 'x' is not a number"),
        (lambda t: t.assign(alpha=np.nan), "row 1: alpha is NaN"),
        (lambda t: t[:0], "no rows"),
        (lambda t: pd.concat([t, t["Fy"]], axis=1), "column 'Fy' occurs 2 times"),
        (lambda t: t.assign(alpha=np.degrees(t["alpha"])), "in degrees"),
    ],
    ids=["text", "NaN", "empty", "twice", "degrees"],
)
def test_a_table_in_memory_is_checked_like_a_file(bench, change, message):
    with pytest.raises(DataError, match=message):
        fit(change(bench.table))


def test_numbers_of_any_kind_are_numbers(bench):
    table = bench.table.assign(Fz=bench.table["Fz"].round().astype("Int64"), Fy=bench.table["Fy"].astype(object))
    assert recording_from(table).table.dtypes.eq(np.float64).all()
    odd = table.set_index(np.arange(len(table))[::-1])
    assert list(recording_from(odd).table.index) == list(range(len(table)))


@pytest.mark.parametrize("version", [2, 3])
def test_a_version_of_fmi_is_a_number_or_a_text(version):
    for given in (version, float(version), str(version), f"{version}.0"):
        assert fmi_version(given) == version
    for given in (1, 2.5, "4", "", "two", float("nan")):
        with pytest.raises(FmuError, match="is not supported: supported are 2 and 3"):
            fmi_version(given)
    for given in ([3], True):
        with pytest.raises(WrongType, match=r"^fmi is "):
            tirefmu.export(NAME, "x.fmu", fmi=given)


def test_paths_are_refused_by_name(bench):
    for function, parameter in (
        (tirefmu.load, "path"), (tirefmu.read_recording, "path"), (lambda p: tirefmu.export(NAME, p), "path"),
        (tirefmu.published(NAME).save, "path"), (lambda p: tirefmu.check(p, bench), "fmu_path"),
        (lambda p: tirefmu.draw(NAME, p), "folder"),
    ):  # fmt: skip
        for wrong in (None, 3, ["tire.tir"]):
            with pytest.raises(WrongType, match=f"^{parameter} is .* it has to be a str or a Path$"):
                function(wrong)


def test_an_unknown_value_of_any_type_is_one_sentence(bench):
    for wrong in (3, ["iso"], 1.5):
        for function in (
            lambda w: tirefmu.evaluate(NAME, bench.table, signs=w), lambda w: fit(bench, w),
            lambda w: fit(bench.table, signs=w), lambda w: tirefmu.Tire(w, {}), tirefmu.published,
            lambda w: tirefmu.published(NAME).plot(signs=w),
        ):  # fmt: skip
            with pytest.raises(TirefmuError, match=r"^unknown "):
                function(wrong)


def test_a_single_text_is_not_a_list_of_names(bench_csv):
    size = {"FNOMIN": 1000.0, "UNLOADED_RADIUS": 0.3}
    for call in (
        lambda: tirefmu.Tire("mf96", size, effects="plysteer"),
        lambda: tirefmu.fit(bench_csv, "mf96", effects="plysteer"),
        lambda: tirefmu.diagnose(bench_csv, effects="plysteer"),
    ):
        with pytest.raises(WrongType, match=r"^effects is 'plysteer' .* such as \['plysteer'\]$"):
            call()
