"""How long a fit takes: ours beside SciPy's trust-region solver with the same Jacobian, and over many rows.

A complete MF6.1 tire on the virtual bench with noise, from generic values. CPU seconds of one process, one thread of
BLAS; SciPy gets the very Jacobian that ours uses, and only the bounds. Its end is told beside ours: who is faster
has to arrive, too.

    python benchmarks/fitting.py [--rows 20000] [--growth 10000,100000,1000000] [--json FILE]
"""

from __future__ import annotations

import argparse
import json
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "fitting"))
from known_tires import CHANNELS, NAMED, NOMINAL, SIZES, VALUES, known_tire, recorded

from tirefmu.fitting import fit
from tirefmu.fitting.constraints.constraint_functions import ConstraintFunctions
from tirefmu.fitting.constraints.physical import chosen_constraints, grid, operating_range
from tirefmu.fitting.problem.weighted_residuals import CHUNK, Problem, Rows
from tirefmu.fitting.solvers.ipopt import solve
from tirefmu.measurements import Recording
from tirefmu.tires import Tire

FloatArray = npt.NDArray[np.float64]
MODEL = "mf61"
#: Points at which one condition is imposed, if its finer grid has no more.
MOST_POINTS = 50


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return the CPU seconds of this process and what came of them."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def median(work: Callable[[], Any], times: int = 3) -> tuple[float, Any]:
    """Return the median of some runs, which short ones need."""
    runs = [timed(work) for _ in range(times)]
    return statistics.median(seconds for seconds, _ in runs), runs[-1][1]


def joint_problem(recording: Recording) -> tuple[Problem, FloatArray, FloatArray, FloatArray]:
    """Return all of MF6.1 in one problem with generic start values, and its bounds, all scaled."""
    truth = known_tire(MODEL)
    book = truth.book
    free = tuple(name for name in VALUES if name in book.coefficients and name not in NAMED)
    cards = [book.coefficients[name] for name in free]
    tire = Tire(MODEL, {name: truth.values[name] for name in NAMED}, signs="adapted-sae")
    rows = Rows.of(recording.with_signs("adapted-sae").table, tire, CHANNELS)
    noise = np.array([SIZES.get(name, np.inf) for name in tire.outputs])
    weights = (1.0 / (noise**2 * len(CHANNELS) * len(rows)))[None, :]
    start = np.array([card.generic for card in cards])
    scale = np.array([max(abs(c.generic), 0.25 * (c.upper - c.lower), 1e-3) for c in cards])
    bounds = (np.array([getattr(card, side) for card in cards]) / scale for side in ("lower", "upper"))
    return Problem(tire, rows, free, weights, scale), start / scale, *bounds


def conditions(problem: Problem, recording: Recording) -> list[Any]:
    """Return the model's conditions where a fit imposes them, and at more points where these are few."""
    tire = problem.tire
    ranges = operating_range(recording.with_signs("adapted-sae").table, tire.inputs)
    nominal = {name: tire.nominal(name) for name in tire.inputs}
    every = [condition for channel in CHANNELS for condition in chosen_constraints(MODEL)[channel]]
    finer = [(condition, grid(condition, ranges, nominal, density=1)) for condition in every]
    return [
        (condition, points if points.shape[1] <= MOST_POINTS else grid(condition, ranges, nominal, density=0))
        for condition, points in finer
    ]


def by_scipy(problem: Problem, start: FloatArray, lower: FloatArray, upper: FloatArray) -> Any:
    """Minimize with trf: the residuals of all channels, their exact Jacobian by the same compiled code."""
    force, coefficient = problem._code.entries
    place = {int(column): i for i, column in enumerate(problem.columns)}
    chosen = np.array([k for k, c in enumerate(coefficient) if int(c) in place and problem.weights[0, force[k]] > 0])
    channels = sorted(set(force[chosen].tolist()))
    block = np.array([channels.index(channel) for channel in force[chosen]])
    column = np.array([place[int(c)] for c in coefficient[chosen]])
    n = len(problem.rows)
    root = np.sqrt(problem.weights[0])

    def residual(x: FloatArray) -> FloatArray:
        return np.concatenate([root[channel] * problem.residual(x)[channel] for channel in channels])

    def jacobian(x: FloatArray) -> FloatArray:
        table = np.zeros((len(channels), n, len(x)))
        factors = (root[force[chosen]] * problem.reach[column])[:, None]
        for rows, entries in problem._code.jacobian_chunks(problem._inputs, problem.parameters(x), CHUNK):
            table[block, rows, column] = entries[chosen] * factors
        return table.reshape(-1, len(x))

    within = np.clip(start, lower + 1e-9, upper - 1e-9)
    return least_squares(residual, within, jacobian, bounds=(lower, upper), method="trf", x_scale=1.0)


