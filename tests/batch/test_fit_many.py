"""Fits of many tires: the same tires as one by one, failing tires as rows, resuming."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pandas as pd
import pytest

from tirefmu import fit_many
from tirefmu.applications.batch import Batch, FitJob, JobResult, read_jobs, run, task_of
from tirefmu.boundary.errors import TirefmuError
from tirefmu.commands.cli import main
from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps, write_table
from tirefmu.tires import published

JOBS = """
[defaults]
model = "mf96"
effects = ["load_friction"]
recipe = "joint"
iterations = 3
nominal = {Fz0 = 700, R0 = 0.23}

[[jobs]]
name = "front"
tables = ["bench.csv"]

[[jobs]]
name = "rear"
tables = ["bench.csv", "other.csv"]

[[jobs]]
name = "broken"
tables = ["missing.csv"]

[[jobs]]
name = "odd"
tables = ["bench.csv"]
effects = ["no_such_effect"]
"""


@pytest.fixture(scope="module")
def jobs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("jobs")
    program = alpha_sweeps([220.0, 700.0, 1120.0], sample_rate=2.0)
    for seed, name in ((3, "bench"), (4, "other")):
        table = VirtualBench(published("trento_hoosier"), Noise(), seed=seed).run(program).with_signs("iso").table
        write_table(table[["alpha", "Fz", "Fy"]], folder / f"{name}.csv")
    (folder / "jobs.toml").write_text(JOBS)
    return folder / "jobs.toml"


@pytest.fixture(scope="module")
def batch(jobs, tmp_path_factory):
    seen = []
    found = fit_many(jobs, tmp_path_factory.mktemp("out"), workers=1, progress=lambda *report: seen.append(report))
    assert [(finished, of) for _, finished, of in seen] == [(1, 4), (2, 4), (3, 4), (4, 4)]
    return found


@pytest.mark.slow
def test_the_tires_are_those_of_single_fits(jobs, batch):
    """In another process: this one compiles without optimization, which changes the last digits."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as other:
        single = other.submit(run, task_of(read_jobs(jobs)[0])).result()
    assert single.files == {"front.tir": (batch.folder / "front.tir").read_bytes()}


def test_a_tire_that_cannot_be_fitted_is_a_row_with_its_reason(batch):
    assert [result.name for result in batch.results] == ["front", "rear", "broken", "odd"]
    front, _, broken, odd = batch.results
    assert front.channels["Fy"]["r2"] > 0.9
    assert broken.status == odd.status == "failed"
    assert "missing.csv: no such file" in broken.reasons[0]
    assert "no_such_effect" in odd.reasons[0]
    table = pd.read_csv(batch.folder / "summary.csv")
    assert table["name"].tolist() == ["front", "rear", "broken", "odd"]
    assert table["PDY1"].notna().tolist() == [True, True, False, False]
    assert "missing.csv" in (batch.folder / "summary.html").read_text(encoding="utf-8")
    assert not list(batch.folder.glob("broken.tir"))


def test_resuming_computes_only_what_is_missing_lost_or_changed(jobs, batch):
    assert fit_many(jobs, batch.folder, resume=True, progress=lambda *_: pytest.fail("computed again")).results
    (batch.folder / "front.json").unlink()
    lost = json.loads((batch.folder / "odd.json").read_text(encoding="utf-8"))
    lost["result"]["status"] = "lost"
    (batch.folder / "odd.json").write_text(json.dumps(lost), encoding="utf-8")
    again = []
    resumed = fit_many(
        jobs, batch.folder, workers=1, resume=True, progress=lambda result, *_: again.append(result.name)
    )
    assert sorted(again) == ["front", "odd"]
    assert [(result.name, result.status, result.values) for result in resumed.results] == [
        (result.name, result.status, result.values) for result in batch.results
    ]
    other = jobs.with_name("other.csv")
    unchanged = other.read_bytes()
    try:
        other.write_bytes(unchanged[: unchanged.rstrip().rindex(b"\n") + 1])
        fit_many(jobs, batch.folder, workers=1, resume=True, progress=lambda result, *_: again.append(result.name))
        assert sorted(again) == ["front", "odd", "rear"]
    finally:
        other.write_bytes(unchanged)


