"""CPU time of a fit: comparison with SciPy's trust-region solver with the same Jacobian, and growth with the rows.

A complete MF6.1 tire on the virtual bench with noise, from generic values. CPU seconds of one process with one BLAS
thread. SciPy uses the same Jacobian and only the bounds. The final cost is reported as well, because a solver that is
faster has to reach the same optimum. A derivative pass is one evaluation of gradient and J^T W J: in the compiled
kernel, and from the Jacobian of 256 rows at a time. As a program it fits a number of rows and prints time and memory.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "fitting"))
from known_tires import CHANNELS, NAMED, NOMINAL, SIZES, VALUES, known_tire, recorded

from tirefmu.fitting import fit
from tirefmu.fitting.constraints.constraint_functions import ConstraintFunctions
from tirefmu.fitting.constraints.physical import chosen_constraints, grid, operating_range
from tirefmu.fitting.problem.rows import Rows
from tirefmu.fitting.problem.weighted_residuals import Problem
from tirefmu.fitting.solvers.ipopt import solve
from tirefmu.measurements import Recording
from tirefmu.tires import Tire
from tirefmu.tires.code import CHUNK, WeightedRows
from tirefmu.tires.code.normal_equations import equations_by_chunks

FloatArray = npt.NDArray[np.float64]
MODEL = "mf61"
#: Upper limit of the points of one constraint on its fine grid; otherwise the coarse grid is used.
MAX_POINTS = 50


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return the CPU seconds of a call and its result."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def median(work: Callable[[], Any], times: int = 3) -> tuple[float, Any]:
    """Return the median time of several runs, and the last result."""
    runs = [timed(work) for _ in range(times)]
    return statistics.median(seconds for seconds, _ in runs), runs[-1][1]


def joint_problem(recording: Recording) -> tuple[Problem, FloatArray, FloatArray, FloatArray]:
    """Return one problem for all coefficients of MF6.1, with scaled initial values and bounds."""
    truth = known_tire(MODEL)
    model = truth.symbolic_model
    free = tuple(name for name in VALUES if name in model.coefficients and name not in NAMED)
    declarations = [model.coefficients[name] for name in free]
    tire = Tire(MODEL, {name: truth.values[name] for name in NAMED}, signs="adapted-sae")
    rows = Rows.of(recording.with_signs("adapted-sae").table, tire, CHANNELS)
    noise = np.array([SIZES.get(name, np.inf) for name in tire.outputs])
    weights = (1.0 / (noise**2 * len(CHANNELS) * len(rows)))[None, :]
    start = np.array([declared.generic for declared in declarations])
    scale = np.array([max(abs(c.generic), 0.25 * (c.upper - c.lower), 1e-3) for c in declarations])
    bounds = (np.array([getattr(declared, side) for declared in declarations]) / scale for side in ("lower", "upper"))
    return Problem(tire, rows, free, weights, scale), start / scale, *bounds


def constraints(problem: Problem, recording: Recording) -> list[Any]:
    """Return the physical constraints with the points at which they are imposed."""
    tire = problem.tire
    ranges = operating_range(recording.with_signs("adapted-sae").table, tire)
    nominal = {name: tire.nominal(name) for name in tire.inputs}
    every = [constraint for channel in CHANNELS for constraint in chosen_constraints(MODEL)[channel]]
    fine = [(constraint, grid(constraint, ranges, nominal, density=1)) for constraint in every]
    return [
        (constraint, points if points.shape[1] <= MAX_POINTS else grid(constraint, ranges, nominal, density=0))
        for constraint, points in fine
    ]


def by_scipy(problem: Problem, start: FloatArray, lower: FloatArray, upper: FloatArray) -> Any:
    """Minimize with SciPy's trf, with the residuals of all channels and their exact compiled Jacobian."""
    force, coefficient = problem._code.entries
    index = {int(column): i for i, column in enumerate(problem.columns)}
    chosen = np.array([k for k, c in enumerate(coefficient) if int(c) in index and problem.weights[0, force[k]] > 0])
    channels = sorted(set(force[chosen].tolist()))
    block = np.array([channels.index(channel) for channel in force[chosen]])
    column = np.array([index[int(c)] for c in coefficient[chosen]])
    n = len(problem.rows)
    root = np.sqrt(problem.weights[0])
    inputs = np.ascontiguousarray(problem.tire.effective_inputs(problem.rows.inputs))

    def residual(x: FloatArray) -> FloatArray:
        return np.concatenate([root[channel] * problem.residual(x)[channel] for channel in channels])

    def jacobian(x: FloatArray) -> FloatArray:
        table = np.zeros((len(channels), n, len(x)))
        factors = (root[force[chosen]] * problem.reach[column])[:, None]
        for rows, entries in problem._code.jacobian_chunks(inputs, problem.parameters(x), CHUNK):
            table[block, rows, column] = entries[chosen] * factors
        return table.reshape(-1, len(x))

    initial = np.clip(start, lower + 1e-9, upper - 1e-9)
    return least_squares(residual, initial, jacobian, bounds=(lower, upper), method="trf", x_scale=1.0)


