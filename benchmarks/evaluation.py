"""How long a point takes: CasADi's C, SymPy's lambdify and every code of ours, in one run.

Repetitions are interleaved, so that the machine's other work falls on all alike; medians are told.

    python benchmarks/evaluation.py [--model mf61] [--points 100,10000,1000000] [--json FILE]
"""

from __future__ import annotations

import argparse
import ctypes
import json
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import numpy.typing as npt
import sympy as sp

from tirefmu.symbolic import model as book_of
from tirefmu.symbolic.model import Model, reaching
from tirefmu.tires.code import code_for
from tirefmu.tires.code.compiler import shared_library
from tirefmu.tires.code.modules import casadi_module

FloatArray = npt.NDArray[np.float64]
RANGES = {"kappa": (-0.3, 0.3), "alpha": (-0.3, 0.3), "gamma": (-0.1, 0.1), "p": (1.8e5, 2.8e5), "V": (8.0, 30.0)}
CASADI = "CasADi C, -O2"
#: Seconds that one contender may take for one repetition; what is slower is left out at that many points.
PATIENCE = 30.0
LOOP = """
#include <stddef.h>
void rows(size_t n, const double *x, double *y, double *w)
{{
    for (size_t i = 0; i < n; i++) {{
        const double *in[1] = {{x + {inputs}*i}};
        double *out[1] = {{y + {outputs}*i}};
        forces(in, out, 0, w, 0);
    }}
}}
"""


