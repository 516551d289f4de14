"""Evaluation time per point: the generated code and the C code of CasADi, in one run.

CPU time of the process. Repetitions are interleaved, so that other load of the machine affects all equally. The result
is the median.
"""

from __future__ import annotations

import ctypes
import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import casadi as ca
import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.model import Model
from tirefmu.tires.code import CHUNK, Code, code_for
from tirefmu.tires.code.casadi_code import casadi_expression
from tirefmu.tires.code.compiler import shared_library

FloatArray = npt.NDArray[np.float64]
RANGES = {"kappa": (-0.3, 0.3), "alpha": (-0.3, 0.3), "gamma": (-0.1, 0.1), "p": (1.8e5, 2.8e5), "V": (8.0, 30.0)}
CASADI = "CasADi C, -O2"
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
    forces = casadi_expression(model, "forces", x, ca.DM(values), plain=True)
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


def in_calls(routine: Callable[[FloatArray, FloatArray], object], values: FloatArray, columns: FloatArray) -> None:
    """Evaluate the rows in calls of 64 rows, each with memory of its own."""
    for start in range(0, columns.shape[1], 64):
        routine(columns[:, start : start + 64], values)


def in_chunks(code: Code, values: FloatArray, columns: FloatArray) -> None:
    """Evaluate the Jacobian by the coefficients chunk by chunk: it is used while it is in the cache."""
    for _ in code.jacobian_chunks(columns, values, CHUNK):
        pass


def candidates(model: Model, values: FloatArray) -> dict[str, Callable[[FloatArray], object]]:
    """Return the compared functions of a table of inputs, by name."""
    scalar, batch = code_for(model, "c"), code_for(model, "batch")
    return {
        CASADI: casadi_c(model, values),
        "scalar C": lambda columns: scalar.forces(columns, values),
        "batch": lambda columns: batch.forces(columns, values),
        "batch, by inputs": lambda columns: batch.jacobian_inputs(columns, values),
        "batch, by coefficients, 64 rows a call": partial(in_calls, batch.jacobian_entries, values),
        "batch, by coefficients": partial(in_chunks, batch, values),
    }


def evaluation_times(
    model: Model, numbers: Sequence[int], repetitions: int, only: Sequence[str] = ()
) -> dict[int, dict[str, float]]:
    """Return the median time per point in nanoseconds, by number of points and candidate.

    `only`: the names of the candidates; all of them if empty.
    """
    values = parameters(model)
    functions = {name: work for name, work in candidates(model, values).items() if not only or name in only}
    times_of: dict[int, dict[str, float]] = {}
    for n in numbers:
        rows = points(model, n)
        times: dict[str, list[float]] = {name: [] for name in functions}
        calls = max(1, 20_000 // n)
        for repetition in range(repetitions + 1):  # the first one is a warm-up
            for name, function in functions.items():
                start = time.process_time()
                for _ in range(calls):
                    function(rows)
                if repetition:
                    times[name].append((time.process_time() - start) / calls / n * 1e9)
        times_of[n] = {name: statistics.median(spans) for name, spans in times.items()}
    return times_of
