"""Every model in every language: largest difference from NumPy over 2,000 rows, and the time per point.

    python benchmarks/languages.py [--rows 2000] [--only c,cpp] [--models mf96,mf61] [--write]
    python benchmarks/languages.py --times [--only c,cpp] [--models mf96]

The rows include zero slip, no load, reverse, standstill and large slips. `--write` replaces the computed cells of the
table in docs/languages.md; a language whose compiler or package is missing keeps its cells. The self-tests run as
in the tests (tests/exports/self_tests.py).
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "exports"))
from doc_tables import DOCS, cells_of, put, split, table
from self_tests import COMMANDS, command_of, differences

from tirefmu.applications.exports.printout import printed, program_of
from tirefmu.symbolic.printers.languages import LANGUAGES, printer
from tirefmu.symbolic.printers.languages.program import FUNCTIONS, PrintedProgram, PrintoutSelection
from tirefmu.tires import Tire, published, read_tir

ROOT = Path(__file__).parents[1]
FIALA = {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.31, "WIDTH": 0.15, "VERTICAL_STIFFNESS": 2e5, "CSLIP": 9e4,
         "CALPHA": 6e4, "UMIN": 0.7, "UMAX": 1.1, "ROLLING_RESISTANCE": 0.004}  # fmt: skip
BRUSH = {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3, "CKAPPA": 9e4, "CALPHA": 5e4, "MUX": 1.4, "MUY": 1.1,
         "PATCH": 0.07, "NSTIFF": 0.7, "NMU": -0.12, "NPATCH": 0.6}  # fmt: skip
WITH_STATES = ("heat_friction", "slip_history", "relax_lat", "relax_lon")
#: Rows (values in the lines, coefficients) where the compiler of a language repeats all lines for every result.
FEWER_ROWS = {"modelica": (40, 0)}
#: Languages that are run with some models only, and the number of the reason in docs/languages.md.
LIMITED = {"jax": (("mf96", "fiala", "brush"), "not run (1)")}

#: Programs that print the time of a point in nanoseconds; @name@ is the tire, @sum@ the sum of all forces: a compiler
#: removes the lines of forces that nothing reads, and computes lines of constant inputs once if it sees the function.
TIMED = {
    "c": """#include "@name@.h"
#include <stdio.h>
#include <time.h>
int main(void) {
    void (*volatile forces)(const @name@_inputs *, double *) = @name@_forces;
    @name@_inputs in = @name@_nominal; double f[8], sum = 0.0; const clock_t start = clock();
    for (int i = 0; i < 1000000; i++) { in.alpha = 1e-7*i; in.kappa = 2e-7*i; forces(&in, f);
        sum += @in_array@; }
    printf("%.0f %g\\n", (double)(clock() - start)/CLOCKS_PER_SEC*1e3, sum); return 0; }""",
    "cpp": """#include "@name@.hpp"
#include <cstdio>
#include <ctime>
int main() {
    @name@::Forces<double> (*volatile forces)(const @name@::Inputs<double> &) = @name@::forces<double>;
    @name@::Inputs<double> in; double sum = 0.0; const std::clock_t start = std::clock();
    for (int i = 0; i < 1000000; i++) { in.alpha = 1e-7*i; in.kappa = 2e-7*i;
        const auto f = forces(in); sum += @sum@; }
    std::printf("%.0f %g\\n", double(std::clock() - start)/CLOCKS_PER_SEC*1e3, sum); }""",
    "javascript": """import { forces, NOMINAL } from "./@name@.mjs";
let sum = 0; const inputs = { ...NOMINAL }; let start = process.cpuUsage().user;
for (let i = 0; i < 300000; i++) { inputs.alpha = 1e-7*i; inputs.kappa = 2e-7*i;
  const f = forces(inputs); sum += @sum@; }
console.log(((process.cpuUsage().user - start)/300).toFixed(0), sum);""",
    "matlab": """in = @name@_inputs(); in.kappa = (1:100000)*1e-6; in.alpha = 2*in.kappa;
start = cputime(); [Fx, Fy] = @name@_forces(in); y = sum(Fy);
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

PAGE, PART = DOCS / "languages.md", "bench-languages"
#: The functions behind each of the numbers of a cell.
NUMBERS = {
    "values": ("forces", "quantities"),
    "Jacobian": ("jacobian_inputs", "jacobian_parameters"),
    "states": ("states",),
}

#: The cell of a language that was not installed where the table was written.
NOT_INSTALLED = "not run (2)"


def tires_of_models() -> dict[str, Tire]:
    """Return a tire of every model."""
    files = {f"mf{v}": ROOT / f"tests/golden/MagicFormula{v}_Parameters.tir" for v in (52, 61, 62)}
    made = {"fiala": Tire("fiala", FIALA), "brush": Tire("brush", BRUSH)}
    return {"mf96": published("trento_hoosier"), **{name: read_tir(path) for name, path in files.items()}, **made}