def parameters(book: Model) -> FloatArray:
    """Return a plausible tire's parameter vector, every coefficient off zero."""
    values = {name: card.generic or 0.01 for name, card in book.coefficients.items()}
    values |= {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
    return np.array([values.get(name, 0.0) for name in book.parameters])


def points(book: Model, n: int) -> FloatArray:
    """Return n random rows without turn slip, shape (n_inputs, n)."""
    rng = np.random.default_rng(1)
    ranges = RANGES | {"Fz": (500.0, 7000.0), "phit": (0.0, 0.0)}
    return np.stack([rng.uniform(*ranges[quantity.name], n) for quantity in book.inputs])


def casadi_c(book: Model, values: FloatArray) -> Callable[[FloatArray], object]:
    """Return CasADi's own C code of the same lines, compiled with -O2, parameters folded in."""
    module = casadi_module(book)
    x = ca.SX.sym("x", len(book.inputs))
    lines = getattr(module, "forces_straight", module.forces)
    function = ca.Function("forces", [x], [lines(x, ca.DM(values))])
    with tempfile.TemporaryDirectory() as folder:
        generator = ca.CodeGenerator("forces.c")
        generator.add(function)
        generator.generate(folder + "/")
        source = Path(folder) / "forces.c"
        loop = LOOP.format(inputs=len(book.inputs), outputs=len(book.outputs))
        source.write_text(source.read_text() + loop)
        rows = ctypes.CDLL(str(shared_library("casadi_forces", [source], flags=["-fvisibility=default"]))).rows
    work = np.empty(function.sz_w() + 1)

    def run(columns: FloatArray) -> object:
        n = columns.shape[1]
        table, results = np.ascontiguousarray(columns.T), np.empty((n, len(book.outputs)))
        rows(ctypes.c_size_t(n), *(ctypes.c_void_p(array.ctypes.data) for array in (table, results, work)))
        return results

    return run


def lambdified(book: Model, values: FloatArray) -> Callable[[FloatArray], object]:
    """Return SymPy's way: lines substituted by its own elimination of common subexpressions, in NumPy."""
    lines = reaching(book.lines(straight=True), [quantity.name for quantity in book.outputs])
    known = dict(zip((sp.Symbol(name, real=True) for name in book.parameters), values.tolist(), strict=True))
    inputs = [quantity.symbol for quantity in book.inputs]
    steps = [(line.symbol, line.expression.xreplace(known)) for line in lines]
    outputs = [quantity.symbol for quantity in book.outputs]
    own = [{"sgn": np.sign, "sgn1": lambda x: np.where(x >= 0, 1.0, -1.0), "absolute": np.abs}, "numpy"]
    function = sp.lambdify(inputs, outputs, modules=own, cse=lambda _: (steps, outputs))
    return lambda columns: function(*columns)


def in_chunks(routine: Callable[[FloatArray, FloatArray], object], columns: FloatArray, values: FloatArray) -> None:
    """Go through the rows as a fit does: a Jacobian is used and forgotten while it is in the cache."""
    for start in range(0, columns.shape[1], 64):
        routine(columns[:, start : start + 64], values)


def contenders(book: Model, values: FloatArray) -> dict[str, Callable[[FloatArray], object]]:
    """Return everything that is compared, by name."""
    numpy, scalar, one, two = (
        code_for(book, language, threads) for language, threads in (("numpy", 1), ("c", 1), ("batch", 1), ("batch", 2))
    )
    return {
        CASADI: casadi_c(book, values),
        "SymPy lambdify, cse": lambdified(book, values),
        "NumPy, chunks": lambda x: numpy.forces(x, values),
        "scalar C": lambda x: scalar.forces(x, values),
        "batch": lambda x: one.forces(x, values),
        "batch, 2 threads": lambda x: two.forces(x, values),
        "scalar C, by inputs": lambda x: scalar.jacobian_inputs(x, values),
        "batch, by inputs": lambda x: one.jacobian_inputs(x, values),
        "scalar C, by coefficients": lambda x: in_chunks(scalar.jacobian_parameters, x, values),
        "batch, by coefficients": lambda x: in_chunks(one.jacobian_entries, x, values),
    }


def measured(book: Model, numbers: list[int], repetitions: int) -> dict[int, dict[str, float]]:
    """Return the median time of a point in nanoseconds, by number of points and contender."""
    values = parameters(book)
    racing = contenders(book, values)
    told: dict[int, dict[str, float]] = {}
    slow: set[str] = set()
    for n in numbers:
        rows = points(book, n)
        times: dict[str, list[float]] = {name: [] for name in racing if name not in slow}
        calls = max(1, 2000 // n)
        for repetition in range(repetitions + 1):  # the first warms up
            for name in list(times):
                start = time.perf_counter()
                for _ in range(calls):
                    racing[name](rows)
                taken = (time.perf_counter() - start) / calls
                if repetition:
                    times[name].append(taken / n * 1e9)
                if 10 * taken > PATIENCE:
                    slow.add(name)
        told[n] = {name: statistics.median(spans) for name, spans in times.items()}
    return told


def table(told: dict[int, dict[str, float]]) -> str:
    """Return the times and their ratios to CasADi's C as text."""
    names = list(next(iter(told.values())))
    lines = ["ns per point (share of CasADi's C)".ljust(36) + "".join(f"{n:>18,}" for n in told)]
    for name in names:
        cells = []
        for row in told.values():
            shown = f"{row[name]:.1f} ({row[name] / row[CASADI]:.2f})" if name in row and CASADI in row else "-"
            cells.append(f"{shown:>18}")
        lines.append(name.ljust(36) + "".join(cells))
    return "\n".join(lines)


def main() -> None:
    """Measure and tell."""
    parser = argparse.ArgumentParser(description="How long a point takes.")
    parser.add_argument("--model", default="mf61")
    parser.add_argument("--points", default="100,1000,10000,100000,1000000")
    parser.add_argument("--repetitions", type=int, default=7)
    parser.add_argument("--json", type=Path, help="write the times here, too")
    given = parser.parse_args()
    book = book_of(given.model)
    told = measured(book, [int(n) for n in given.points.split(",")], given.repetitions)
    print(f"{book.title}: {len(book.outputs)} outputs, {len(book.coefficients)} coefficients\n\n{table(told)}")
    if given.json:
        given.json.write_text(json.dumps({str(n): row for n, row in told.items()}, indent=2) + "\n")


if __name__ == "__main__":
    main()
