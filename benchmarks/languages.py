"""Every model in every language: largest difference from NumPy over 2,000 rows, time per point, operations.

    python benchmarks/languages.py [--rows 2000] [--only c,cpp] [--models mf96,mf61] [--functions forces] [--no-times]

A language whose compiler or package is missing is marked. The tables are those of docs/languages.md. LIBM is the path
of the compiled crate libm, for Rust.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from tirefmu.hosts.printout import printed, program_of
from tirefmu.symbolic.printers.languages import LANGUAGES, printer
from tirefmu.symbolic.printers.languages.program import FUNCTIONS, Program, Selection
from tirefmu.tires import Tire, published, read_tir

ROOT = Path(__file__).parents[1]
FIALA = {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.31, "WIDTH": 0.15, "VERTICAL_STIFFNESS": 2e5, "CSLIP": 9e4,
         "CALPHA": 6e4, "UMIN": 0.7, "UMAX": 1.1, "ROLLING_RESISTANCE": 0.004}  # fmt: skip
BRUSH = {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3, "CKAPPA": 9e4, "CALPHA": 5e4, "MUX": 1.4, "MUY": 1.1,
         "PATCH": 0.07, "NSTIFF": 0.7, "NMU": -0.12, "NPATCH": 0.6}  # fmt: skip
WITH_STATES = ("heat_friction", "slip_history", "relax_lat", "relax_lon")
LIBM = os.environ.get("LIBM", "liblibm.rlib")
#: How the self-test of a language is compiled and run.
PYTHON = f"{sys.executable} {{}}"
COMMANDS = {
    "numpy": ("", PYTHON),
    "c": ("cc -std=c99 -O0 {} -lm -o selftest", "./selftest"),
    "cpp": ("c++ -std=c++17 -O0 {} -o selftest", "./selftest"),
    "matlab": ("", "octave-cli --norc --no-history --quiet {}"),
    "javascript": ("", "node {}"),
    "casadi": ("", PYTHON),
    "jax": ("", PYTHON),
    "torch": ("", PYTHON),
    "modelica": ("", f"{sys.executable} {ROOT / 'benchmarks' / 'run_modelica.py'} {{}}"),
    "rust": (f"rustc -C opt-level=0 {{}} --extern libm={LIBM} -o selftest", "./selftest"),
}
#: Programs that print the time of a point in nanoseconds; @name@ is the tire, @load@ the nominal load.
TIMED = {
    "c": """#include "@name@.h"
#include <stdio.h>
#include <time.h>
int main(void) {
    @name@_inputs in = @name@_nominal; double f[8], sum = 0.0; const clock_t start = clock();
    for (int i = 0; i < 1000000; i++) { in.alpha = 1e-7*i; in.kappa = 2e-7*i; @name@_forces(&in, f);
        sum += f[0] + f[1] + f[2]; }
    printf("%.0f %g\\n", (double)(clock() - start)/CLOCKS_PER_SEC*1e3, sum); return 0; }""",
    "cpp": """#include "@name@.hpp"
#include <cstdio>
#include <ctime>
int main() {
    @name@::Inputs<double> in; double sum = 0.0; const std::clock_t start = std::clock();
    for (int i = 0; i < 1000000; i++) { in.alpha = 1e-7*i; in.kappa = 2e-7*i;
        const auto f = @name@::forces(in); sum += f.Fx + f.Fy + f.Mz; }
    std::printf("%.0f %g\\n", double(std::clock() - start)/CLOCKS_PER_SEC*1e3, sum); }""",
    "javascript": """import { forces, NOMINAL } from "./@name@.mjs";
let sum = 0; const inputs = { ...NOMINAL }; let start = process.cpuUsage().user;
for (let i = 0; i < 300000; i++) { inputs.alpha = 1e-7*i; inputs.kappa = 2e-7*i;
  const f = forces(inputs); sum += f.Fx + f.Fy + f.Mz; }
console.log(((process.cpuUsage().user - start)/300).toFixed(0), sum);""",
    "matlab": """x = (1:100000)*1e-6; start = cputime(); [Fx, Fy] = @name@_forces(x, 2*x); y = sum(Fy);
printf('%.0f %g\\n', (cputime() - start)*1e4, y);""",
    "numpy": """import time, numpy as np, @name@ as tire
x = np.arange(100000)*1e-6; start = time.process_time(); y = tire.forces(alpha=x, kappa=2*x)["Fy"].sum()
print(round((time.process_time() - start)*1e4), y)""",
    "casadi": """import time, numpy as np, @name@ as tire
f = tire.function("forces"); x = np.tile(list(tire.NOMINAL.values()), (20000, 1)).T; x[1] = np.arange(20000)*5e-6
start = time.process_time(); y = f(x); print(round((time.process_time() - start)*5e4), y[1, 0])""",
    "jax": """import time, jax, jax.numpy as jnp
jax.config.update("jax_enable_x64", True); jax.config.update("jax_platforms", "cpu")
import @name@ as tire
f = jax.jit(lambda x: tire.forces(alpha=x, kappa=2*x)["Fy"]); x = jnp.arange(100000)*1e-6; f(x).block_until_ready()
start = time.process_time(); y = f(x).block_until_ready(); print(round((time.process_time() - start)*1e4), y[0])""",
    "torch": """import time, torch, @name@ as tire