def race(rows: int) -> dict[str, Any]:
    """Return what each way takes and where it ends."""
    recording = recorded(known_tire(MODEL), rows)
    fit([recorded(known_tire(MODEL), 2000)], MODEL, nominal=NOMINAL)  # compiled code and caches are there
    problem, start, lower, upper = joint_problem(recording)
    imposed = conditions(problem, recording)
    problem.derivatives(start)
    theirs, found = timed(lambda: by_scipy(problem, start, lower, upper))
    joint, solution = median(lambda: solve(problem, start, lower, upper, imposed))
    as_they_are = {"screening": False, "rows": "equal"}
    stages, result = median(lambda: fit([recording], MODEL, nominal=NOMINAL, **as_they_are))
    whole, careful = median(lambda: fit([recording], MODEL, nominal=NOMINAL))

    def cost_of(result: Any) -> float:
        values = result.tire.in_signs("adapted-sae").values
        return problem.cost(np.array([values[name] for name in problem.free]) / problem.scale)

    return {
        "rows": len(problem.rows), "coefficients": len(problem.free),
        "conditions": len(ConstraintFunctions(problem, imposed)),
        "scipy trf": {"seconds": theirs, "cost": float(found.cost), "evaluations": int(found.njev), "kept": "bounds"},
        "joint problem": {"seconds": joint, "cost": solution.cost, "evaluations": solution.iterations,
                          "kept": "all" if solution.converged else solution.reason},
        **{name: {"seconds": seconds, "cost": cost_of(one), "kept": "all" if one.ok else one.status,
                  "evaluations": sum(stage.iterations for stage in one.stages)}
           for name, seconds, one in (("fit of all rows", stages, result), ("whole fit", whole, careful))},
    }  # fmt: skip


def alone(rows: int) -> dict[str, float]:
    """Fit so many rows in this process; return the seconds of the fit and the largest memory it ever had."""
    fit([recorded(known_tire(MODEL), 2000)], MODEL, nominal=NOMINAL)
    recording = recorded(known_tire(MODEL), rows)
    seconds, result = timed(lambda: fit([recording], MODEL, nominal=NOMINAL))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {"rows": len(recording), "seconds": seconds, "peak MB": peak, "ok": float(result.ok)}


def growth(numbers: list[int]) -> list[dict[str, float]]:
    """Fit every number of rows in a process of its own, so that memory is its own, too."""
    command = [sys.executable, __file__, "--alone"]
    runs = [subprocess.run([*command, str(n)], check=True, capture_output=True, text=True) for n in numbers]
    return [json.loads(run.stdout.splitlines()[-1]) for run in runs]


def told(raced: dict[str, Any], grown: list[dict[str, float]]) -> str:
    """Return both as text."""
    lines = []
    if raced:
        slowest = raced["scipy trf"]["seconds"]
        lines.append(f"{raced['rows']} rows, {raced['coefficients']} coefficients, {raced['conditions']} conditions")
        lines.append(f"{'':16}{'CPU s':>9}{'ratio':>8}{'cost':>11}{'Jacobians':>11}  conditions kept")
        for name in ("scipy trf", "joint problem", "fit of all rows", "whole fit"):
            way = raced[name]
            ratio = f"1/{slowest / way['seconds']:.1f}"
            lines.append(
                f"{name:16}{way['seconds']:9.2f}{ratio:>8}{way['cost']:11.6f}{way['evaluations']:11}  {way['kept']}"
            )
    for run in grown:
        each = 1e6 * run["seconds"] / run["rows"]
        lines.append(
            f"{run['rows']:9,.0f} rows{run['seconds']:9.2f} s CPU{each:8.1f} us a row{run['peak MB']:8.0f} MB at most"
        )
    return "\n".join(lines)


def main() -> None:
    """Measure and tell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=20_000, help="of the race; 0: none")
    parser.add_argument("--growth", default="10000,100000,1000000", help="numbers of rows; '': none")
    parser.add_argument("--alone", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--json", type=Path, help="write the figures here, too")
    given = parser.parse_args()
    with threadpool_limits(limits=1, user_api="blas"):
        if given.alone:
            print(json.dumps(alone(given.alone)))
            return
        raced = race(given.rows) if given.rows else {}
        grown = growth([int(n) for n in given.growth.split(",") if n])
    print(told(raced, grown))
    if given.json:
        given.json.write_text(json.dumps({"race": raced, "growth": grown}, indent=2) + "\n")


if __name__ == "__main__":
    main()
