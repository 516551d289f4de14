"""The solution of a stage of a fit: from the state of the fit before it to that after it.

A stage that continues the one before has the same coefficients and more rows. It starts near its solution, to which few
Gauss-Newton steps lead; IPOPT follows only if they find no optimum. Most of them are taken with a sample of the rows,
so that all rows are needed for the last ones only.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import pandas as pd

from ..numerics.arrays import FloatArray, IntArray
from ..tires.code import fastest_code
from ..tires.tire import Tire
from .constraints.verification import APPROACHED, VERIFIED, ConstraintPoints, VerifiedConstraints
from .data.fit_data import with_states
from .prepared import PreparedStage, prepared_stages
from .problem.influence import influence, typical_size
from .problem.recipe import FreeCoefficient
from .problem.rows import Rows
from .problem.slope_targets import SlopeTarget
from .problem.weighted_residuals import Problem
from .problem.weights import effective_weights, equal_weights, limits_of, noise_weights
from .results.stages import StageResult
from .setup import Setup
from .solvers.convergence import noise_of
from .solvers.interruption import Interruption
from .solvers.ipopt import Progress, SolverResult
from .solvers.restarts import best_end, best_root
from .solvers.selection import Solver
from .stiffness_targets import add_targets, read_targets, solve_with_targets

#: Upper limit of the rounds in which points that violate a constraint are added.
ROUNDS = 12
#: Rows of the sample, and least number of rows from which one is taken. At the optimum of a sample the cost of all rows
#: is greater by a share of about n / (2 rows of the sample), which one or two steps remove.
SAMPLE, MIN_ROWS = 30_000, 60_000
#: Strength of the regularization of scaled coefficients, by the weights of the stage: with noise weights the cost is
#: about 1/2, with equal weights about the share of noise.
RIDGE = {"equal": 1e-8, "noise": 1e-5}
#: How often a stage is solved again with states that its own result has driven. States change forces by some percent
#: and forces drive states, so that each round reduces the change by a factor of ten or more.
STATE_ROUNDS = 2


@dataclass(frozen=True, eq=False)
class FitState:
    """What a fit has found so far, in adapted SAE. `solve_stage` makes the next state from it.

    - `tire`: with the present values.
    - `table`: the fitted rows, with the states of effects as they were simulated last.
    - `free`: the coefficients that stages have freed: first guess, last bounds.
    - `stages`: the results of the stages that were solved.
    - `violated`, shape (n_inputs, n_points): points that the verification of constraints has added.
    - `targets`: the slip stiffnesses that are read from the data; None before a stage uses them.
    - `notes`: notes for the user.
    - `completed`: number of completed stages of the recipe.
    """

    tire: Tire
    table: pd.DataFrame
    free: Mapping[str, FreeCoefficient] = field(default_factory=dict)
    stages: tuple[StageResult, ...] = ()
    violated: tuple[ConstraintPoints, ...] = ()
    targets: tuple[SlopeTarget, ...] | None = None
    notes: tuple[str, ...] = ()
    completed: int = 0

    @property
    def determined(self) -> frozenset[str]:
        """The coefficients that a stage has determined."""
        return frozenset(name for name, freed in self.free.items() if freed.determined)

    def with_values(self, values: Mapping[str, float]) -> FitState:
        """Return the state with other values of some coefficients."""
        return replace(self, tire=replace(self.tire, values={**self.tire.values, **values}))

    def with_note(self, note: str) -> FitState:
        """Return the state with one more note."""
        return replace(self, notes=(*self.notes, note))


def solve_stages(setup: Setup, interruption: Interruption) -> FitState:
    """Solve the stages until a stop is requested; report the tire of each iteration and stage."""
    state, stages = FitState(setup.tire, setup.table, notes=setup.notes), prepared_stages(setup)
    interruption.plan(
        lambda: [(stage.recipe.name, float(rows * len(stage.names))) for stage in stages if (rows := stage.count())]
    )
    for stage in stages:
        if interruption.stop():
            break
        state = solve_stage(stage, state, interruption)
        if interruption.stop():
            break
        state = replace(state, completed=state.completed + 1)
        interruption.reached(partial(getattr, state, "tire"))
    return state


def solve_stage(stage: PreparedStage, state: FitState, interruption: Interruption) -> FitState:
    """Return the state after a stage. A stage of channels that were not measured changes nothing.

    States of effects are simulated with the values before the stage, and again with its own result.
    """
    name, wanted = stage.recipe.name, ", ".join(stage.recipe.channels) or "the data"
    state = _simulated(stage, state, ())
    if not stage.channels and not stage.recipe.free:
        return state
    rows, numbers = stage.rows(state.table, state.tire)
    if not len(rows):
        return state.with_note(f"stage {name!r} skipped: no row of {wanted} meets its conditions")
    rows, numbers = _sampled(stage, rows, numbers)
    state, free = _determined(stage, state.with_values(stage.guesses(state.determined)), rows)
    if not free:
        return state.with_note(f"stage {name!r} skipped: its rows determine none of its coefficients")
    before = state.stages
    state = _solved(stage, state, rows, numbers, free, interruption)
    for _ in range(STATE_ROUNDS if state.tire.states else 0):
        state = _simulated(stage, replace(state, stages=before), free)
        rows, numbers = _sampled(stage, *stage.rows(state.table, state.tire))
        bounds = stage.bounds(state.tire)
        state = _solved(stage, state, rows, numbers, {name: bounds[name] for name in free}, interruption)
    return state


def _simulated(stage: PreparedStage, state: FitState, free: Collection[str]) -> FitState:
    """Return the state with the course of the states of effects for its values.

    `free`: coefficients that are estimated together with starts that are fitted to segments.
    """
    return replace(state, table=with_states(stage.setup.data, state.tire, free)) if state.tire.states else state


def _sampled(stage: PreparedStage, rows: Rows, numbers: IntArray) -> tuple[Rows, IntArray]:
    """Return the rows that a stage uses; a random sample has no numbers."""
    part = rows.sample(stage.recipe.rows)
    return part, numbers if stage.recipe.rows is None or len(part) < stage.recipe.rows else numbers[:0]


def _determined(stage: PreparedStage, state: FitState, rows: Rows) -> tuple[FitState, dict[str, FreeCoefficient]]:
    """Return the coefficients that the rows determine; set the others from generic values to their defaults."""
    plan, bounds = stage.setup.plan, stage.bounds(state.tire)
    seen = influence(state.tire, rows.sample(1000), list(bounds))
    if plan.family and stage.recipe.weights == "noise":
        seen |= bounds.keys() & set(plan.family.names)
    freed = dict(state.free)
    for name, bound in bounds.items():
        before = freed.get(name)
        if before is None or name in seen or not before.determined:
            guess = bound.guess if before is None else before.guess
            freed[name] = replace(bound, guess=guess, stage=stage.recipe.name, determined=name in seen)
    state = replace(state, free=freed)
    if not stage.recipe.free and plan.start is None:
        declared = plan.symbolic_model.coefficients
        state = state.with_values({n: declared[n].default for n in bounds if not freed[n].determined})
    return state, {name: bound for name, bound in bounds.items() if name in seen}


def _solved(
    stage: PreparedStage, state: FitState, rows: Rows, numbers: IntArray, free: Mapping[str, FreeCoefficient],
    interruption: Interruption,
) -> FitState:  # fmt: skip
    """Return the state after the solution of a problem, with its values and its result."""
    plan, name, given = stage.setup.plan, stage.recipe.name, stage.setup.plan.start is not None
    state, problem = _problem_of(stage, state, rows, free)
    guess, lower, upper = np.array([(f.guess, f.lower, f.upper) for f in free.values()]).T
    x, least, most = guess / problem.scale, lower / problem.scale, upper / problem.scale
    ridge, violated, before = RIDGE[stage.recipe.weights], list(state.violated), state

    def values_of(x: FloatArray) -> dict[str, float]:  # scaling back may round beyond a bound
        return dict(zip(free, np.clip(x * problem.scale, lower, upper).tolist(), strict=True))

    def report(iteration: int, cost: float, x: FloatArray) -> None:
        interruption.report(name, iteration, cost)
        interruption.reached(lambda: before.with_values(values_of(x)).tire)

    solver = StageSolver(
        problem, least, most, stage.setup.constraints, violated, stage.channels, stage.kind, ridge,
        plan.solver, report, interruption.stop,
    )  # fmt: skip
    first = solver.solve(np.clip(x, least, most), continues=stage.continues)
    end = best_end(problem, first, solver.solve, least, most, stage.recipe.again, always=given)
    if plan.options.method == "ipopt" and stage.kind == "final":
        end = best_root(problem, end, solver.near, partial(solver.solve, continues=True), least, most)
    end = end.accepted()
    state = state.with_values(values_of(end.x))
    result = StageResult(
        name, len(rows), len(free), end.iterations, end.converged, end.reason, end.cost,
        _r2_uncentred(state.tire, rows), end.detail, problem, np.clip(end.x, least, most), np.array([least, most]),
        ridge, numbers, tuple(solver.constraints.of(stage.channels)),
    )  # fmt: skip
    return replace(state, stages=(*state.stages, result), violated=tuple(violated))


def _problem_of(
    stage: PreparedStage, state: FitState, rows: Rows, free: Mapping[str, FreeCoefficient]
) -> tuple[FitState, Problem]:
    """Return the problem of a stage, with weights from the residuals at its initial values.

    The state then has the slip stiffnesses that the data show, if the stage uses them.
    """
    plan, tire, declared = stage.setup.plan, state.tire, stage.setup.plan.symbolic_model.coefficients
    sizes = [typical_size(declared[name].lower, declared[name].upper, f.guess) for name, f in free.items()]
    scale = np.array(sizes)
    problem = Problem(tire, rows, tuple(free), equal_weights(rows), scale, plan.loss)
    start = np.array([f.guess for f in free.values()]) / scale
    if stage.recipe.weights == "noise":
        problem.weights = noise_weights(problem, start, stage.setup.emphasis)
        if plan.options.rows == "independent":
            problem.weights = effective_weights(problem, start)
        if stage.recipe.rows is None and plan.options.stiffness_weight:
            if state.targets is None or tire.states:  # simulated states are inputs
                state = replace(state, targets=read_targets(state.table, tire))
            add_targets(problem, start, state.targets or (), plan.options.stiffness_weight)
        if plan.family:
            rows_in_effect = noise_of(problem, start)[1]
            problem.prior = plan.family.prior(problem.free, scale, 1.0 / max(rows_in_effect, 1.0))
    problem.limits = limits_of(problem, start)
    return state, problem


def _r2_uncentred(tire: Tire, rows: Rows) -> float:
    squares, present = np.zeros(rows.measured.shape[1]), np.isfinite(rows.measured).any(axis=0)
    for block in rows.blocks():
        computed = fastest_code(tire.symbolic_model).forces(block.inputs, tire.parameters()).T
        weighted = np.where(np.isfinite(block.measured), computed - block.measured, 0.0) ** 2
        squares += block.weight @ weighted
    return 1 - float(np.mean((squares * equal_weights(rows)[0])[present]))


@dataclass(frozen=True)
class StageSolver:
    """Solves the problem of a stage from any start.

    - `lower`, `upper`, shape (n_free,): scaled bounds of the free coefficients.
    - `constraints`: of the fit.
    - `violated`: points that verification has added to them; each solution adds its own.
    - `channels`: the channels of the stage.
    - `kind`, one of "intermediate", "penultimate", "final".
    - `ridge`: strength of the regularization.
    - `report`: called with iteration, cost and scaled free values.
    - `stop`: true ends the solution.
    """

    problem: Problem
    lower: FloatArray
    upper: FloatArray
    constraints: VerifiedConstraints
    violated: list[ConstraintPoints]
    channels: Sequence[str]
    kind: str
    ridge: float
    solver: Solver
    report: Progress
    stop: Callable[[], bool]

    def solve(self, start: FloatArray, *, continues: bool = False) -> SolverResult:
        """Solve, verify the constraints on the dense grid, and solve again with the points that violate them.

        An intermediate stage is solved again once: if its values violated a constraint, their residuals would give the
        next stage weights for a noise that no tire with this constraint reaches.

        `start`, shape (n_free,): scaled free values. `continues`: whether the start is the solution for the same
        coefficients with fewer rows.
        """
        constraints = self._known
        approached = self.kind == "intermediate"
        dense = self.constraints.of(self.channels, density=APPROACHED if approached else VERIFIED)
        solver = self._in_bounds
        solution = self._first(start, partial(solver, constraints=constraints), continues=continues)
        for _ in range(1 if approached else ROUNDS):
            if self.stop():
                break
            violated = self.constraints.violations(dense, self.problem.parameters(solution.x))
            if not violated:
                break
            self.violated.extend(violated)
            constraints = constraints + violated
            after = solver(self.problem, solution.x, constraints=constraints, refine=True)
            solution = replace(after, iterations=solution.iterations + after.iterations)
        return solution

    def near(self, start: FloatArray) -> SolverResult:
        """Return the end of Gauss-Newton steps with the constraints that are known, which are not verified.

        `start`, shape (n_free,): scaled free values.
        """
        return self._continued(start, partial(self._in_bounds, constraints=self._known))

    @property
    def _known(self) -> list[ConstraintPoints]:
        return self.constraints.of(self.channels) + self.violated

    @property
    def _in_bounds(self) -> Callable[..., SolverResult]:
        return partial(
            self.solver, lower=self.lower, upper=self.upper, ridge=self.ridge, stage_type=self.kind,
            progress=self.report, stop=self.stop,
        )  # fmt: skip

    def _first(self, start: FloatArray, solve: Callable[..., SolverResult], *, continues: bool) -> SolverResult:
        """Return the solution with the constraints that are known."""
        iterations = 0
        if continues:
            near = self._continued(start, solve)
            if near.converged or self.stop():
                return near
            start, iterations = near.x, near.iterations
        solution = solve_with_targets(self.problem, start, partial(solve, self.problem), self.stop)
        return replace(solution, iterations=iterations + solution.iterations)

    def _continued(self, start: FloatArray, solve: Callable[..., SolverResult]) -> SolverResult:
        """Return the end of Gauss-Newton steps, at first with a sample of many rows."""
        if len(self.problem.rows) < MIN_ROWS:
            return solve(self.problem, start, local=True)
        first = solve(self.problem.sampled(SAMPLE), start, local=True)
        if self.stop():
            return replace(first, cost=self.problem.cost(first.x), converged=False)
        after = solve(self.problem, first.x, refine=True)  # near the optimum undamped steps are the shortest way
        return replace(after, iterations=first.iterations + after.iterations)
