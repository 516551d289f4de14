"""Ctrl-C during a fit: the best values so far are written, and --resume has the result of an uninterrupted fit."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time

import pytest

from tirefmu.commands import fit_command
from tirefmu.tires import read_tir

from .conftest import EFFECTS


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one process alone")
def test_a_process_that_gets_the_signal(chain, command, bench_csv, tmp_path):
    line = ["fit", str(bench_csv), "--model", "mf96", "--effects", EFFECTS, "--nominal", "Fz0=220,R0=0.23"]
    where = tmp_path / "tire.tir", tmp_path / "tire.json", tmp_path / "tire.html"
    positions = ["-o", where[0], "--json", where[1], "--report", where[2]]
    saved = tmp_path / "tire.progress.json"

    def listening():  # a shell ignores SIGINT in background processes
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    process = subprocess.Popen(
        [sys.executable, "-m", "tirefmu", *line, *map(str, positions)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=listening,
    )  # fmt: skip
    while not saved.exists() and process.poll() is None:
        time.sleep(0.001)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate()
    assert process.returncode == 1, err
    assert "fit interrupted in stage" in out
    assert f"{saved}; to continue: tirefmu fit " in " ".join(out.split())
    assert "Traceback" not in err
    reported = json.loads(where[1].read_text(encoding="utf-8"))
    assert reported["ok"] is False
    assert reported["values"] == dict(read_tir(where[0]).values)
    assert "interrupted in stage" in where[2].read_text(encoding="utf-8")

    resumed = command(*line, *positions[:-2], "--resume")  # without the report, which takes longer than the fit
    assert resumed.status == 0
    assert not saved.exists()
    ends = [json.loads(path.read_text(encoding="utf-8")) for path in (where[1], chain[0] / "fit.json")]
    assert {**ends[0], "seconds": 0.0} == {**ends[1], "seconds": 0.0}


def test_an_interrupt_before_all_results_are_written_is_resumed(command, bench_csv, tmp_path, monkeypatch):
    tire, result = tmp_path / "tire.tir", tmp_path / "tire.json"
    line = ["fit", bench_csv, "--model", "mf96", "--effects", "none", "-o", tire, "--json", result]

    def interrupted(*arguments):
        raise KeyboardInterrupt

    with monkeypatch.context() as changed:
        changed.setattr(fit_command, "write_json", interrupted)
        assert command(*line).status == 130
    assert tire.exists()
    assert not result.exists()
    resumed = command(*line, "--resume")
    assert resumed.status in (0, 1), resumed.err
    assert json.loads(result.read_text(encoding="utf-8"))["values"] == dict(read_tir(tire).values)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["tire.json", "tire.tir"]
