"""Evaluation time per point: C code of CasADi, SymPy's lambdify and the generated code, in one run.

CPU time of the process. Repetitions are interleaved, so that other load of the machine affects all equally. The result
is the median.

    python benchmarks/evaluation.py [--model mf61] [--points 100,10000,1000000] [--only NAME;...] [--json FILE]
"""

from __future__ import annotations

import argparse
import ctypes
import json
import statistics
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import casadi as ca
import numpy as np
import numpy.typing as npt
import sympy as sp

from tirefmu.symbolic.model import Model
from tirefmu.symbolic.model.lines import reaching
from tirefmu.symbolic.models import model_named
from tirefmu.tires.code import CHUNK, Code, code_for
from tirefmu.tires.code.casadi_code import casadi_expression
from tirefmu.tires.code.compiler import shared_library

FloatArray = npt.NDArray[np.float64]
RANGES = {"kappa": (-0.3, 0.3), "alpha": (-0.3, 0.3), "gamma": (-0.1, 0.1), "p": (1.8e5, 2.8e5), "V": (8.0, 30.0)}
CASADI = "CasADi C, -O2"
#: s, time limit of one repetition. A slower candidate is skipped for larger numbers of points.
TIME_LIMIT = 30.0
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


def parameters(model: Model) -> FloatArray:
    """Return the parameter vector of a plausible tire with all coefficients different from 0."""
    values = {name: declared.generic or 0.01 for name, declared in model.coefficients.items()}
    values |= {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
    return np.array([values.get(name, 0.0) for name in model.parameters])


def points(model: Model, n: int) -> FloatArray:
    """Return n random rows without turn slip, shape (n_inputs, n)."""
    rng = np.random.default_rng(1)
    ranges = RANGES | {"Fz": (500.0, 7000.0), "phit": (0.0, 0.0)}
    return np.stack([rng.uniform(*ranges[quantity.name], n) for quantity in model.inputs])


def casadi_c(model: Model, values: FloatArray) -> Callable[[FloatArray], object]:
    """Return the C code that CasADi generates for the same equations, compiled with -O2, parameters as constants."""
    x = ca.SX.sym("x", len(model.inputs))
    forces = casadi_expression(model, "forces", x, ca.DM(values), straight=True)
    function = ca.Function("forces", [x], [forces])
    with tempfile.TemporaryDirectory() as folder:
        generator = ca.CodeGenerator("forces.c")
        generator.add(function)
        generator.generate(folder + "/")
        source = Path(folder) / "forces.c"
        loop = LOOP.format(inputs=len(model.inputs), outputs=len(model.outputs))
        source.write_text(source.read_text() + loop)
        rows = ctypes.CDLL(str(shared_library("casadi_forces", [source], flags=["-fvisibility=default"]))).rows
    work = np.empty(function.sz_w() + 1)

    def run(columns: FloatArray) -> object:
        n = columns.shape[1]
        table, results = np.ascontiguousarray(columns.T), np.empty((n, len(model.outputs)))
        rows(ctypes.c_size_t(n), *(ctypes.c_void_p(array.ctypes.data) for array in (table, results, work)))
        return results

    return run


def lambdified(model: Model, values: FloatArray) -> Callable[[FloatArray], object]:
    """Return the NumPy function of SymPy's lambdify, with the equations as common subexpressions."""
    lines = reaching(model.lines(straight=True), [quantity.name for quantity in model.outputs])
    constants = dict(zip((sp.Symbol(name, real=True) for name in model.parameters), values.tolist(), strict=True))
    inputs = [quantity.symbol for quantity in model.inputs]
    steps = [(line.symbol, line.expression.xreplace(constants)) for line in lines]
    outputs = [quantity.symbol for quantity in model.outputs]
    modules = [{"sgn": np.sign, "sgn1": lambda x: np.where(x >= 0, 1.0, -1.0), "absolute": np.abs}, "numpy"]
    function = sp.lambdify(inputs, outputs, modules=modules, cse=lambda _: (steps, outputs))
    return lambda columns: function(*columns)


def in_calls(routine: Callable[[FloatArray, FloatArray], object], values: FloatArray, columns: FloatArray) -> None:
    """Evaluate the rows in calls of 64 rows, each with memory of its own."""
    for start in range(0, columns.shape[1], 64):
        routine(columns[:, start : start + 64], values)


def in_chunks(code: Code, values: FloatArray, columns: FloatArray) -> None:
    """Evaluate the Jacobian by the coefficients chunk by chunk: it is used while it is in the cache."""
    for _ in code.jacobian_chunks(columns, values, CHUNK):
        pass


def candidates(model: Model, values: FloatArray, only: list[str]) -> dict[str, Callable[[FloatArray], object]]:
    """Return the compared functions by name: all, or the chosen ones and the C code of CasADi."""

    def numpy() -> Code:
        return code_for(model, "numpy")

    def scalar() -> Code:
        return code_for(model, "c")

    def batch() -> Code:
        return code_for(model, "batch")

    builders: dict[str, Callable[[], Callable[[FloatArray], object]]] = {
        CASADI: lambda: casadi_c(model, values),
        "SymPy lambdify, cse": lambda: lambdified(model, values),
        "NumPy, chunks": lambda: forces_of(numpy(), values),
        "scalar C": lambda: forces_of(scalar(), values),
        "batch": lambda: forces_of(batch(), values),
        "scalar C, by inputs": lambda: by_inputs_of(scalar(), values),
        "batch, by inputs": lambda: by_inputs_of(batch(), values),
        "scalar C, by coefficients": lambda: partial(in_calls, scalar().jacobian_parameters, values),
        "batch, by coefficients, 64 rows a call": lambda: partial(in_calls, batch().jacobian_entries, values),
        "batch, by coefficients": lambda: partial(in_chunks, batch(), values),
    }
    return {name: build() for name, build in builders.items() if not only or name in (CASADI, *only)}


def forces_of(code: Code, values: FloatArray) -> Callable[[FloatArray], object]:
    """Return the function of the forces."""
    return lambda columns: code.forces(columns, values)


def by_inputs_of(code: Code, values: FloatArray) -> Callable[[FloatArray], object]:
    """Return the function of the derivatives by the inputs."""
    return lambda columns: code.jacobian_inputs(columns, values)


def measured(model: Model, numbers: list[int], repetitions: int, only: list[str]) -> dict[int, dict[str, float]]:
    """Return the median time per point in nanoseconds, by number of points and candidate."""
    values = parameters(model)
    functions = candidates(model, values, only)
    times_of: dict[int, dict[str, float]] = {}
    slow: set[str] = set()
    for n in numbers:
        rows = points(model, n)
        times: dict[str, list[float]] = {name: [] for name in functions if name not in slow}
        calls = max(1, 20_000 // n)
        for repetition in range(repetitions + 1):  # the first one is a warm-up
            for name in list(times):
                start = time.process_time()
                for _ in range(calls):
                    functions[name](rows)
                taken = (time.process_time() - start) / calls
                if repetition:
                    times[name].append(taken / n * 1e9)
                if 10 * taken > TIME_LIMIT:
                    slow.add(name)
        times_of[n] = {name: statistics.median(spans) for name, spans in times.items()}
    return times_of


def table(measured_times: dict[int, dict[str, float]]) -> str:
    """Return the times and their ratios to the C code of CasADi as text."""
    names = list(next(iter(measured_times.values())))
    lines = ["ns per point (ratio to CasADi's C)".ljust(40) + "".join(f"{n:>18,}" for n in measured_times)]
    for name in names:
        cells = []
        for row in measured_times.values():
            shown = f"{row[name]:.1f} ({row[name] / row[CASADI]:.2f})" if name in row and CASADI in row else "-"
            cells.append(f"{shown:>18}")
        lines.append(name.ljust(40) + "".join(cells))
    return "\n".join(lines)


def main() -> None:
    """Measure and print the times."""
    parser = argparse.ArgumentParser(description="Evaluation time per point.")
    parser.add_argument("--model", default="mf61")
    parser.add_argument("--points", default="100,1000,10000,100000,1000000")
    parser.add_argument("--repetitions", type=int, default=7)
    parser.add_argument("--only", default="", help="candidates, separated by semicolons")
    parser.add_argument("--json", type=Path, help="also write the times to this file")
    given = parser.parse_args()
    model = model_named(given.model)
    only = [name for name in given.only.split(";") if name]
    measured_times = measured(model, [int(n) for n in given.points.split(",")], given.repetitions, only)
    print(
        f"{model.title}: {len(model.outputs)} outputs, {len(model.coefficients)} coefficients\n\n"
        f"{table(measured_times)}"
    )
    if given.json:
        given.json.write_text(json.dumps({str(n): row for n, row in measured_times.items()}, indent=2) + "\n")


if __name__ == "__main__":
    main()
