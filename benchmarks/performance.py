"""The tables of docs/performance.md: start-up, fits and evaluation of one run, targets and earlier figures.

Runs the parts and replaces the tables between the marks of the page. CPU seconds
are also given for the reference machine, on which the C code that CasADi generates for the forces of MF6.1 (gcc -O2,
one thread, a million points) needs 386 ns a point: seconds on this machine times 386 ns over the time that this code
takes here.

    python benchmarks/performance.py [--parts startup,fit,evaluation] [--quick] [--write]
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from doc_tables import DOCS, put, table
from evaluation_times import CASADI, evaluation_times
from fit_times import compare, growth
from startup_times import startup_times
from threadpoolctl import threadpool_limits

from tirefmu.symbolic.models import model_named

PAGE = DOCS / "performance.md"
#: ns a point on the reference machine.
REFERENCE_NS = 386.0
MANY = 1_000_000
#: Load of the machine above which the page states that others were computing.
QUIET = 0.5
PARTS = ("startup", "fit", "evaluation")


@dataclass(frozen=True)
class Benchmark:
    """A figure with its target, its earlier value, and what limits it."""

    title: str
    before: str
    target: float
    limit: str = ""


#: By name in `startup_times.py`. Targets in CPU s of the reference machine.
STARTUP = {
    "--help": Benchmark("`tirefmu --help`", "2.1", 0.25),
    "usage error": Benchmark("a usage error", "2.1", 0.25),
    "missing file": Benchmark("a missing file", "2.1", 0.25),
    "import tirefmu": Benchmark("`import tirefmu`", "-", 0.15),
    "info": Benchmark("`tirefmu info TIRE`", "2.6", 0.6),
    "evaluate, 1000 rows": Benchmark(
        "`tirefmu evaluate`, 1,000 rows", "3", 0.8, "pandas and the structure of the model are loaded"
    ),
    "export": Benchmark("`tirefmu export`, warm", "6.7", 1.0, "the interpreter, NumPy and compressing the archive"),
    "first fit beyond the second": Benchmark(
        "first fit beyond the second one", "3-4", 1.0, "pandas, CasADi and SciPy are loaded"
    ),
    "first diagnosis beyond the second": Benchmark(
        "first diagnosis beyond the second one",
        "many",
        1.0,
        "pandas, SciPy and the modules of the diagnosis are loaded",
    ),
    "first diagnosis beyond the second, cold": Benchmark(
        "the same, cold cache", "many", 10.0, "gcc compiles the Jacobians of the model with the whole effect library"
    ),
}
#: The part of them that a short run measures: no diagnosis.
SHORT = ("--help", "usage", "missing", "import tirefmu", "info", "evaluate", "export", "first fit")
#: By candidate and number of points in `evaluation_times.py`. Targets relative to CasADi's C.
EVALUATION = {
    ("batch", MANY): Benchmark(
        "forces, 1e6 points", ".14-.16", 0.10,
        "arithmetic: 25 arctangents, 19 sines, cosines and tangents, 42 divisions a row; spilled registers",
    ),
    ("batch", 100): Benchmark("forces, 100 points through Python", "1.05-1.11", 0.40, "objects that a call makes"),
    ("batch, by inputs", MANY): Benchmark(
        "by inputs (6), 1e6 points", "1.25-1.99", 0.40, "the kernel .23, the transposition into 280 MB .05",
    ),
    ("batch, by coefficients", MANY): Benchmark(
        "by coefficients, 1e6 points", "2.46", 1.0, "215 derivatives a row are written out: 1.7 kB",
    ),
    ("batch, by coefficients, 64 rows a call", MANY): Benchmark("the same, 64 rows a call (as before)", "2.46", 1.0),
    ("scalar C", MANY): Benchmark(
        "scalar C, forces", ".61", 0.60, "eight elementary functions and four divisions that follow each other",
    ),
}  # fmt: skip


def verdict(value: float, line: Benchmark) -> str:
    """Return whether a figure reaches its target, or what limits it."""
    if value <= line.target:
        return "reached"
    return f"not reached: {line.limit}" if line.limit else "not reached"


def startup_text(times: Mapping[str, float], scale: float) -> str:
    """Return the table of start-up times."""
    rows = []
    for name, line in STARTUP.items():
        if name in times:
            scaled = times[name] / scale
            figures = [f"{times[name]:.2f}", f"{scaled:.2f}", f"{line.target:g}", line.before]
            rows.append([line.title, *figures, verdict(scaled, line)])
    head = ("", "CPU s", "reference machine", "target", "before", "")
    return table(head, rows)


def evaluation_text(times: Mapping[int, Mapping[str, float]]) -> str:
    """Return the table of evaluation times relative to CasADi's C."""
    rows = []
    for (name, points), line in EVALUATION.items():
        if name in times.get(points, {}):
            ns, ratio = times[points][name], times[points][name] / times[points][CASADI]
            rows.append([line.title, f"{ns:.0f}", f"{ratio:.2f}", f"{line.target:.2f}", line.before,
                         verdict(ratio, line)])  # fmt: skip
    head = ("MF6.1, one thread", "ns a point", "/ CasADi C", "target", "before", "")
    return table(head, rows)


