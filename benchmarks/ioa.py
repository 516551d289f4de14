"""IOA, IPOPT, scipy's trf and SLSQP on the UNICAMP bench program: sum of squares against CPU time, in one run.

    python benchmarks/ioa.py [--iterations 10000] [--seeds 0,1] [--figure FILE.png] [--json FILE]

The bench is virtual: the published small tire at the 297 points of the paper, with white noise of 2 N. All solvers
solve the same problems from the same generic initial values, with the declared bounds and the same compiled code.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.optimize import least_squares, minimize
from threadpoolctl import threadpool_limits

from tirefmu.fitting.problem.rows import Rows
from tirefmu.fitting.problem.weighted_residuals import Problem
from tirefmu.fitting.problem.weights import equal_weights
from tirefmu.fitting.solvers.evolution import Evolution
from tirefmu.fitting.solvers.ipopt import solve
from tirefmu.measurements import ChannelNoise, Noise, Recording, VirtualBench, small_tire_program
from tirefmu.tires import Tire, published
from tirefmu.tires.code import fastest_code

FloatArray = npt.NDArray[np.float64]
NOISE = 2.0  # N, similar to the rms residual of the pure Fx fit in the paper
#: Coefficients that are identifiable at one pressure without camber. The tire has no side force due to kappa.
PURE = {
    "Fx": "PCX1 PDX1 PDX2 PEX1 PEX2 PEX3 PEX4 PKX1 PKX2 PKX3 PHX1 PHX2 PVX1 PVX2",
    "Fy": "PCY1 PDY1 PDY2 PEY1 PEY2 PEY3 PKY1 PKY2 PKY4 PHY1 PHY2 PVY1 PVY2",
}
COMBINED = {"Fx": "RBX1 RBX2 RCX1 REX1 REX2 RHX1", "Fy": "RBY1 RBY2 RBY3 RCY1 REY1 REY2 RHY1 RHY2"}
#: Sums of squares in the paper, N^2, and the corresponding rms over the points of its program, N.
PAPER = {
    "Fx pure": (155.0, 2.2),
    "Fy pure": (863.0, 5.7),
    "Fx combined": (1.7022e4, 7.6),
    "Fy combined": (9.9421e3, 5.8),
}
#: Relative tolerance for a sum of squares to be reached, because the solvers stop at different last digits.
REACHED = 1e-3
#: Number of starts of solvers with restarts: generic values, then random values within the bounds.
STARTS = 10
IOA, ONCE, AGAIN = "IOA, seed {}", "IPOPT", f"IPOPT, {STARTS} starts"
STAGES, TRF, SLSQP = f"IPOPT in stages, {STARTS} starts", "trf, exact Jacobian", "SLSQP, differences"


@dataclass
class Block:
    """One problem of the study: a force, its rows and its free coefficients."""

    title: str
    problem: Problem
    start: FloatArray
    lower: FloatArray
    upper: FloatArray
    output: int

    @property
    def squares(self) -> float:
        """The factor from a cost to a sum of squares in N^2."""
        return 2.0 / float(self.problem.weights[0, self.output])


@dataclass
class Run:
    """The run of a solver: CPU seconds and the lowest sum of squares at each of them."""

    seconds: list[float] = field(default_factory=list)
    lowest: list[float] = field(default_factory=list)
    total: float = 0.0

    def reaches(self, target: float) -> float:
        """Return the CPU seconds until a sum of squares was reached; infinite if it was not."""
        return next((s for s, low in zip(self.seconds, self.lowest, strict=True) if low <= target), float("inf"))


def bench(tire: Tire, seed: int) -> Recording:
    """Return a recording of the program of the paper with Fx and Fy only."""
    noise = Noise({name: ChannelNoise(constant=NOISE) for name in ("Fx", "Fy")})
    recording = VirtualBench(tire, noise, seed).run(small_tire_program()).with_signs("adapted-sae")
    return replace(recording, table=recording.table.drop(columns=["Mx", "My", "Mz"]))


def generic_tire(truth: Tire) -> Tire:
    """Return a tire of this size with the declared initial values, at one pressure."""
    names = " ".join([*PURE.values(), *COMBINED.values()]).split()
    values = {name: truth.symbolic_model.coefficients[name].generic for name in names}
    pressure = truth.values["INFLPRES"]
    given = {"UNLOADED_RADIUS": truth.values["UNLOADED_RADIUS"], "FNOMIN": truth.values["FNOMIN"]}
    effects = truth.has - {"pressure_stiffness", "pressure_friction"}
    values = {**values, **given, "NOMPRES": pressure, "INFLPRES": pressure}
    return Tire(truth.model, values, effects=effects, signs="adapted-sae")


def block(title: str, tire: Tire, table: pd.DataFrame, free: str, *, generic: bool = True) -> Block:
    """Return a problem. The first word of its title is its force."""
    names, channel = tuple(free.split()), title.split()[0]
    declarations = [tire.symbolic_model.coefficients[name] for name in names]
    first = np.array([declared.generic if generic else tire.values[declared.name] for declared in declarations])
    lower, upper = np.array([[declared.lower, declared.upper] for declared in declarations]).T
    scale = np.maximum(np.abs(first), 0.25 * (upper - lower))
    rows = Rows.of(table, tire, [channel])
    problem = Problem(tire, rows, names, equal_weights(rows), scale)
    return Block(title, problem, first / scale, lower / scale, upper / scale, tire.outputs.index(channel))


class Clock:
    """CPU seconds since the start of a solver, and the results at each of them."""

    def __init__(self) -> None:
        self.run, self._start = Run(), time.process_time()

    def record(self, squares: float) -> None:
        """Record a sum of squares if it is the lowest so far."""
        if not self.run.lowest or squares < self.run.lowest[-1]:
            self.run.seconds.append(time.process_time() - self._start)
            self.run.lowest.append(squares)

    def stop(self) -> Run:
        """Return the completed run."""
        self.run.total = time.process_time() - self._start
        return self.run


def by_ioa(given: Block, iterations: int, seed: int) -> tuple[Run, FloatArray]:
    """Solve by IOA up to the last iteration, as in the paper."""
    clock = Clock()
    search = Evolution(iterations, seed, run_to_limit=True)
    found = search(
        given.problem, given.start, given.lower, given.upper, [],
        progress=lambda count, cost: clock.record(cost * given.squares),
    )  # fmt: skip
    return clock.stop(), found.x


def by_ipopt(given: Block, starts: int) -> tuple[Run, FloatArray]:
    """Solve from the generic values, then from random values within the bounds."""
    clock, random = Clock(), np.random.default_rng(0)
    best, lowest = given.start, np.inf
    for number in range(starts):
        random_start = given.lower + random.random(len(given.start)) * (given.upper - given.lower)
        solution = solve(
            given.problem, random_start if number else given.start, given.lower, given.upper, [], ridge=0.0,
            progress=lambda count, cost: clock.record(cost * given.squares),
        )  # fmt: skip
        clock.record(solution.cost * given.squares)
        if solution.cost < lowest:
            best, lowest = solution.x, solution.cost
    return clock.stop(), best


def by_trf(given: Block) -> tuple[Run, FloatArray]:
    """Solve by scipy's bounded least squares with the exact Jacobian of the same compiled code."""
    problem, clock = given.problem, Clock()
    code = fastest_code(problem.tire.symbolic_model)
    inputs, root = problem.tire.effective_inputs(problem.rows.inputs), np.sqrt(problem.weights[0, given.output])
    force, coefficient = code.entries
    index = {int(column): i for i, column in enumerate(problem.columns)}
    entries = [i for i, (f, c) in enumerate(zip(force, coefficient, strict=True)) if f == given.output and c in index]
    free = [index[int(coefficient[i])] for i in entries]

    def residual(x: FloatArray) -> FloatArray:
        values: FloatArray = root * problem.residual(x)[given.output]
        clock.record(float(values @ values) / root**2)
        return values

    def jacobian(x: FloatArray) -> FloatArray:
        matrix = np.zeros((len(problem.rows), len(x)))
        derivatives = code.jacobian_entries(inputs, problem.parameters(x))[entries]
        matrix[:, free] = root * problem.reach[free] * derivatives.T
        return matrix

    bounds = (given.lower, given.upper)
    found = least_squares(residual, given.start, jacobian, bounds, "trf", xtol=1e-10, ftol=1e-10, gtol=1e-10)
    return clock.stop(), found.x


