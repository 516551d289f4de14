"""The script for accelerators, small and on the CPU: benchmarks/gpu.py."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from .conftest import tool

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "gpu.py"


@pytest.mark.slow
def test_every_library_that_is_installed_agrees_with_numpy(tmp_path):
    """The measurement reads the prepared folder only: it runs where nothing but NumPy and the libraries exist."""
    tool("cc")
    libraries = "casadi C,torch" + (",jax" if "TIREFMU_HOSTS" in os.environ else "")
    subprocess.run([sys.executable, SCRIPT, "--prepare", tmp_path / "code"], check=True)
    small = ["--points", "400", "--chunk", "200", "--libraries", libraries, "--json", tmp_path / "found.json"]
    subprocess.run([sys.executable, "-W", "ignore", SCRIPT, "--folder", tmp_path / "code", *small], check=True)
    results = json.loads((tmp_path / "found.json").read_text())
    assert {result["library"] for result in results} == set(libraries.split(","))
    for result in results:
        if "not run" not in result:
            assert result["largest difference"] < {"float64": 1e-12, "float32": 1e-5}[result["type"]], result
    first = results[0]
    assert first["library"] == "casadi C"
    assert "not run" not in first


def test_what_begins_too_late_is_named(tmp_path):
    done = subprocess.run(
        [sys.executable, SCRIPT, "--points", "200", "--chunk", "200", "--libraries", "casadi C", "--limit", "0"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "not run: after 0 s" in done.stdout
