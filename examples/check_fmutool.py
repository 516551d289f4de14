"""Check of a tire FMU with the FMU Manipulation Toolbox: python check_fmutool.py [2|3]."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import four_tires as four


def run(path: Path) -> int:
    """Run fmutool, which prints its messages, and return its exit code."""
    program = "import sys; from fmu_manipulation_toolbox.cli.fmutool import fmutool; sys.exit(fmutool())"
    command = [sys.executable, "-c", program, "-input", str(path), "-check"]
    return subprocess.run(command, check=False).returncode


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        sys.exit(run(four.export(Path(name), four.requested_version())))
