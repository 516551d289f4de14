"""IOA: differential evolution whose control parameters evolve with the points that they make.

After Cabrera et al. (2004, the IMMa optimization algorithm) with the self-adaptation of Ortiz et al. (2009), as
the UNICAMP paper on combined slip of small tires describes it. No derivatives; the same problem, bounds and
conditions as IPOPT's, so that the two can be compared.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.errors import FitError

from ..constraints.constraint_functions import ConstraintFunctions
from ..constraints.physical import TOLERANCE, Constraint
from ..problem.weighted_residuals import Problem
from .ipopt import INTERRUPTED, LEAST_GAIN, LIMIT, Progress, Solution

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
#: The paper's limit of iterations, and its share for an intermediate stage, or where a fit is continued.
ITERATIONS, SHORTER = 10_000, 0.1
#: Over which share of the limit, and over how many generations at least, there has to be some gain.
WINDOW, LEAST_WINDOW = 0.1, 250
#: Individuals: so many for each free coefficient, within limits.
PER_COEFFICIENT, FEWEST, MOST = 4, 40, 120
#: Control genes F, CP, MP and range: their bounds.
LEAST_CONTROL = np.array([0.4, 0.2, 0.02, 0.005])
MOST_CONTROL = np.array([1.0, 1.0, 0.1, 0.1])
#: Why it stopped: the first two count as converged.
NO_GAIN, GOAL = "no further gain", "error goal reached"


class Evolution:
    """IOA as a solver, called like `tirefmu.fitting.solvers.ipopt.solve`.

    The paper's: a random population within the bounds; each individual carries its own F, CP, MP and range. A trial
    is best + F (x1 - x2), two others drawn at random, taken coefficient by coefficient with probability CP; each of
    its coefficients is moved with probability MP by at most +-range of its span; it is clipped to the bounds, and
    replaces its parent if it is no worse. Stop at the limit of iterations or at the error goal.

    What the paper leaves open, and was chosen here: four individuals per free coefficient, 40 at least and 120 at
    most; F in 0.4 .. 1, CP in 0.2 .. 1, MP in 0.02 .. 0.1, range in 0.005 .. 0.1 (with a smaller F a population
    collapses where it happens to be, and without mutation it never leaves that place), made by the same crossing and
    mutation as the coefficients, with the parent's genes, and used for the trial that carries them; the start is one
    of the first population; a whole generation is made before any of it is judged. Conditions by the rules of
    feasibility (Deb 2000): what keeps them beats what does not; among the first the lower cost counts, among the
    others the smaller sum of violations. A coefficient that a recipe leaves unbounded is sought within its card's
    bounds.

    Beyond the paper it also stops where a tenth of the limit's generations, 250 at least, has brought the cost down by
    less than the share that makes IPOPT stop. That is called converged, though no derivative shows it: nothing
    proves that there is no better point.

    Parameters
    ----------
    max_iterations : int
        Generations. An intermediate stage gets a tenth of them, and so does a fit that goes on from where it had ended,
        with the conditions that it broke there.
    seed : int
        The same seed gives the same fit.
    goal : float
        Stop at this cost.
    run_to_limit : bool
        Go on to the limit, as the paper does, also where there is no gain.

    Examples
    --------
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
        progress: Progress | None = None,
        stop: Callable[[], bool] = lambda: False,
    ) -> Solution:
        """Minimize the cost within bounds and constraints.

        Parameters
        ----------
        problem : Problem
            Where it is the one of the call before, its last population goes on.
        start, lower, upper : ndarray, shape (n_free,)
            Scaled free values.
        constraints : sequence of (Constraint, ndarray of shape (n_inputs, n_points))
            Conditions and the points at which they hold.
        ridge : float
            Pull of every scaled value towards its start, as in IPOPT's cost.
        stage_type : {"intermediate", "penultimate", "final"}
            An intermediate stage stops earlier: another fit continues from there.
        progress : callable, optional
            Called with generation and best cost.
        stop : callable
            Asked after every generation whether to end there.

        Returns
        -------
        Solution
            The best individual; `converged` where there was no further gain within the conditions, or the goal is
            reached.

        Raises
        ------
        FitError
            If a coefficient has no finite bounds, neither here nor on its card.
        """
        imposed = ConstraintFunctions(problem, constraints)
        again = self._search is not None and self._search.problem is problem
        if self._search is None or not again:
            low, high = _box(problem, start, lower, upper)
            self._search = _Search(problem, start, low, high, ridge, np.random.default_rng(self.seed))
        search = self._search
        search.impose(imposed)
        limit = max(1, round(self.max_iterations * (SHORTER if stage_type == "intermediate" or again else 1.0)))
        window = limit if self.run_to_limit else max(round(WINDOW * limit), LEAST_WINDOW)
        share = LEAST_GAIN[stage_type][1]
        costs: list[float] = []  # the best cost within the conditions after each generation
        reason = LIMIT
        for _ in range(limit):
            search.step()
            if progress is not None:
                progress(search.generation, search.best_cost)
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
        return Solution(x, problem.cost(x), search.generation, reason in (NO_GAIN, GOAL), reason)


