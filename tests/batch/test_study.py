"""Studies: many simulations of an FMU equal the evaluation of tires with the same values."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu import study
from tirefmu.applications.batch import read_study
from tirefmu.boundary.errors import TirefmuError
from tirefmu.commands.cli import main
from tirefmu.fmu import export
from tirefmu.tires import published


@pytest.fixture(scope="module")
def tire():
    return published("trento_hoosier").in_signs("iso")


@pytest.fixture(scope="module")
def fmu(tire, tmp_path_factory):
    return export(tire, tmp_path_factory.mktemp("fmu") / "tire.fmu")


@pytest.fixture(scope="module")
def manoeuvre():
    t = np.arange(200) / 100.0
    return pd.DataFrame({"t": t, "alpha": 0.1 * np.sin(3.0 * t), "Fz": 600.0 + 300.0 * np.sin(t)})


STUDY = """
tables = ["steer.csv"]
outputs = ["Fy", "Mz"]
series = true
[parameters]
LMUY = {from = 0.5, to = 1.0, count = 3}
LKY = [0.8, 1.2]
"""


@pytest.fixture(scope="module")
def folder(manoeuvre, tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    manoeuvre.to_csv(folder / "steer.csv", index=False)
    (folder / "study.toml").write_text(STUDY)
    return folder


def test_each_run_is_the_tire_with_its_values(tire, fmu, folder, manoeuvre, tmp_path, monkeypatch):
    monkeypatch.setattr("tirefmu.applications.batch.study.ROWS_OF_TASK", 4 * len(manoeuvre))  # two tasks
    counts = []
    table = study(fmu, folder / "study.toml", tmp_path, workers=1, progress=lambda *report: counts.append(report))
    assert counts == [(4, 6), (6, 6)]
    assert table["run"].tolist() == list(range(6))
    assert (table["reason"] == "").all()
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "study.parquet"), table)
    series = pd.concat([pd.read_parquet(path) for path in sorted(tmp_path.glob("series-*.parquet"))])
    for _, row in table.iterrows():
        other = replace(tire, values={**tire.values, "LMUY": row["LMUY"], "LKY": row["LKY"]})
        expected = other.evaluate(manoeuvre, hold=True)
        rows = series[series["run"] == row["run"]]
        for name in ("Fy", "Mz"):
            size = expected[name].abs().max()
            np.testing.assert_allclose(rows[name], expected[name], atol=1e-9 * size)
            assert row[f"{name}_max"] == pytest.approx(expected[name].max(), abs=1e-9 * size)
            assert row[f"{name}_end"] == pytest.approx(expected[name].iloc[-1], abs=1e-9 * size)


def test_samples_fill_the_ranges_evenly(tmp_path):
    ranges = "[parameters]\nLMUY = {from = 0.5, to = 1.5}\nLKY = {from = 0, to = 1}\n"
    (tmp_path / "study.toml").write_text(f'tables = ["a.csv"]\nsamples = 50\nseed = 3\n{ranges}')
    values = pd.DataFrame(read_study(tmp_path / "study.toml").values)
    for name, lower in (("LMUY", 0.5), ("LKY", 0.0)):
        counts, _ = np.histogram(values[name], np.linspace(lower, lower + 1.0, 51))
        assert (counts == 1).all()
    assert abs(values.corr().iloc[0, 1]) < 0.5
    assert read_study(tmp_path / "study.toml").values == read_study(tmp_path / "study.toml").values


@pytest.mark.parametrize(("text", "message"), [
    ("[parameters]\nLMUY = [1]", "tables is missing"),
    (STUDY.replace("LMUY", "LMUZ"), "unknown parameter of tire.fmu 'LMUZ': did you mean"),
    (STUDY.replace('"Mz"', '"Mq"'), "unknown output of tire.fmu 'Mq'"),
    (STUDY.replace("[0.8, 1.2]", "0.8"), "expected a list of one or more numbers or a table"),
    (STUDY.replace("count = 3", "count = 0"), "count is 0: expected a whole number of at least 1"),
    (STUDY.replace("count = 3", "count = 900000"), "1800000 runs, not 1 to"),
    (STUDY.replace("from = 0.5, ", ""), "from is missing in parameters.LMUY"),
    (STUDY.replace("from = 0.5", "from = nan"), "from is nan: expected a number"),
    (STUDY.replace("steer", "other"), "other.csv: no such file"),
])  # fmt: skip
def test_an_invalid_study_is_one_line(fmu, folder, tmp_path, text, message):
    (folder / "wrong.toml").write_text(text)
    with pytest.raises(TirefmuError, match=message):
        study(fmu, folder / "wrong.toml", tmp_path / "out", workers=1)
    assert not (tmp_path / "out").exists()


def test_a_run_that_fails_is_a_row_with_its_reason(fmu, folder, tmp_path, capsys):
    (folder / "wrong.toml").write_text(STUDY.replace("series = true", "").replace("[0.8, 1.2]", "[1.0, 1e200]"))
    output = ["-o", str(tmp_path), "--json", str(tmp_path / "study.json"), "--workers", "1"]
    assert main(["study", str(fmu), str(folder / "wrong.toml"), *output]) == 1
    assert json.loads((tmp_path / "study.json").read_text()) == {"ok": False, "runs": 6, "failed": 3}
    table = pd.read_parquet(tmp_path / "study.parquet")
    assert table.loc[table["reason"] != "", "LKY"].tolist() == [1e200] * 3
    assert table.loc[table["reason"] == "", "Fy_max"].notna().all()
    captured = capsys.readouterr()
    assert captured.out.startswith("6 runs, 3 failed")
    assert "simulating: 6 of 6, " in captured.err
