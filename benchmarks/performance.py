"""The page docs/performance.md: start-up, fits, evaluation and memory of one run, with targets and earlier figures.

Runs the other benchmarks in processes of their own and puts their results on one page. CPU seconds are also given for
the reference machine, on which the C code that CasADi generates for the forces of MF6.1 (gcc -O2, one thread, a million
points) needs 386 ns a point: seconds on this machine times 386 ns over the time that this code takes here.

    python benchmarks/performance.py [--parts startup,fit,evaluation,memory] [--quick] [--write]
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
PAGE = HERE.parent / "docs" / "performance.md"
#: ns a point on the reference machine.
REFERENCE_NS = 386.0
CASADI, MANY = "CasADi C, -O2", "1000000"
#: Load of the machine above which the page says that others were computing.
QUIET = 0.5
PARTS = ("startup", "fit", "evaluation", "memory")


@dataclass(frozen=True)
class Benchmark:
    """A figure with its target, its earlier value, and what limits it."""

    title: str
    before: str
    target: float
    limit: str = ""


#: By name in `benchmarks/startup.py`. Targets in CPU s of the reference machine.
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
#: What was tried, in a run of its own.
EVALUATION_NOTES = """Each function is called repeatedly, and its last result is dropped: the results of a million
rows (forces 40 MB, derivatives 280 MB) use the memory of earlier ones again, at most 512 MB of it. The first call of
a process needs new memory: up to .5 of CasADi's time more for the derivatives, where a virtual machine gets it from
its host.

What the forces kernel gained on a Zen 4 processor with GCC 12, each line with those above it, rows in the cache:

| | ns a point |
| --- | --- |
| before | 64.4 |
| arctangent with 9 coefficients (1e-15), sine with 7 (now 8: 1 at pi/2), not 11 and 8, by Horner's rule | 56.7 |
| reduction of angles in two steps instead of three, where products are fused | 55.5 |
| what is equal in all rows is computed once in each product: 42 divisions a row instead of 59 | 53.8 |
| tangent with one reduction of its angle; constants loaded where they are used | 51.7 |

The inputs of the next 64 rows are fetched ahead: 58 instead of 62 ns a point at a million rows. Without gain were
vectors of 256 bits (+12 %) and of 1,024 bits (twice the time: comparisons are not vectorized), blocks of 128 to 512
rows, the order of the book (+5 %), masked moves of AVX-512 (+1 %), Estrin's scheme (+8 %), other schedulers and
tunings of GCC (0 to +18 %), clang (+8 %). Of 2,600 instructions for 8 rows, the multiplications and additions take 60
% of the time; 490 moves of spilled registers and 260 loads of constants fill the rest. The divisions alone are no
limit: 17 fewer of them gained 3 %. Without checks of angles that are a coefficient times an arctangent, and with the
base of the arctangent by masks, it takes 1 % less in a comparison within one process. Where a library lies in memory
decides more than that: the same kernel, loaded twice in one process, took 57 and 67 ns. Terms of the load once per run
of equal load, and omission of G_xa0 and G_yk0 where their shifts are 0, were not tried: they help some tables and tires
only, and this benchmark has neither.

The C code of one row, on the same processor, rows in the cache, CPU time of a call from C:

| | ns a point |
| --- | --- |
| before | 377 |
| calls that do not depend on each other share vectors; arctangent with 10 coefficients, without a table | 280 |
| exp and powers without calls of math.h | 264 |
| signs without branches: GCC made jumps of the comparisons, which are hard to predict | 258 |

These steps were measured in prototypes. Calls share vectors in pairs, in the order in which their arguments are known:
.53 of CasADi's time. Groups of four save .02 more. An order and groups from a simulated processor reached .48, for 150
lines. Single calls take .74, .82 without vector types. Through Python at a million rows, calls for 4,096 of them,
which are transposed while they are in the cache, take 4 % less than one call for all. What is left is mostly waiting.
From the inclination over the cornering stiffness to the overturning moment, eight elementary functions and four
divisions follow each other. Shared divisions (-1 %), -O3, -fno-trapping-math, -fno-gcse, tunings and schedulers of GCC
(0 to +6 %) gained nothing; Horner's rule takes 4 % more. In an FMU, whose code is for any x86-64 processor and fuses
no products, single calls are not expanded, which costs 9 % and keeps the FMU small. Steps of FMUs with hub inputs take
3 % less only: they use the code for turn slip, whose calls share no vectors.

The reference is CasADi's C in a shared library as users build it, in which its 93 calls of small functions (square,
sign, size) a row go through the table of the linker. With hidden visibility it takes 424 instead of 530 ns; relative to
that, the C code of one row takes .57.
"""
#: By candidate and number of points in `benchmarks/evaluation.py`. Targets relative to CasADi's C.
EVALUATION = {
    ("batch", MANY): Benchmark(
        "forces, 1e6 points", ".14-.16", 0.10,
        "arithmetic: 25 arctangents, 19 sines, cosines and tangents, 42 divisions a row; spilled registers",
    ),
    ("batch", "100"): Benchmark("forces, 100 points through Python", "1.05-1.11", 0.40, "objects that a call makes"),
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


def result_of(program: str, arguments: Sequence[str], folder: Path) -> Any:
    """Return what a benchmark writes to its file."""
    path = folder / f"{program}.json"
    command = [sys.executable, str(HERE / f"{program}.py"), *arguments, "--json", str(path)]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    subprocess.run(command, check=True, env=environment, stdout=sys.stderr)
    return json.loads(path.read_text(encoding="utf-8"))


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


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
    return f"## Start-up\n\n{table(head, rows)}"


def evaluation_text(times: Mapping[str, Mapping[str, float]]) -> str:
    """Return the table of evaluation times relative to CasADi's C."""
    rows = []
    for (name, points), line in EVALUATION.items():
        if name in times.get(points, {}):
            ns, ratio = times[points][name], times[points][name] / times[points][CASADI]
            rows.append([line.title, f"{ns:.0f}", f"{ratio:.2f}", f"{line.target:.2f}", line.before,
                         verdict(ratio, line)])  # fmt: skip
    head = ("MF6.1, one thread", "ns a point", "/ CasADi C", "target", "before", "")
    return f"## Evaluation\n\n{table(head, rows)}\n{EVALUATION_NOTES}"