@dataclass
class _Population:
    """Individuals: coefficients as shares of their span, control genes, costs, violations of the conditions."""

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
        """The place of the best individual by the rules of feasibility."""
        return int(np.lexsort((self.costs, self.violations))[0])


class _Search:
    """A population on its way."""

    def __init__(
        self, problem: Problem, start: FloatArray, low: FloatArray, high: FloatArray, ridge: float,
        random: np.random.Generator,
    ) -> None:  # fmt: skip
        self.problem, self._start, self._ridge, self._random = problem, start.copy(), ridge, random
        self._low, self._span = low, high - low
        self._imposed: ConstraintFunctions | None = None
        self.generation = 0
        n = len(start)
        size = min(max(PER_COEFFICIENT * n, FEWEST), MOST)
        points = random.random((size, n))
        points[0] = np.divide(start - low, self._span, out=np.zeros(n), where=self._span > 0)
        controls = LEAST_CONTROL + random.random((size, 4)) * (MOST_CONTROL - LEAST_CONTROL)
        self._now = _Population(points, controls, np.full(size, np.inf), np.full(size, np.inf))
        self._judge(self._now, self._now)

    def impose(self, imposed: ConstraintFunctions) -> None:
        """Judge the population by these conditions from now on."""
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
        """Whether the best individual keeps every condition."""
        return bool(self._now.violations[self._now.best] == 0)

    def step(self) -> None:
        """Make a generation of trials and keep those that are no worse than their parents."""
        now, random = self._now, self._random
        size, n = now.points.shape
        best = now.best
        # Two others than the individual itself, and than each other.
        shift = 1 + np.argsort(random.random((size, size - 1)), axis=1)[:, :2]
        one, two = ((np.arange(size) + shift[:, i]) % size for i in (0, 1))
        span = MOST_CONTROL - LEAST_CONTROL
        controls = self._crossed(now.controls, best, one, two, now.controls, span)
        controls = np.clip(controls, LEAST_CONTROL, MOST_CONTROL)
        points = np.clip(self._crossed(now.points, best, one, two, controls, np.ones(n)), 0.0, 1.0)
        trials = _Population(points, controls, np.full(size, np.inf), np.full(size, np.inf))
        now.take(trials, self._judge(trials, now))
        self.generation += 1

    def _crossed(
        self, genes: FloatArray, best: int, one: npt.NDArray[np.intp], two: npt.NDArray[np.intp], controls: FloatArray,
        span: FloatArray,
    ) -> FloatArray:  # fmt: skip
        """Return genes crossed with best + F (one - two) and mutated, all by the given control genes."""
        f, cp, mp, reach = (controls[:, [i]] for i in range(4))
        random, shape = self._random, genes.shape
        crossing = random.random(shape) < cp
        crossing[np.arange(shape[0]), random.integers(shape[1], size=shape[0])] = True  # one at least
        crossed = np.where(crossing, genes[best] + f * (genes[one] - genes[two]), genes)
        mutation = random.uniform(-1.0, 1.0, shape) * reach * span
        return np.where(random.random(shape) < mp, crossed + mutation, crossed)

    def _judge(self, trials: _Population, parents: _Population) -> BoolArray:
        """Work out costs and violations as far as it takes, and return which trials replace their parents."""
        rivals = parents.violations == 0  # their trials have to be cheaper first, which is soon seen
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
        """Return by how much the conditions are broken, summed; infinite where a quantity has no value."""
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
    """Return bounds that are all finite: a card's, widened to the start, where none is given."""
    declarations = [problem.tire.book.coefficients[name] for name in problem.free]
    low = np.where(
        np.isfinite(lower), lower, np.array([declaration.lower for declaration in declarations]) / problem.scale
    )
    high = np.where(
        np.isfinite(upper), upper, np.array([declaration.upper for declaration in declarations]) / problem.scale
    )
    for name, bounded in zip(problem.free, np.isfinite(low) & np.isfinite(high), strict=True):
        if not bounded:
            raise FitError(f"method ioa seeks within bounds, and {name} has none: give it some in the recipe")
    return np.minimum(low, start), np.maximum(high, start)