def by_slsqp(given: Block) -> tuple[Run, FloatArray]:
    """Solve by scipy's SLSQP with finite differences."""
    clock = Clock()

    def cost(x: FloatArray) -> float:
        value = given.problem.cost(x)
        clock.record(value * given.squares)
        return value

    bounds = list(zip(given.lower, given.upper, strict=True))
    found = minimize(cost, given.start, method="SLSQP", bounds=bounds, options={"maxiter": 1000, "ftol": 1e-10})
    return clock.stop(), found.x


def by_stages(given: Block, stages: tuple[Block, Block]) -> tuple[Run, FloatArray]:
    """Solve pure slip, then combined slip from several starts, then everything from each solution, as in the paper."""
    clock, random = Clock(), np.random.default_rng(0)
    pure, combined = stages
    first = solve(pure.problem, pure.start, pure.lower, pure.upper, [], ridge=0.0)
    combined = with_tire(combined, solved_tire(pure, first.x))
    best, lowest = given.start, np.inf
    for number in range(STARTS):
        random_start = combined.lower + random.random(len(combined.start)) * (combined.upper - combined.lower)
        second = solve(
            combined.problem, random_start if number else combined.start, combined.lower, combined.upper, [], ridge=0.0
        )
        clock.record(second.cost * combined.squares)
        start = np.concatenate([first.x * pure.problem.scale, second.x * combined.problem.scale]) / given.problem.scale
        last = solve(
            given.problem, start, given.lower, given.upper, [], ridge=0.0,
            progress=lambda count, cost: clock.record(cost * given.squares),
        )  # fmt: skip
        clock.record(last.cost * given.squares)
        if last.cost < lowest:
            best, lowest = last.x, last.cost
    return clock.stop(), best