torch.set_num_threads(1); x = torch.arange(100000, dtype=torch.float64)*1e-6
with torch.no_grad():
    start = time.process_time(); y = tire.forces(alpha=x, kappa=2*x)["Fy"].sum()
print(round((time.process_time() - start)*1e4), float(y))""",
}
ENDINGS = {"c": ".c", "cpp": ".cpp", "javascript": ".mjs", "matlab": ".m"}


def tires() -> dict[str, Tire]:
    """Return a tire of every model, one with an added effect, and one with states."""
    golden = ROOT / "tests" / "golden"
    found = {"mf96": published("trento_hoosier")}
    for model in ("mf52", "mf61", "mf62"):
        found[model] = read_tir(golden / f"MagicFormula{model[2:]}_Parameters.tir")
    mf61 = found["mf61"]
    values = {**mf61.values, "TREF": 60.0, "TMU1": -0.002, "TMU2": -3e-5}
    warm = replace(mf61, values=values, effects={*mf61.has, "temp_friction"})
    states = {"HMU": 4e-6, "SHMU": 0.05, "SIGX": 0.2, "SIGY": 0.4}
    late = replace(mf61, values={**mf61.values, **states}, effects={*mf61.has, *WITH_STATES})
    return {**found, "fiala": Tire("fiala", FIALA), "brush": Tire("brush", BRUSH), "mf61 + temp_friction": warm,
            "mf61 + states": late}  # fmt: skip


def run(command: str, folder: Path) -> str:
    """Run a command in a folder and return its output, or the reason why it has none."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    result = subprocess.run(
        command.split(), cwd=folder, capture_output=True, text=True, env=environment, timeout=1500, check=False
    )
    if result.returncode:
        last = (result.stderr.strip() or result.stdout.strip() or "?").splitlines()[-1]
        raise RuntimeError(re.sub(r"\W+", " ", last)[:60])
    return result.stdout


@lru_cache(maxsize=2)
def program(name: str, placement: str, rows: int, functions: tuple[str, ...]) -> Program:
    """Return the printout of a tire: lines, functions and rows are the same in all languages."""
    tire = tires()[name].in_signs("iso")
    possible = set(functions) - ({"jacobian_parameters"} if placement == "inline" else set())
    possible -= set() if tire.states else {"states"}
    return program_of(tire, tire.model, Selection(tuple(sorted(possible)), placement), rows)


def differences(found: Program, language: str) -> dict[str, str]:
    """Return the largest difference of each function of a printout, by name."""
    build, command = COMMANDS[language]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = printer(language)(found)
        for file, text in files.items():
            (folder / file).write_text(text)
        (source,) = (file for file in files if "_selftest." in file and not file.endswith(".txt"))
        if build:
            run(build.format(source), folder)
        return dict(line.split() for line in run(command.format(source), folder).splitlines())


def nanoseconds(tire: Tire, language: str) -> str:
    """Return the time of one point of all forces, with the values in the lines."""
    build, command = COMMANDS[language]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in printed(tire, language, functions=["forces"], rows=1).items():
            (folder / file).write_text(text)
        source = f"timed{ENDINGS.get(language, '.py')}"
        (folder / source).write_text(TIMED[language].replace("@name@", tire.model))
        if build:
            run(build.format(source).replace("-O0", "-O2"), folder)
        return run(command.format(source), folder).split()[0]


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=2000)
    parser.add_argument("--struct-rows", type=int, default=400, help="rows with derivatives by all coefficients")
    parser.add_argument("--only", default=",".join(name for name in LANGUAGES if name in COMMANDS))
    parser.add_argument("--functions", default=",".join(FUNCTIONS))
    parser.add_argument("--models", default="")
    parser.add_argument("--no-times", action="store_true")
    parser.add_argument("--only-times", action="store_true")
    options = parser.parse_args()
    chosen = {name: tire for name, tire in tires().items() if not options.models or name in options.models.split(",")}
    columns = {"inline": [name for name in FUNCTIONS if name != "jacobian_parameters"], "struct": list(FUNCTIONS)}
    titles = [f"{placement}: {name}" for placement, names in columns.items() for name in names]
    print(f"| model | language | {' | '.join(titles)} | ns per point |\n|{'---|' * (len(titles) + 3)}")
    for name, tire in chosen.items():
        for language in options.only.split(","):
            cells = []
            for placement, names in () if options.only_times else columns.items():
                rows = options.rows if placement == "inline" else options.struct_rows
                try:
                    found = differences(program(name, placement, rows, tuple(options.functions.split(","))), language)
                    cells += [found.get(function, "") for function in names]
                except (RuntimeError, OSError, subprocess.TimeoutExpired) as error:
                    cells += [f"not run: {error}"] * len(names)
            try:
                cells.append("" if options.no_times else nanoseconds(tire, language))
            except (RuntimeError, OSError, KeyError) as error:
                cells.append("not run" if isinstance(error, KeyError) else f"not run: {error}")
            print(f"| {name} | {language} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
