"""``--where`` selects the same rows in every command that reads tables."""

from __future__ import annotations

import json

import pandas as pd
import pytest

WHERE = "Fz in 700 +- 100 N and gamma in 0 +- 0.5 deg"


@pytest.fixture(scope="module")
def chosen(bench_csv):
    table = pd.read_csv(bench_csv)
    return int(((table["Fz"] - 700.0).abs().le(100.0) & table["gamma"].abs().le(0.0087266)).sum())


def test_evaluate(command, published_tir, bench_csv, tmp_path, chosen):
    outcome = command("evaluate", published_tir, bench_csv, "--where", WHERE, "-o", tmp_path / "out.csv")
    assert outcome.status == 0, outcome.err
    assert outcome.out.startswith(f"{bench_csv.name}: {chosen} of ")
    assert len(pd.read_csv(tmp_path / "out.csv")) == chosen


def test_check(command, published_fmu, bench_csv, tmp_path, chosen):
    path = tmp_path / "check.json"
    outcome = command("check", published_fmu, bench_csv, "--where", WHERE, "--json", path)
    assert outcome.status == 0, outcome.err
    assert f"{chosen} of " in outcome.out


def test_fit_by_a_file(command, bench_csv, tmp_path, chosen):
    (tmp_path / "crop.where").write_text(WHERE, encoding="utf-8")
    outcome = command(
        "fit", bench_csv, "--where", tmp_path / "crop.where", "--model", "mf96", "--effects", "none", "--rows", "equal",
        "-o", tmp_path / "t.tir", "--json", tmp_path / "fit.json",
    )  # fmt: skip
    assert outcome.status in (0, 1), outcome.err
    fitted = json.loads((tmp_path / "fit.json").read_text(encoding="utf-8"))
    assert {channel["rows"] for channel in fitted["channels"]} == {chosen}