def tires() -> dict[str, Tire]:
    """Return a tire of every model, one with an added effect, and one with states."""
    mf61 = tires_of_models()["mf61"]
    values = {**mf61.values, "TREF": 60.0, "TMU1": -0.002, "TMU2": -3e-5}
    warm = replace(mf61, values=values, effects={*mf61.has, "temp_friction"})
    states = {"HMU": 4e-6, "SHMUX": 0.05, "SHMUY": 0.05, "SIGX": 0.2, "SIGY": 0.4}
    late = replace(mf61, values={**mf61.values, **states}, effects={*mf61.has, *WITH_STATES})
    return {**tires_of_models(), "mf61 + temp_friction": warm, "mf61 + states": late}


@lru_cache(maxsize=4)
def program(name: str, placement: str, rows: int, functions: tuple[str, ...]) -> PrintedProgram:
    """Return the printout of a tire: lines, functions and rows are the same in all languages."""
    tire = tires()[name].in_signs("iso")
    possible = set(functions) - ({"jacobian_parameters"} if placement == "inline" else set())
    possible -= set() if tire.states else {"states"}
    return program_of(tire, tire.model, PrintoutSelection(tuple(sorted(possible)), placement), rows)


def printed_differences(found: PrintedProgram, language: str) -> dict[str, float]:
    """Return the largest difference of each function of a printout, by name."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in printer(language)(found).items():
            (folder / file).write_text(text)
        code, found_differences = differences(command_of(language, folder), folder)
        if code:
            raise RuntimeError("the self-test fails")
        return found_differences


def nanoseconds(tire: Tire, language: str) -> str:
    """Return the time of one point of all forces, with the values in the lines."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in printed(tire, language, functions=["forces"], rows=1).items():
            (folder / file).write_text(text)
        source = f"timed{ENDINGS.get(language, '.py')}"
        sums = {
            "@name@": tire.model,
            "@in_array@": " + ".join(f"f[{i}]" for i in range(len(tire.outputs))),
            "@sum@": " + ".join(f"f.{name}" for name in tire.outputs),
        }
        (folder / source).write_text(re.sub("@[a-z_]+@", lambda found: sums[found[0]], TIMED[language]))
        run = subprocess.run(
            command_of(language, folder, source, "-O2"), cwd=folder, capture_output=True, text=True, check=True
        )
        return run.stdout.split()[0]


def compared(name: str, language: str, rows: int, struct_rows: int) -> str:
    """Return the cell of a tire in a language, with values in the lines and with coefficients."""
    models, reason = LIMITED.get(language, ((), ""))
    if reason and name not in models:
        return reason
    rows, struct_rows = FEWER_ROWS.get(language, (rows, struct_rows))
    found: dict[str, list[float]] = {}
    for placement, n in (("inline", rows), ("struct", struct_rows)):
        if not n:
            continue
        # Named quantities of many lines are not printed where the lines are repeated.
        functions = FUNCTIONS if language not in FEWER_ROWS else tuple(f for f in FUNCTIONS if f != "quantities")
        for function, difference in printed_differences(program(name, placement, n, functions), language).items():
            found.setdefault(function, []).append(difference)
    return cell(found, f"{rows} rows, forces" if language in FEWER_ROWS else "")


def cell(differences: Mapping[str, list[float]], remark: str = "") -> str:
    """Return the text of a cell.

    `differences`: by function, the largest differences of the printouts with values in the lines and with coefficients.
    `remark`: how the run differs from the others.

    >>> cell({"forces": [1e-15, 2e-15], "jacobian_inputs": [3e-14], "states": []}, "40 rows")
    '2e-15, 3e-14, - (40 rows)'
    """
    parts = []
    for functions in NUMBERS.values():
        found = [difference for name in functions for difference in differences.get(name, [])]
        parts.append(f"{max(found):.0e}" if found else "-")
    return ", ".join(parts) + (f" ({remark})" if remark else "")


def update(language: str, model: str, text: str) -> None:
    """Write a cell into the page; the others stay."""
    rows = cells_of(split(PAGE, PART)[1])
    models = ["language", *tires()]
    names = [row[0] for row in rows]
    if language not in names:
        rows.append([language, *[NOT_INSTALLED] * len(tires())])
        names.append(language)
    rows[names.index(language)][models.index(model)] = text
    put(PAGE, {PART: table(models, rows)})


def main() -> None:
    """Print the largest differences, or the times; write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=2000)
    parser.add_argument("--struct-rows", type=int, default=400, help="rows with derivatives by all coefficients")
    parser.add_argument("--only", default=",".join(name for name in LANGUAGES if name in COMMANDS))
    parser.add_argument("--models", default=",".join(tires()))
    parser.add_argument("--write", action="store_true", help="write the table into docs/languages.md")
    parser.add_argument("--times", action="store_true", help="print the time of all forces at a point, ns")
    options = parser.parse_args()
    for name in options.models.split(","):
        for language in options.only.split(","):
            try:
                if options.times:
                    text = nanoseconds(tires()[name], language) if language in TIMED else "not run"
                else:
                    text = compared(name, language, options.rows, options.struct_rows)
                    if options.write:
                        update(language, name, text)
            except (RuntimeError, OSError, subprocess.SubprocessError) as error:
                text = f"not run: {error}"
            print(f"{name} | {language} | {text}", flush=True)


if __name__ == "__main__":
    main()
