"""Diagnoses of many recordings: a folder for each, failing recordings as rows, resuming."""

from __future__ import annotations

import json
import shutil

import pandas as pd
import pytest

from tirefmu import diagnose_many
from tirefmu.boundary.errors import TirefmuError
from tirefmu.commands.cli import main
from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps, write_table
from tirefmu.tires import published

#: The same in Python and on the command line.
OPTIONS = {
    "model": "mf96", "effects": ["load_friction", "load_stiffness"], "nominal": {"Fz0": 700.0, "R0": 0.23},
    "candidates": ["conicity"], "fmus": False,
}  # fmt: skip


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """Return a folder with a recording, and one without a measured output."""
    folder = tmp_path_factory.mktemp("recordings")
    program = alpha_sweeps([220.0, 700.0, 1120.0], sample_rate=10.0)
    bench = VirtualBench(published("trento_hoosier"), Noise(), seed=3)
    table = bench.run(program).with_signs("iso").table[["t", "alpha", "Fz", "Fy"]]
    write_table(table, folder / "run7.csv")
    write_table(table.drop(columns="Fy"), folder / "run8.csv")
    return folder


@pytest.fixture(scope="module")
def diagnosed(recordings, tmp_path_factory):
    folder = tmp_path_factory.mktemp("out")
    status = main([
        "diagnose", str(recordings), "--model", "mf96", "--effects", "load_friction,load_stiffness", "--nominal",
        "Fz0=700,R0=0.23", "--candidates", "conicity", "--no-fmu", "--quiet", "--workers", "1", "-o", str(folder),
        "--json", str(folder / "all.json"),
    ])  # fmt: skip
    assert status == 1
    return folder


@pytest.mark.slow
def test_each_recording_has_a_folder_and_a_row(diagnosed):
    table = pd.read_csv(diagnosed / "summary.csv").set_index("name")
    assert table["status"].to_dict() == {"run7": "diagnosed", "run8": "failed"}
    assert "no measured output" in table.loc["run8", "reasons"]
    content = json.loads((diagnosed / "run7" / "diagnosis.json").read_text(encoding="utf-8"))
    assert content["verdict"] == table.loc["run7", "verdict"]
    assert table.loc["run7", "Fy_after"] == pytest.approx(content["gap"]["holdout"]["Fy"]["after"])
    for name in ("report.html", "improved.tir", "base.tir"):
        assert (diagnosed / "run7" / name).is_file()
    assert not (diagnosed / "run8").exists()
    page = (diagnosed / "summary.html").read_text(encoding="utf-8")
    assert "run7/report.html" in page
    assert "no measured output" in page
    assert not json.loads((diagnosed / "all.json").read_text(encoding="utf-8"))["ok"]


@pytest.mark.slow
def test_resuming_computes_only_what_is_missing_or_changed(recordings, diagnosed, tmp_path):
    options = {**OPTIONS, "resume": True, "workers": 1, "time_limit": 300.0, "form": True}  # defaults of the command
    kept = diagnose_many(recordings, diagnosed, progress=lambda *_: pytest.fail("computed again"), **options)
    assert [result.status for result in kept] == ["diagnosed", "failed"]
    copy = tmp_path / "out"
    shutil.copytree(diagnosed, copy)
    (copy / "run8.json").unlink()
    again = []
    diagnose_many(recordings, copy, progress=lambda result, *_: again.append(result.name), **options)
    assert again == ["run8"]


def test_what_cannot_be_diagnosed_together_is_refused(recordings, tmp_path):
    with pytest.raises(TirefmuError, match="two jobs have the name 'run7'"):
        diagnose_many([recordings / "run7.csv", recordings], tmp_path / "out", tire="trento_hoosier")
    with pytest.raises(TirefmuError, match="no recording"):
        diagnose_many(tmp_path, tmp_path / "out", tire="trento_hoosier")
    assert not (tmp_path / "out").exists()
