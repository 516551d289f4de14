"""Long work: a command reports its lines and its end, can be stopped, and ends with the window."""

from __future__ import annotations

import asyncio
import subprocess
import sys

import pytest

from tirefmu.applications.studio import Work
from tirefmu.boundary.errors import TirefmuError


def test_a_command_reports_its_end_and_can_be_stopped(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    events = []

    async def report(event):
        events.append(event)

    async def until(kind, count):
        while sum(event["event"] == kind for event in events) < count:
            await asyncio.sleep(0.02)

    async def run():
        work = Work(report)
        try:
            await work.start("wrong", ["info", "missing.tir"], tmp_path / "stage.tir")
            with pytest.raises(TirefmuError, match="wrong is running"):
                await work.start("second", ["info", "missing.tir"], tmp_path / "stage.tir")
            await until("ended", 1)
            assert not work.running
            await work.start("long", ["example", "-o", "run.csv", "--sample-rate", "1000"], tmp_path / "stage.tir")
            await work.stop()
            await until("ended", 2)
            assert not work.running
        finally:
            await work.close()

    asyncio.run(asyncio.wait_for(run(), 120))
    first, second = (event for event in events if event["event"] == "ended")
    assert (first["status"], first["message"]) == (2, "missing.tir: no such file")
    assert second["message"] == "stopped"
    assert not (tmp_path / "run.csv").exists()


def test_a_waiting_process_ends_with_the_window(tmp_path):
    line = [sys.executable, "-P", "-m", "tirefmu.applications.studio.worker"]
    found = subprocess.run(line, cwd=tmp_path, stdin=subprocess.DEVNULL, capture_output=True, timeout=120, check=False)
    assert (found.returncode, found.stdout, found.stderr) == (0, b"", b"")
