"""Bootstrap of a fit on several processes and on a cluster, and from the command line."""

from __future__ import annotations

import json

import pytest

from tirefmu import bootstrap
from tirefmu.commands.cli import main
from tirefmu.fitting import fit
from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps, read_recording, write_table
from tirefmu.tires import published

EFFECTS = ["load_friction", "load_stiffness", "load_curvature", "plysteer", "conicity"]
OPTIONS = {"effects": EFFECTS, "recipe": "joint", "nominal": {"Fz0": 700.0, "R0": 0.23}}


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """Return the file of a recording of ten sweeps."""
    program = alpha_sweeps([220.0, 400.0, 700.0, 900.0, 1120.0] * 2, sample_rate=6.0)
    recorded = VirtualBench(published("trento_hoosier"), Noise(), seed=3).run(program).with_signs("iso").table
    path = tmp_path_factory.mktemp("bench") / "bench.csv"
    write_table(recorded[["t", "alpha", "Fz", "Fy"]], path)
    return path


@pytest.mark.slow
def test_the_intervals_are_those_of_any_number_and_kind_of_workers(table, cluster, kill_once):
    recording = read_recording(table)
    result = fit(recording, "mf96", **OPTIONS)
    seen = []
    local = bootstrap(result, recording, 40, seed=2, workers=1, progress=lambda *report: seen.append(report))
    assert seen == [(10, 40), (20, 40), (30, 40), (40, 40)]
    other = bootstrap(result, recording, 40, seed=2, scheduler=cluster.scheduler_address, progress=kill_once)
    assert local.bootstrap == other.bootstrap


@pytest.mark.slow
def test_the_command_shows_the_intervals_next_to_the_linear_ones(table, tmp_path, capsys):
    status = main([
        "fit", str(table), "--model", "mf96", "--effects", ",".join(EFFECTS), "--recipe", "joint", "--nominal",
        "Fz0=700,R0=0.23", "-o", str(tmp_path / "a.tir"), "--bootstrap", "40", "--workers", "1", "--all",
        "--json", str(tmp_path / "a.json"), "--report", str(tmp_path / "a.html"),
    ])  # fmt: skip
    out = capsys.readouterr().out
    assert status == 0, out
    assert "bootstrap: percentiles 2.5 and 97.5 of 40 fits with random weights of 10 sweeps, expanded for" in out
    plain = json.loads((tmp_path / "a.json").read_text())
    linear = {coefficient["name"]: coefficient for coefficient in plain["coefficients"]}["PDY1"]
    percentiles = {interval["name"]: interval for interval in plain["bootstrap"]["intervals"]}["PDY1"]
    assert percentiles["lower"] < linear["value"] < percentiles["upper"]
    shown = f"{percentiles['lower']:.5g} to {percentiles['upper']:.5g}"
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert shown in out
    assert shown in page
