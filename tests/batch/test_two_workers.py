"""Two workers, one of which is killed midway: studies, cross-validation and diagnoses are those of one process."""

from __future__ import annotations

import json
import os

import numpy as np
import pandas as pd
import pytest

from tirefmu import diagnose_many, study
from tirefmu.applications.batch import cross_validate
from tirefmu.fitting import cross_validate as in_this_process
from tirefmu.fmu import export
from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps
from tirefmu.tires import Tire, published

TIRE = Tire("fiala", {"FNOMIN": 1000.0, "UNLOADED_RADIUS": 0.25, "CALPHA": 15000.0, "UMAX": 1.2, "UMIN": 1.0})


@pytest.mark.slow
def test_a_study_is_that_of_one_process(cluster, kill_once, tmp_path, monkeypatch):
    t = np.arange(400) / 100.0
    steer = pd.DataFrame({"t": t, "alpha": 0.1 * np.sin(3.0 * t), "Fz": 900.0 + 300.0 * np.sin(t)})
    steer.to_csv(tmp_path / "steer.csv", index=False)
    values = "[parameters]\nUMAX = {from = 0.6, to = 1.2, count = 4}\n"
    (tmp_path / "study.toml").write_text(f'tables = ["steer.csv"]\nseries = true\n{values}')
    fmu = export(TIRE, tmp_path / "tire.fmu")
    monkeypatch.setattr("tirefmu.applications.batch.study.ROWS_OF_TASK", len(steer))  # a run in each task
    study(fmu, tmp_path / "study.toml", tmp_path / "one", workers=1)
    study(fmu, tmp_path / "study.toml", tmp_path / "two", scheduler=cluster.scheduler_address, progress=kill_once)
    files = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert len(files) == 5
    for name in files:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes(), name


@pytest.mark.slow
def test_cross_validation_is_that_of_one_process(cluster, kill_once):
    bench = VirtualBench(published("trento_hoosier"), Noise(), seed=3)
    recording = bench.run(alpha_sweeps([220.0, 400.0, 700.0, 900.0, 1120.0], sample_rate=6.0))
    options = {"effects": ["load_friction", "load_stiffness"], "recipe": "joint", "folds": 5}
    alone = in_this_process(recording, "mf96", **options)
    assert alone[0].held_out > 0.0
    assert (
        cross_validate(recording, "mf96", scheduler=cluster.scheduler_address, progress=kill_once, **options) == alone
    )


@pytest.mark.skipif("TIREFMU_WORKERS" not in os.environ, reason="set by make workers: it takes half a minute")
def test_diagnoses_with_their_fmus_are_those_of_one_process(cluster, kill_once, tmp_path):
    t = 0.05 * np.arange(800)
    bench = pd.DataFrame({"t": t, "alpha": 0.15 * np.sin(t), "Fz": np.repeat([900.0, 1200.0, 1500.0, 1800.0], 200)})
    side_force = TIRE.forces(alpha=bench["alpha"].to_numpy(), Fz=bench["Fz"].to_numpy())["Fy"]
    for run in range(2):
        bench["Fy"] = side_force + np.random.default_rng(run).normal(0.0, 5.0, len(bench))
        bench.to_csv(tmp_path / f"run{run}.csv", index=False)
    tables = [tmp_path / "run0.csv", tmp_path / "run1.csv"]
    options = {"tire": TIRE, "candidates": ["wear_drift"]}
    diagnose_many(tables, tmp_path / "one", workers=1, **options)
    results = diagnose_many(
        tables, tmp_path / "two", scheduler=cluster.scheduler_address, progress=kill_once, **options
    )
    assert [result.status for result in results] == ["diagnosed", "diagnosed"]
    for run in ("run0", "run1"):
        for name in ("base.tir", "improved.tir", "base.fmu", "improved.fmu"):
            first, second = (tmp_path / folder / run / name for folder in ("one", "two"))
            assert first.read_bytes() == second.read_bytes(), name
        first, second = (
            json.loads((tmp_path / folder / run / "diagnosis.json").read_text()) for folder in ("one", "two")
        )
        assert first.pop("seconds") > 0.0
        assert second.pop("seconds") > 0.0
        assert first == second