def fit_text(found: Mapping[str, Any], real: float | None, scale: float) -> str:
    """Return the tables of fits."""
    compared, grown = found["comparison"], found["growth"]
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
    return (
        f"## Fit\n\n{table(('', 'here', 'reference machine', 'target', 'before'), rows)}\n"
        "`trf` has no constraints. Where its cost is higher than that of the full fit, it has stopped elsewhere,\n"
        "and its time is no measure. With another rounding of the kernels it once ended at the cost of the full fit,\n"
        "after 20 Jacobians in 11 s with 594 ns a point for CasADi's C.\n\n"
        f"{table(('', 'CPU s', 'of trf', 'cost', 'Jacobians'), solvers)}\n"
        "Iterations of each stage of the whole fit. A stage that ends early has few free coefficients or starts near\n"
        "its optimum; the last one takes Gauss-Newton steps from the one before (ARCHITECTURE.md, Solver):\n\n"
        f"{table(('stage', 'rows', 'free', 'iterations'), stages)}\n"
        f"The derivative passes of these iterations, with all coefficients, need {spent:.2f} of {whole:.2f} s.\n"
        "The rest limits what is not reached. At 20,000 rows an eighth of the time each is screening and grouping of\n"
        "the rows, the steps of IPOPT without its functions, and intervals; a tenth each the slip stiffness read from\n"
        "the data, and the verification of constraints. At a million rows derivative passes and intervals under\n"
        "correlated noise take most of it. Memory there is the table that was given, and its rows as arrays.\n"
    )


def targets_of(grown: Sequence[Mapping[str, float]]) -> list[tuple[str, str]]:
    """Return target and earlier figure of each size of fit."""
    return [("7 s, 500 MB", "35 s, 1,080 MB") if run["rows"] > 9e5 else ("-", "-") for run in grown]


def real_fit(folder: Path) -> float | None:
    """Return the CPU seconds of a fit of the measured recordings from the command line; None without them."""
    data = os.environ.get("TIREFMU_DATA")
    if not data:
        return None
    files = [str(Path(data) / name) for name in ("cornering.mat", "drivebrake.mat")]
    command = [sys.executable, "-m", "tirefmu", "fit", *files, "--model", "mf61", "--nominal",
               "Fz0=1100,R0=0.23,p0=83000,V0=11", "-o", str(folder / "real.tir"), "--quiet"]  # fmt: skip
    before = os.times()
    if subprocess.run(command, check=False, env={**os.environ, "OMP_NUM_THREADS": "1"}).returncode == 2:
        raise SystemExit("the fit of the measured recordings was refused")
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def memory_text(runs: Sequence[Mapping[str, Any]]) -> str:
    """Return the table of memory by rows."""
    rows = [
        [run["command"], f"{run['rows']:,}", f"{run['peak MB']:.0f}", f"{1e6 * run['seconds'] / run['rows']:.2f}"]
        for run in runs
    ]
    head = ("command over a Parquet table", "rows", "peak memory, MB (target 600)", "CPU us a row")
    return f"## Memory\n\n{table(head, rows)}"


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


INTRODUCTION = """# Performance

`make performance` writes this page. All figures are of one run: CPU seconds of one process with one thread, except
where another unit is stated. *Before* are the figures before the work on computing time, on the reference machine.

"""


def main() -> None:
    """Run the benchmarks and print or write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parts", default=",".join(PARTS))
    parser.add_argument("--quick", action="store_true", help="one repetition, few rows, no diagnosis")
    parser.add_argument("--write", action="store_true", help=f"write {PAGE.name}")
    given = parser.parse_args()
    parts = given.parts.split(",")
    start = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        only = ";".join(dict.fromkeys(name for name, _ in EVALUATION)) if "evaluation" in parts else CASADI
        repetitions = ["--repetitions", "1" if given.quick else "7"]
        times = result_of("evaluation", ["--points", f"100,{MANY}", *repetitions, "--only", only], folder)
        ns = times[MANY][CASADI]
        scale = ns / REFERENCE_NS
        text = []
        if "startup" in parts:
            runs = ["--runs", "1", f"--only={','.join(SHORT)}"] if given.quick else []
            text.append(startup_text(result_of("startup", runs, folder), scale))
        if "fit" in parts:
            sizes = ["--rows", "3000", "--growth", "10000"] if given.quick else ["--growth", "100000,1000000"]
            measured = None if given.quick else real_fit(folder)
            text.append(fit_text(result_of("fitting", sizes, folder), measured, scale))
        if "evaluation" in parts:
            text.append(evaluation_text(times))
        if "memory" in parts:
            sizes = ["--rows", "600000"] if given.quick else ["--rows", "1000000,10000000"]
            text.append(memory_text(result_of("streaming", sizes, folder)))
    short = "**A short run: one repetition, few rows, no diagnosis.** " if given.quick else ""
    page = f"{INTRODUCTION}{short}{surroundings((start, os.getloadavg()[0]), ns)}\n" + "\n".join(text)
    if given.write:
        PAGE.write_text(page, encoding="utf-8")
    else:
        print(page)


if __name__ == "__main__":
    main()