def solved_tire(solved: Block, x: FloatArray) -> Tire:
    """Return the tire of a problem with the values of its solution."""
    values = dict(zip(solved.problem.free, (x * solved.problem.scale).tolist(), strict=True))
    return replace(solved.problem.tire, values={**solved.problem.tire.values, **values})


def with_tire(given: Block, tire: Tire) -> Block:
    """Return the problem with the fixed coefficients of another tire."""
    problem = given.problem
    return replace(given, problem=Problem(tire, problem.rows, problem.free, problem.weights, problem.scale))


def compare(
    given: Block, iterations: int, seeds: list[int], stages: tuple[Block, Block] | None
) -> dict[str, tuple[Run, FloatArray]]:
    """Return run and solution of each solver, computed in sequence on one thread."""
    solvers: dict[str, Callable[[], tuple[Run, FloatArray]]] = {
        **{IOA.format(seed): lambda seed=seed: by_ioa(given, iterations, seed) for seed in seeds},  # type: ignore[misc]
        ONCE: lambda: by_ipopt(given, 1),
        AGAIN: lambda: by_ipopt(given, STARTS),
        TRF: lambda: by_trf(given),
        SLSQP: lambda: by_slsqp(given),
    }
    if stages:
        solvers[STAGES] = lambda: by_stages(given, stages)
    with threadpool_limits(limits=1, user_api="blas"):
        by_ipopt(given, 1)  # loads the libraries
        return {name: run() for name, run in solvers.items()}


def study(iterations: int, seeds: list[int]) -> Iterator[tuple[Block, dict[str, Run]]]:
    """Compare the solvers for each force: pure slip, combined slip as in the paper, and all coefficients."""
    truth = published("unicamp_small_tire")
    table, tire = bench(truth, seed=1).table, generic_tire(truth)
    pure_rows = {"Fx": table["alpha"].abs() < 1e-6, "Fy": table["kappa"].abs() < 1e-6}
    for force in ("Fx", "Fy"):
        pure = block(f"{force} pure", tire, table[pure_rows[force]], PURE[force])
        combined = block(f"{force} combined", tire, table, COMBINED[force])
        everything = block(f"{force} all", tire, table, f"{PURE[force]} {COMBINED[force]}")
        results = compare(pure, iterations, seeds, None)
        yield pure, runs_of(results)
        after = with_tire(combined, solved_tire(pure, results[AGAIN][1]))  # pure slip is the same for all solvers
        yield after, runs_of(compare(after, iterations, seeds, None))
        yield everything, runs_of(compare(everything, iterations, seeds, (pure, combined)))


def runs_of(results: dict[str, tuple[Run, FloatArray]]) -> dict[str, Run]:
    """Return the runs without the solutions."""
    return {name: run for name, (run, _) in results.items()}