def fit_texts(
    compared: Mapping[str, Any], grown: Sequence[Mapping[str, float]], real: float | None, scale: float
) -> dict[str, str]:
    """Return the tables of fits, of solvers and of stages."""
    trf, whole = compared["scipy trf"]["seconds"], compared["full fit"]["seconds"]
    rows = [
        [f"whole fit, {compared['rows']:,} rows, {compared['coefficients']} coefficients, "
         f"{compared['constraints']} constraints: share of SciPy's trf", f"{whole:.2f}", f"1/{trf / whole:.1f}",
         "1/20", "1/5.4"],
        *([f"whole fit, {run['rows']:,.0f} rows: CPU s, memory", f"{run['seconds']:.1f}",
           f"{run['seconds'] / scale:.1f} s, {run['peak MB']:.0f} MB", *target]
          for run, target in zip(grown, targets_of(grown), strict=True)),
    ]  # fmt: skip
    if real is not None:
        rows.append(["measured recordings, 80,000 rows, command line", f"{real:.1f}", f"{real / scale:.1f} s", "5 s",
                     "17-22 s"])  # fmt: skip
    passes = compared["derivative pass"]
    rows += [
        [f"J^T W J and gradient, us a row: {way}", f"{1e6 * seconds:.2f}", f"{1e6 * seconds / scale:.2f}", "0.5-0.8",
         "3.5"]
        for way, seconds in passes.items()
    ]  # fmt: skip
    spent = passes["in the kernel"] * sum(stage["rows"] * stage["iterations"] for stage in compared["stages"])
    stages = [[s["name"], f"{s['rows']:,}", str(s["free"]), str(s["iterations"])] for s in compared["stages"]]
    solvers = [
        [name, f"{compared[name]['seconds']:.2f}", f"1/{trf / compared[name]['seconds']:.1f}",
         f"{compared[name]['cost']:.6f}", str(compared[name]["evaluations"])]
        for name in ("scipy trf", "joint problem", "fit of all rows", "full fit")
    ]  # fmt: skip
    return {
        "fit": table(("", "here", "reference machine", "target", "before"), rows),
        "solvers": table(("", "CPU s", "of trf", "cost", "Jacobians"), solvers),
        "stages": f"{table(('stage', 'rows', 'free', 'iterations'), stages)}\n\n"
        f"The derivative passes of these iterations, with all coefficients, need {spent:.2f} of {whole:.2f} s.",
    }


def targets_of(grown: Sequence[Mapping[str, float]]) -> list[tuple[str, str]]:
    """Return target and earlier figure of each size of fit."""
    return [("7 s, 500 MB", "35 s, 1,080 MB") if run["rows"] > 9e5 else ("-", "-") for run in grown]


def real_fit() -> float | None:
    """Return the CPU seconds of a fit of the measured recordings from the command line; None without them."""
    data = os.environ.get("TIREFMU_DATA")
    if not data:
        return None
    files = [str(Path(data) / name) for name in ("cornering.mat", "drivebrake.mat")]
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "tirefmu", "fit", *files, "--model", "mf61", "--nominal",
                   "Fz0=1100,R0=0.23,p0=83000,V0=11", "-o", str(Path(folder) / "real.tir"), "--quiet"]  # fmt: skip
        before = os.times()
        if subprocess.run(command, check=False, env={**os.environ, "OMP_NUM_THREADS": "1"}).returncode == 2:
            raise SystemExit("the fit of the measured recordings was refused")
        after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def surroundings(loads: Sequence[float], ns: float) -> str:
    """Return machine, load and reference."""
    model = next(
        (line.partition(":")[2].strip() for line in _lines(Path("/proc/cpuinfo")) if line.startswith("model name")),
        platform.processor(),
    )
    busy = max(loads) > QUIET + 1.0  # the benchmark itself is a load of 1
    others = "**Other programs were computing: CPU times are up to twice those of an idle machine.** " if busy else ""
    return (
        f"Machine: {model}, {os.cpu_count()} processors, Python {platform.python_version()}. "
        f"{others}Load average at the start {loads[0]:.1f}, at the end {loads[1]:.1f}.\n\n"
        f"CasADi's C needs {ns:.0f} ns a point here, {REFERENCE_NS:.0f} ns on the reference machine: "
        f"CPU seconds are divided by {ns / REFERENCE_NS:.2f} in the column *reference machine*.\n"
    )


def _lines(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines() if path.is_file() else []


def main() -> None:
    """Run the benchmarks and print or write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parts", default=",".join(PARTS))
    parser.add_argument("--quick", action="store_true", help="one repetition, few rows, no diagnosis")
    parser.add_argument("--write", action="store_true", help=f"write {PAGE.name}")
    given = parser.parse_args()
    parts = given.parts.split(",")
    start = os.getloadavg()[0]
    only = [] if "evaluation" in parts else [CASADI]
    times = evaluation_times(model_named("mf61"), [100, MANY], 1 if given.quick else 7, only)
    ns = times[MANY][CASADI]
    scale = ns / REFERENCE_NS
    text: dict[str, str] = {}
    if "startup" in parts:
        text["startup"] = startup_text(startup_times(1, SHORT) if given.quick else startup_times(3), scale)
    if "fit" in parts:
        with threadpool_limits(limits=1, user_api="blas"):
            compared = compare(3_000 if given.quick else 20_000)
        grown = growth([10_000] if given.quick else [100_000, MANY])
        text |= fit_texts(compared, grown, None if given.quick else real_fit(), scale)
    if "evaluation" in parts:
        text["evaluation"] = evaluation_text(times)
    short = "**A short run: one repetition, few rows, no diagnosis.** " if given.quick else ""
    text["machine"] = short + surroundings((start, os.getloadavg()[0]), ns)
    for part, content in text.items():
        print(f"{part}\n\n{content}\n")
    if given.write:
        put(PAGE, text)


if __name__ == "__main__":
    main()
