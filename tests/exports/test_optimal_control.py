"""The example of an optimal control problem through standstill."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "examples" / "optimal_control.py"


@pytest.mark.slow
def test_the_way_is_close_to_the_bound_of_largest_friction():
    run = subprocess.run([sys.executable, str(EXAMPLE)], capture_output=True, text=True, timeout=300, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "of the bound" in run.stdout
