"""Memory and CPU time of commands over a Parquet table of many rows.

`tirefmu evaluate` and `tirefmu check` of the published MF96 tire, each in a process of its own. The peak is the larger
one of the command's process and of those that it starts (reader, FMU); their sum is smaller than twice the peak.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tirefmu.fmu import export
from tirefmu.measurements.files.writing import write_tables
from tirefmu.tires import published

#: Rows that are written at a time.
PART = 250_000
#: Runs a command line in a process of its own and prints peak memory, kB, and CPU time, s, with those of its children.
MEASURED = """
import json, os, resource, sys
from tirefmu.commands.cli import main
status = main(sys.argv[1:])
from tirefmu.measurements.files import native_reader
native_reader.close()
peaks = [resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
print(json.dumps({"status": status, "own MB": peaks[0] / 1024, "children MB": peaks[1] / 1024,
                  "seconds": sum(os.times()[:4])}))
"""


def sweeps(rows: int) -> Iterator[pd.DataFrame]:
    """Yield a recording part by part: sweeps of slip angle at 100 Hz with the tire's side force."""
    tire, random = published("trento_hoosier").in_signs("iso"), np.random.default_rng(0)
    for start in range(0, rows, PART):
        t = np.arange(start, min(start + PART, rows)) / 100.0
        table = pd.DataFrame({
            "t": t, "alpha": 0.2 * np.sin(t), "kappa": 0.05 * np.sin(0.3 * t), "gamma": 0.03 * np.sin(0.01 * t),
            "Fz": 700.0 + 300.0 * np.sin(0.05 * t),
        })  # fmt: skip
        forces = tire.forces(**{name: table[name].to_numpy() for name in tire.inputs if name in table})
        yield table.assign(Fy=forces["Fy"] + random.normal(0.0, 20.0, len(t)))


def measured(arguments: list[str], folder: Path) -> dict[str, float]:
    """Return peak memory and CPU time of a command line."""
    command = [sys.executable, "-c", MEASURED, *arguments, "--quiet"]
    done = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    if found.pop("status") != 0:  # the tire is usable
        raise SystemExit(f"{' '.join(arguments)}: {done.stdout}{done.stderr}")
    return {**found, "peak MB": max(found["own MB"], found["children MB"])}


def streaming_runs(numbers: Sequence[int]) -> list[dict[str, Any]]:
    """Return command, rows, peak memory and CPU time of each command and number of rows."""
    runs = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        published("trento_hoosier").save(folder / "tire.tir")
        export(published("trento_hoosier"), folder / "tire.fmu")
        for rows in numbers:
            write_tables(sweeps(rows), folder / "in.parquet")
            for arguments in (["evaluate", "tire.tir", "in.parquet", "-o", "out.parquet"],
                              ["check", "tire.fmu", "in.parquet"]):  # fmt: skip
                runs.append({"command": f"`tirefmu {arguments[0]}`", "rows": rows, **measured(arguments, folder)})
    return runs