#: Header of the table of `result_rows`.
HEAD = """| problem | solver | sum of squares, N^2 | CPU, s | CPU to the best sum of IOA, s | speed-up |
|---|---|---|---|---|---|"""


def result_rows(given: Block, runs: dict[str, Run]) -> str:
    """Return the rows of a problem in the Markdown table. The speed-up refers to the mean CPU time of IOA."""
    lines = []
    size = f"{given.title}: {len(given.problem.rows)} points, {len(given.problem.free)} coefficients"
    slow = [run for name, run in runs.items() if name.startswith("IOA")]
    target = min(run.lowest[-1] for run in slow) * (1 + REACHED)
    spent = float(np.mean([run.total for run in slow]))
    for name, run in runs.items():
        reached = run.reaches(target)
        ratio = f"{spent / reached:.0f}" if np.isfinite(reached) and run not in slow else "-"
        needed = f"{reached:.3f}" if np.isfinite(reached) else "not reached"
        lines.append(f"| {size} | {name} | {run.lowest[-1]:.5g} | {run.total:.2f} | {needed} | {ratio} |")
        size = ""
    return "\n".join(lines)


def paper_rows(results: dict[str, tuple[Block, dict[str, Run]]]) -> str:
    """Return the comparison with the paper as a Markdown table."""
    lines = [
        "| problem | paper: sum of squares, N^2 | paper: rms, N | here, IOA: rms, N | here, IPOPT: rms, N |",
        "|---|---|---|---|---|",
    ]
    for title, (printed, rms) in PAPER.items():
        given, runs = results[title]
        ioa = min(run.lowest[-1] for name, run in runs.items() if name.startswith("IOA"))
        here = (f"{np.sqrt(squares / len(given.problem.rows)):.2f}" for squares in (ioa, runs[AGAIN].lowest[-1]))
        lines.append(f"| {title} | {printed:g} | {rms:g} | {' | '.join(here)} |")
    return "\n".join(lines)


def draw(results: dict[str, tuple[Block, dict[str, Run]]], path: Path) -> None:
    """Draw the lowest sum of squares over CPU time, both logarithmic, one panel per problem."""
    mpl.use("Agg")
    figure, axes = plt.subplots(2, 3, figsize=(12, 7), layout="constrained")
    colours = {ONCE: "C0", AGAIN: "C0", STAGES: "C4", TRF: "C2", SLSQP: "C1"}
    for axis, (given, runs) in zip(axes.ravel(), results.values(), strict=True):
        for name, run in runs.items():
            seconds, lowest = [*run.seconds, run.total], [*run.lowest, run.lowest[-1]]
            line = ":" if name == AGAIN else "-"
            axis.step(seconds, lowest, line, where="post", label=name, color=colours.get(name, "C3"))
        axis.axhline(len(given.problem.rows) * NOISE**2, color="0.6", linewidth=0.8, linestyle="--")
        axis.set(xscale="log", yscale="log", title=given.title)
        axis.grid(True, which="major", alpha=0.3)
    for axis in axes[1]:
        axis.set_xlabel("CPU time, s")
    for axis in axes[:, 0]:
        axis.set_ylabel("sum of squares, N$^2$")
    figure.legend(*axes[1, 2].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)


def main() -> None:
    """Compare the solvers, print the tables and draw the figure."""
    parser = argparse.ArgumentParser(description="Sum of squares against CPU time on the UNICAMP bench program.")
    parser.add_argument("--iterations", type=int, default=10_000, help="of IOA; 10,000 in the paper")
    parser.add_argument("--seeds", default="0,1", help="of IOA, one run each")
    parser.add_argument("--figure", type=Path, help="draw the convergence to this file")
    parser.add_argument("--json", type=Path, help="also write sums and seconds to this file")
    given = parser.parse_args()
    results = {}
    print(HEAD)
    for problem, runs in study(given.iterations, [int(seed) for seed in given.seeds.split(",")]):
        results[problem.title] = problem, runs
        print(result_rows(problem, runs), flush=True)
        if given.json:
            plain = {title: {name: vars(run) for name, run in solved.items()} for title, (_, solved) in results.items()}
            given.json.write_text(json.dumps(plain) + "\n")
    print(f"\n{paper_rows(results)}", flush=True)
    if given.figure:
        draw(results, given.figure)


if __name__ == "__main__":
    main()
