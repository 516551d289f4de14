"""CPU time of short commands, and of the first fit and diagnosis of a process beyond the second ones.

Each command runs in a process of its own; the result is the median of the runs. The cache of compiled code is warm
except for "cold". A fit or a diagnosis is repeated in its process: what the first one needs beyond the second one is
start-up.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps, concatenate, kappa_sweeps, write_table
from tirefmu.tires import published

TIREFMU = (sys.executable, "-m", "tirefmu")
#: Arguments in a folder with bench.csv, table.csv and tire.tir.
COMMANDS: dict[str, tuple[str, ...]] = {
    "import tirefmu": (sys.executable, "-c", "import tirefmu"),
    "--help": (*TIREFMU, "--help"),
    "usage error": (*TIREFMU, "inof"),
    "missing file": (*TIREFMU, "info", "missing.tir"),
    "info": (*TIREFMU, "info", "tire.tir"),
    "evaluate, 1000 rows": (*TIREFMU, "evaluate", "tire.tir", "table.csv", "-o", "out.csv"),
    "export": (*TIREFMU, "export", "tire.tir", "-o", "out.fmu"),
}
#: Prints the CPU time of the process after the first and after the second run.
TWICE = """
import os
def work():
    WORK
def cpu():
    return sum(os.times()[:4])
work(); first = cpu(); work(); print(first, cpu())
"""
FIT = (
    "import tirefmu; tirefmu.fit('bench.csv', 'mf61', nominal=dict(Fz0=1000.0, R0=0.25), recipe='joint', iterations=5)"
)
DIAGNOSE = "import tirefmu; tirefmu.diagnose('bench.csv', tire='tire.tir', candidates=['wear_drift'])"
#: Work that is done twice in a process, and whether the cache of compiled code is empty.
REPEATED = {
    "first fit beyond the second": (FIT, False),
    "first diagnosis beyond the second": (DIAGNOSE, False),
    "first diagnosis beyond the second, cold": (DIAGNOSE, True),
}


def prepare(folder: Path) -> None:
    """Write a tire and recordings of it."""
    tire = published("trento_hoosier").in_signs("iso")
    tire.save(folder / "tire.tir")
    rng = np.random.default_rng(0)
    inputs = {"kappa": rng.uniform(-0.2, 0.2, 1000), "alpha": rng.uniform(-0.2, 0.2, 1000), "Fz": 1000.0}
    pd.DataFrame(inputs).to_csv(folder / "table.csv", index=False)
    loads = (500.0, 1000.0, 1500.0)
    program = concatenate([alpha_sweeps(loads, [0.0]), kappa_sweeps(loads, [0.0], [0.0])])
    write_table(VirtualBench(tire, Noise(), seed=1).run(program).table, folder / "bench.csv")


def cpu_of(command: Sequence[str], folder: Path, environment: Mapping[str, str]) -> tuple[float, str]:
    """Return the CPU time of a process and its children, s, and its output."""
    before = os.times()
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    after = os.times()
    if done.returncode and "error" not in done.stderr[:20]:  # the two commands that fail on purpose print one line
        raise SystemExit(done.stderr)
    return after[2] + after[3] - before[2] - before[3], done.stdout


def beyond(work: str, folder: Path, environment: Mapping[str, str]) -> float:
    """Return the CPU time that work needs the first time in a process beyond the second time, s."""
    _, printed = cpu_of((sys.executable, "-c", TWICE.replace("WORK", work)), folder, environment)
    first, both = map(float, printed.split()[-2:])
    return first - (both - first)


def startup_times(runs: int, only: tuple[str, ...] = ("",)) -> dict[str, float]:
    """Return the median CPU time of each command and work, s, after one run that fills the caches.

    `only`: beginnings of names.
    """
    times: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        prepare(folder)
        for key in (*COMMANDS, *REPEATED):
            if not key.startswith(only):
                continue
            samples = []
            for run in range(runs + 1):
                cold = key in REPEATED and REPEATED[key][1]
                environment = {**os.environ, "TIREFMU_CACHE": str(folder / (f"cold {run}" if cold else "warm"))}
                samples.append(
                    cpu_of(COMMANDS[key], folder, environment)[0]
                    if key in COMMANDS
                    else beyond(REPEATED[key][0], folder, environment)
                )
            times[key] = statistics.median(samples[1:])
    return times
