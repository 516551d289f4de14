"""IOA: differential evolution with self-adaptive control parameters.

After Cabrera et al. (2004, the IMMa optimization algorithm) with the self-adaptation of Ortiz et al. (2009), as
described in the UNICAMP paper on combined slip of small tires. It uses no derivatives. Problem, bounds and constraints
are those of IPOPT, so the two can be compared.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...boundary.errors import FitError
from ...numerics.arrays import BoolArray, FloatArray, IndexArray
from ..constraints.constraint_functions import ConstraintFunctions
from ..constraints.physical import TOLERANCE, Constraint
from ..problem.weighted_residuals import Problem
from .ipopt import INTERRUPTED, LIMIT, MIN_GAIN, Progress, SolverResult

#: Iteration limit of the paper, and its share for an intermediate stage or a continued fit.
ITERATIONS, SHORTER = 10_000, 0.1
#: Stopping window: its share of the iteration limit, and its least number of generations.
WINDOW, MIN_WINDOW = 0.1, 250
#: Population size: individuals per free coefficient, lower and upper limit.
PER_COEFFICIENT, MIN_POPULATION, MAX_POPULATION = 4, 40, 120
#: Bounds of the control genes F, CP, MP and range.
MIN_CONTROL = np.array([0.4, 0.2, 0.02, 0.005])
MAX_CONTROL = np.array([1.0, 1.0, 0.1, 0.1])
#: Reason without convergence: there are no derivatives.
NO_STEPS = "no steps without a search"
#: Reasons that count as converged.
NO_GAIN, GOAL = "no further gain", "error goal reached"


class Evolution:
    """IOA as a solver, called like `tirefmu.fitting.solvers.ipopt.solve`.

    From the paper: the initial population is random within the bounds. Each individual has its own F, CP, MP and range.
    A trial is best + F (x1 - x2) with two random individuals x1 and x2; crossover takes each coefficient of it with
    probability CP. Mutation changes each coefficient with probability MP by up to +-range of its span. The trial is
    clipped to the bounds and replaces its parent if it is no worse. The algorithm stops at the iteration limit or at
    the error goal.

    Not specified by the paper and chosen here: four individuals per free coefficient, between 40 and 120. F is in 0.4
    .. 1, CP in 0.2 .. 1, MP in 0.02 .. 0.1, range in 0.005 .. 0.1; with a smaller F or without mutation the population
    converges prematurely. Crossover and mutation of these control genes are those of the coefficients, with the genes
    of the parent; the trial uses the new genes. The initial population contains the start. A generation is complete
    before it is evaluated. Constraints follow the feasibility rules (Deb 2000): a feasible individual is better than an
    infeasible one; the cost decides between feasible individuals, the sum of violations between infeasible ones. A
    coefficient without bounds in the recipe has the bounds of its declaration.

    In addition to the paper, the algorithm stops if the cost decreases by less than the least gain of IPOPT within the
    stopping window, a tenth of the iteration limit and at least 250 generations. This counts as converged, although
    without derivatives an optimum cannot be proved.

    `max_iterations`: upper limit of generations. An intermediate stage has a tenth of it, and so has a fit that is
    continued with the constraints that its solution violates. `seed`: equal seeds give equal fits. `goal`: the
    algorithm stops at this cost. `run_to_limit`: continue to the limit without a stopping window, as in the paper.

    >>> Evolution(max_iterations=500, seed=3).max_iterations
    500
    """

    def __init__(
        self, max_iterations: int = ITERATIONS, seed: int = 0, goal: float = 0.0, *, run_to_limit: bool = False
    ) -> None:
        self.max_iterations, self.seed, self.goal, self.run_to_limit = max_iterations, seed, goal, run_to_limit
        self._search: _Search | None = None

    def __call__(
        self,
        problem: Problem,
        start: FloatArray,
        lower: FloatArray,
        upper: FloatArray,
        constraints: Sequence[tuple[Constraint, FloatArray]],
        *,
        ridge: float = 0.0,
        stage_type: str = "final",
        refine: bool = False,
        local: bool = False,
        progress: Progress | None = None,
        stop: Callable[[], bool] = lambda: False,
    ) -> SolverResult:
        """Minimize the cost within bounds and constraints.

        - `problem`: if it is that of the previous call, the search continues with its last population.
        - `start`, `lower`, `upper`, shape (n_free,): scaled free values.
        - `constraints`, shape (n_inputs, n_points): constraints, each with the points at which it is imposed.
        - `ridge`: strength of the regularization towards the initial values, as in IPOPT's cost.
        - `stage_type`, one of "intermediate", "penultimate", "final": an intermediate stage stops earlier, because a
          later stage continues.
        - `refine`: without effect: the search continues with its last population for every further call with one
          problem.
        - `local`: whether only steps without a search are wanted: there are none, and the start is returned.
        - `progress`: called with generation, best cost and scaled free values of the best individual.
        - `stop`: called after every generation; True ends the search.

        Returns: the best individual; `converged` if a feasible solution has no further gain or the goal is reached.
        Raises `FitError` if a coefficient has no finite bounds, neither here nor in its declaration.
        """
        if local:
            return SolverResult(start, problem.cost(start), 0, converged=False, reason=NO_STEPS)
        imposed = ConstraintFunctions(problem, constraints)
        again = self._search is not None and self._search.problem is problem
        if self._search is None or not again:
            low, high = _box(problem, start, lower, upper)
            self._search = _Search(problem, start, low, high, ridge, np.random.default_rng(self.seed))
        search = self._search
        search.impose(imposed)
        limit = max(1, round(self.max_iterations * (SHORTER if stage_type == "intermediate" or again else 1.0)))
        window = limit if self.run_to_limit else max(round(WINDOW * limit), MIN_WINDOW)
        share = MIN_GAIN[stage_type][1]
        costs: list[float] = []  # the best feasible cost after each generation
        reason = LIMIT
        for _ in range(limit):
            search.step()
            if progress is not None:
                progress(search.generation, search.best_cost, search.best)
            if search.feasible:
                costs.append(search.best_cost)
            if costs and costs[-1] <= self.goal:
                reason = GOAL
            elif len(costs) > window and costs[-1 - window] - costs[-1] < share * abs(costs[-1]):
                reason = NO_GAIN
            elif stop():
                reason = INTERRUPTED
            else:
                continue
            break
        x = search.best
        return SolverResult(x, problem.cost(x), search.generation, reason in (NO_GAIN, GOAL), reason)


@dataclass
class _Population:
    """Individuals: coefficients as shares of their span, control genes, costs, violations of the constraints."""

    points: FloatArray
    controls: FloatArray
    costs: FloatArray
    violations: FloatArray

    def take(self, others: _Population, chosen: BoolArray) -> None:
        """Replace the chosen individuals by others."""
        for name in ("points", "controls", "costs", "violations"):
            getattr(self, name)[chosen] = getattr(others, name)[chosen]

    @property
    def best(self) -> int:
        """Index of the best individual by the feasibility rules."""
        return int(np.lexsort((self.costs, self.violations))[0])


class _Search:
    """State of a search: the population and its generation."""

    def __init__(
        self, problem: Problem, start: FloatArray, low: FloatArray, high: FloatArray, ridge: float,
        random: np.random.Generator,
    ) -> None:  # fmt: skip
        self.problem, self._start, self._ridge, self._random = problem, start.copy(), ridge, random
        self._low, self._span = low, high - low
        self._imposed: ConstraintFunctions | None = None
        self.generation = 0
        n = len(start)
        size = min(max(PER_COEFFICIENT * n, MIN_POPULATION), MAX_POPULATION)
        points = random.random((size, n))
        points[0] = np.divide(start - low, self._span, out=np.zeros(n), where=self._span > 0)
        controls = MIN_CONTROL + random.random((size, 4)) * (MAX_CONTROL - MIN_CONTROL)
        self._now = _Population(points, controls, np.full(size, np.inf), np.full(size, np.inf))
        self._judge(self._now, self._now)

    def impose(self, imposed: ConstraintFunctions) -> None:
        """Evaluate the population with these constraints from now on."""
        self._imposed = imposed if len(imposed) else None
        self._now.violations = self._violations(self._now.points)

    @property
    def best(self) -> FloatArray:
        """Scaled free values of the best individual."""
        return self._values(self._now.points[self._now.best])

    @property
    def best_cost(self) -> float:
        return float(self._now.costs[self._now.best])

    @property
    def feasible(self) -> bool:
        """Whether the best individual satisfies all constraints."""
        return bool(self._now.violations[self._now.best] == 0)

    def step(self) -> None:
        """Create a generation of trials; each replaces its parent if it is no worse."""
        now, random = self._now, self._random
        size, n = now.points.shape
        best = now.best
        # Two individuals that differ from the parent and from each other.
        shift = 1 + np.argsort(random.random((size, size - 1)), axis=1)[:, :2]
        first, second = ((np.arange(size) + shift[:, i]) % size for i in (0, 1))
        span = MAX_CONTROL - MIN_CONTROL
        controls = self._crossed(now.controls, best, first, second, now.controls, span)
        controls = np.clip(controls, MIN_CONTROL, MAX_CONTROL)
        points = np.clip(self._crossed(now.points, best, first, second, controls, np.ones(n)), 0.0, 1.0)
        trials = _Population(points, controls, np.full(size, np.inf), np.full(size, np.inf))
        now.take(trials, self._judge(trials, now))
        self.generation += 1

    def _crossed(
        self, genes: FloatArray, best: int, first: IndexArray, second: IndexArray,
        controls: FloatArray, span: FloatArray,
    ) -> FloatArray:  # fmt: skip
        """Return genes after crossover with best + F (first - second) and mutation, by the given control genes."""
        f, cp, mp, reach = (controls[:, [i]] for i in range(4))
        random, shape = self._random, genes.shape
        crossing = random.random(shape) < cp
        crossing[np.arange(shape[0]), random.integers(shape[1], size=shape[0])] = True  # at least one
        crossed = np.where(crossing, genes[best] + f * (genes[first] - genes[second]), genes)
        mutation = random.uniform(-1.0, 1.0, shape) * reach * span
        return np.where(random.random(shape) < mp, crossed + mutation, crossed)

    def _judge(self, trials: _Population, parents: _Population) -> BoolArray:
        """Compute costs and violations as far as necessary, and return which trials replace their parents."""
        rivals = parents.violations == 0  # a trial needs a lower cost than a feasible parent: this is checked first
        promising = np.ones(len(rivals), dtype=bool)
        if rivals.any():
            trials.costs[rivals] = self._costs(trials.points[rivals], parents.costs[rivals])
            promising[rivals] = trials.costs[rivals] <= parents.costs[rivals]
        trials.violations[promising] = self._violations(trials.points[promising])
        new = promising & ~rivals & (trials.violations == 0)
        if new.any():
            trials.costs[new] = self._costs(trials.points[new], np.full(int(new.sum()), np.inf))
        return np.asarray(promising & (trials.violations <= parents.violations), dtype=np.bool_)

    def _values(self, points: FloatArray) -> FloatArray:
        return self._low + points * self._span

    def _costs(self, points: FloatArray, limits: FloatArray) -> FloatArray:
        values = self._values(points)
        penalty: FloatArray = 0.5 * self._ridge * np.sum((values - self._start) ** 2, axis=1)
        return self.problem.costs(values, limits - penalty) + penalty

    def _violations(self, points: FloatArray) -> FloatArray:
        """Return the sum of the constraint violations; infinite if a quantity is not finite."""
        imposed = self._imposed
        if imposed is None:
            return np.zeros(len(points))
        quantities = imposed.values_of_each(self._values(points))
        beyond = np.maximum(np.maximum(imposed.low - quantities, quantities - imposed.high), 0.0)
        beyond[beyond <= TOLERANCE] = 0.0
        total: FloatArray = beyond.sum(axis=1)
        total[np.isnan(total)] = np.inf
        return total


def _box(problem: Problem, start: FloatArray, lower: FloatArray, upper: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return finite bounds: those of the declaration where none are given, extended to include the start."""
    declarations = [problem.tire.symbolic_model.coefficients[name] for name in problem.free]
    low = np.where(
        np.isfinite(lower), lower, np.array([declaration.lower for declaration in declarations]) / problem.scale
    )
    high = np.where(
        np.isfinite(upper), upper, np.array([declaration.upper for declaration in declarations]) / problem.scale
    )
    for name, bounded in zip(problem.free, np.isfinite(low) & np.isfinite(high), strict=True):
        if not bounded:
            raise FitError(f"method ioa requires bounds, and {name} has none: specify them in the recipe")
    return np.minimum(low, start), np.maximum(high, start)