@pytest.mark.slow
def test_a_cluster_gives_the_same_tires(jobs, batch, cluster, tmp_path):
    fit_many(jobs, tmp_path, scheduler=cluster.scheduler_address)
    assert (tmp_path / "front.tir").read_bytes() == (batch.folder / "front.tir").read_bytes()


def test_the_command_reports_each_tire(jobs, tmp_path, capsys):
    """With two jobs that fail at once: no fit."""
    short = tmp_path / "jobs.toml"
    short.write_text(
        JOBS[JOBS.index("[defaults]") : JOBS.index("[[jobs]]")] + JOBS[JOBS.index('[[jobs]]\nname = "broken') :]
    )
    assert (
        main(
            ["fit-many", str(short), "-o", str(tmp_path / "out"), "--workers", "1", "--json", str(tmp_path / "o.json")]
        )
        == 1
    )
    out = capsys.readouterr().out
    assert "broken: failed:" in out
    assert "0 of 2 tires are usable" in out
    assert not json.loads((tmp_path / "o.json").read_text())["ok"]


def test_the_summary_rates_tires_and_begins_with_the_worst(tmp_path):
    words = ("good", "usable with limits", "failed")
    Batch(tuple(JobResult(word[:4], word) for word in words), tmp_path).write_summary()
    page = (tmp_path / "summary.html").read_text(encoding="utf-8")
    assert '<p class="verdict bad">1 failed; 1 good; 1 usable with limits</p>' in page
    for word, rating in zip(words, ("good", "limited", "bad"), strict=True):
        assert f'<td class="{rating}">{word}</td>' in page
    Batch((JobResult("front", "good"),), tmp_path).write_summary()
    assert '<p class="verdict good">1 good</p>' in (tmp_path / "summary.html").read_text(encoding="utf-8")


def test_names_that_are_no_file_names_are_refused(tmp_path):
    for name in ("../front", "", "a/b"):
        with pytest.raises(TirefmuError, match="is not a file name"):
            fit_many([FitJob(name, (tmp_path / "a.csv",))], tmp_path / "out")
    with pytest.raises(TirefmuError, match=r"options of jobs are in FitJob\.options: model"):
        fit_many([FitJob("front", (tmp_path / "a.csv",))], tmp_path / "out", model="mf61")
    assert not (tmp_path / "out").exists()


#: `fit-many`, whose process group gets SIGINT when the first result is printed, before the next one can be.
INTERRUPTED = """
import os, signal, sys
from tirefmu.commands.cli import main
from tirefmu.commands.terminal import Terminal

signal.signal(signal.SIGINT, getattr(signal, sys.argv.pop(1)))
print_line, sent = Terminal.print, []

def interrupting(*line):
    print_line(*line)
    if not sent:
        sent.append(signal.SIGINT)
        os.killpg(os.getpgrp(), signal.SIGINT)

Terminal.print = interrupting
sys.exit(main(sys.argv[1:]))
"""


def _interrupted(jobs, folder, handler):
    """Run a batch with a handler of SIGINT.

    The signal goes to all processes, as from a keyboard; shells start background processes with SIGINT ignored.
    """
    command = [sys.executable, "-c", INTERRUPTED, handler, "fit-many", str(jobs), "-o", str(folder), "--workers", "1"]
    return subprocess.run(command, capture_output=True, text=True, start_new_session=True, check=False)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="no process groups with SIGINT")
def test_a_batch_in_the_background_is_not_interrupted(jobs, tmp_path):
    _interrupted(jobs, tmp_path, "SIG_IGN")
    assert pd.read_csv(tmp_path / "summary.csv")["status"].tolist().count("failed") == 2  # as without the signal


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="no process groups with SIGINT")
def test_an_interrupted_batch_keeps_what_is_written(jobs, tmp_path):
    """Nothing is printed but one line."""
    done = _interrupted(jobs, tmp_path, "default_int_handler")
    assert (done.returncode, done.stderr.strip().splitlines()[-1:]) == (130, ["tirefmu: interrupted"])
    assert "Traceback" not in done.stderr
    (finished,) = pd.read_csv(tmp_path / "summary.csv")["name"]
    assert [path.stem for path in tmp_path.glob("*.json")] == [finished]