def derivative_passes(problem: Problem, x: FloatArray) -> dict[str, float]:
    """Return the CPU time per row of gradient and J^T W J, in s: by the kernel, and from the Jacobian of few rows."""
    block, _, root, residual = next(problem._residuals(x))
    rows = WeightedRows(block.inputs, [entries for entries, _ in problem._entries], root, residual)
    by_chunks, _ = median(lambda: equations_by_chunks(problem._code, rows, problem.parameters(x)))
    in_kernel, _ = median(lambda: problem.by_output(x))
    return {"in the kernel": in_kernel / len(problem.rows), "by chunks": by_chunks / len(block.group)}


def compare(rows: int) -> dict[str, Any]:
    """Return CPU seconds, final cost and evaluations of each solver."""
    recording = recorded(known_tire(MODEL), rows)
    fit([recorded(known_tire(MODEL), 2000)], MODEL, nominal=NOMINAL)  # compiled code and caches are ready
    problem, start, lower, upper = joint_problem(recording)
    imposed = constraints(problem, recording)
    problem.derivatives(start)
    passes = derivative_passes(problem, start)
    scipy_seconds, found = timed(lambda: by_scipy(problem, start, lower, upper))
    joint_seconds, solution = median(lambda: solve(problem, start, lower, upper, imposed))
    all_rows = {"screening": False, "rows": "equal"}
    stages, result = median(lambda: fit([recording], MODEL, nominal=NOMINAL, **all_rows))
    full_seconds, full = median(lambda: fit([recording], MODEL, nominal=NOMINAL))

    def cost_of(result: Any) -> float:
        values = result.tire.in_signs("adapted-sae").values
        return problem.cost(np.array([values[name] for name in problem.free]) / problem.scale)

    return {
        "rows": len(problem.rows), "coefficients": len(problem.free),
        "constraints": len(ConstraintFunctions(problem, imposed)),
        "scipy trf": {"seconds": scipy_seconds, "cost": float(found.cost), "evaluations": int(found.njev),
                      "satisfied": "bounds"},
        "joint problem": {"seconds": joint_seconds, "cost": solution.cost, "evaluations": solution.iterations,
                          "satisfied": "all" if solution.converged else solution.reason},
        **{name: {"seconds": seconds, "cost": cost_of(fitted), "satisfied": "all" if fitted.ok else fitted.status,
                  "evaluations": sum(stage.iterations for stage in fitted.stages)}
           for name, seconds, fitted in (("fit of all rows", stages, result), ("full fit", full_seconds, full))},
        "derivative pass": passes,
        "stages": [{"name": stage.name, "rows": stage.rows, "free": stage.free, "iterations": stage.iterations}
                   for stage in full.stages],
    }  # fmt: skip


def single_fit(rows: int) -> dict[str, float]:
    """Fit a number of rows in this process and return the CPU seconds and the peak memory of the process."""
    fit([recorded(known_tire(MODEL), 2000)], MODEL, nominal=NOMINAL)
    recording = recorded(known_tire(MODEL), rows)
    seconds, result = timed(lambda: fit([recording], MODEL, nominal=NOMINAL))
    # Not ru_maxrss, which begins with the memory of the process that started this one.
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines())
    peak = int(status["VmHWM"].split()[0]) / 1024
    return {"rows": len(recording), "seconds": seconds, "peak MB": peak, "ok": float(result.ok)}


def growth(numbers: Sequence[int]) -> list[dict[str, float]]:
    """Fit each number of rows in a separate process, so that its peak memory is that of the fit."""
    command = [sys.executable, __file__]
    runs = [subprocess.run([*command, str(n)], check=True, capture_output=True, text=True) for n in numbers]
    return [json.loads(run.stdout.splitlines()[-1]) for run in runs]


if __name__ == "__main__":
    print(json.dumps(single_fit(int(sys.argv[1]))))
