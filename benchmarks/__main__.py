"""``python -m benchmarks``: list the studies of ``studies.toml``; ``python -m benchmarks NAME`` runs one."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
INSTALL = (sys.executable, "-m", "pip", "install", "--quiet", "--no-build-isolation")
#: Those of a file on one processor, so that they share fixtures.
PYTEST_ARGS = "-n auto --dist loadfile"


def studies() -> dict[str, dict[str, Any]]:
    """Return the studies by name."""
    return tomllib.loads((ROOT / "benchmarks" / "studies.toml").read_text(encoding="utf-8"))


def command_of(line: str, arguments: Sequence[str], environment: Mapping[str, str]) -> list[str]:
    """Return the command of a line of a study."""
    program, *words = shlex.split(line)
    if "{data}" in line and not environment.get("TIREFMU_DATA"):
        raise SystemExit("TIREFMU_DATA is not set: measured recordings are not part of the project")
    words = [word.replace("{data}", environment.get("TIREFMU_DATA", "")) for word in words]
    if program == "pytest":
        words = ["-m", "pytest", *shlex.split(environment.get("PYTEST_ARGS", PYTEST_ARGS)), *words]
    return [sys.executable, *words, *arguments]


def run(study: Mapping[str, Any], arguments: Sequence[str]) -> int:
    """Install what a study needs and run its lines until one fails; return its exit code. Slow tests run."""
    installed = list(study.get("install", []))
    if "extras" in study:
        installed.append(f".[{','.join(study['extras'])}]")
    for package in installed:
        subprocess.run([*INSTALL, "--editable", package], cwd=ROOT, check=True)
    environment = {"OMP_NUM_THREADS": "1", **os.environ, **study.get("environment", {})}
    *lines, last = study["run"]
    for line, given in (*((line, ()) for line in lines), (last, arguments)):
        command, slow = command_of(line, given, environment), {"TIREFMU_SLOW": "1"} if line.startswith("pytest") else {}
        status = subprocess.run(command, cwd=ROOT, env=environment | slow, check=False).returncode
        if status:
            return status
    return 0


def main() -> int:
    """List the studies, or run one."""
    table, (name, *arguments) = studies(), sys.argv[1:] or [""]
    if name in table:
        return run(table[name], arguments)
    if name:
        near = get_close_matches(name, table, n=1)
        print(f"no study {name!r}" + (f": did you mean {near[0]}?" if near else ""), file=sys.stderr)
        return 2
    for known, study in table.items():
        print(f"{known:16} {study['about']}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
