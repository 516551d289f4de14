"""Block bootstrap of a fit by sweeps: the fit is repeated with random weights of sweeps.

Rows of a sweep are correlated, sweeps hardly. A draw of sweeps with replacement would often contain no sweep at some
operating condition, and then several coefficients are not determined. Therefore each sweep has a random weight instead
of a random count: exponentially distributed with mean 1 (Rubin, The Bayesian bootstrap, 1981; Xu et al., Applications
of the fractional-random-weight bootstrap, 2020). Its variance is that of the counts of a draw, so the replicates have
the same covariance to first order: the sandwich estimator with sweeps as clusters. It assumes no correlation length.
The percentiles are expanded for sweeps that the fit follows, and for few sweeps (`leverage`).

Each replicate starts at the solution of the fit. The weights of channels, the bounds and the points at which physical
constraints are imposed are those of the fit, and so are the states of effects. A stage takes the coefficients of
earlier stages from the fit, as the linear analysis does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...boundary.errors import FitError
from ...measurements import Recording, group_by_condition, phases
from ...measurements.operating_conditions.levels import MAX_LEVELS
from ...numerics.arrays import FloatArray, IntArray
from ..constraints.constraint_functions import ConstraintFunctions
from ..fit_result import FitResult
from ..problem.slope_targets import SlopeTarget
from ..results.records import Bootstrap, BootstrapInterval
from ..results.stages import StageResult
from ..solvers.convergence import STEP_TOLERANCE, cost_of_a_row
from .leverage import Correction, corrections
from .near_solution import solve_near

#: Fewest sweeps, and fewest replicates: with fewer, percentiles 2.5 and 97.5 are the extremes or beyond.
MIN_SWEEPS, MIN_REPLICATES = 10, 40
#: Replicates of a task: starting it takes less time than they do.
REPLICATES_OF_TASK = 10


@dataclass(frozen=True, eq=False)
class ReplicateTask:
    """Some replicates: what a worker needs.

    - `determined`: the coefficients of which each stage is the last.
    - `sweeps`, shape (n,): number of the sweep of each row of all recordings.
    - `numbers`: numbers of the replicates. A replicate depends on the seed and its own number only.
    """

    stages: tuple[StageResult, ...]
    determined: tuple[tuple[str, ...], ...]
    sweeps: IntArray
    seed: int
    numbers: range

    @property
    def names(self) -> list[str]:
        """The coefficients of the replicates, in their order."""
        return [name for names in self.determined for name in names]


def sweeps_of(recordings: Sequence[Recording]) -> IntArray:
    """Return the number of the sweep of each row, counted over all recordings.

    A held condition and the change to the next level count as sweeps. In rows that are no time series, a sweep is a
    stretch of rows in one operating condition.

    Returns shape (n,).
    """
    numbers, first = [], 0
    for recording in recordings:
        starts = np.zeros(len(recording), dtype=np.int64)
        all_phases = phases(recording)
        starts[[phase.rows.start for phase in all_phases]] = 1
        if any(phase.kind == "points" for phase in all_phases):
            changes = np.diff(group_by_condition(recording, most_levels=MAX_LEVELS).labels) != 0
            for phase in all_phases:
                if phase.kind == "points":
                    inner = np.arange(phase.rows.start + 1, phase.rows.stop)
                    starts[inner] = changes[inner - 1]
        numbers.append(np.cumsum(starts) - 1 + first)
        first = int(numbers[-1][-1]) + 1
    return np.concatenate(numbers)


def replicate_tasks(
    result: FitResult, recordings: Sequence[Recording], replicates: int, seed: int
) -> list[ReplicateTask]:
    """Return the tasks of a bootstrap.

    `recordings`: the data of the fit. Raises `FitError` if there are too few replicates or sweeps, the fit has no
    solution, or it is of other data.
    """
    check_replicates(replicates)
    stages = tuple(stage for stage in result.whole_stages if result.determined_by(stage))
    if not stages:
        raise FitError("bootstrap: no stage of the fit used all of its rows")
    sweeps = sweeps_of(recordings)
    if max(int(stage.numbers.max()) for stage in stages) >= len(sweeps):
        raise FitError("bootstrap: the tables are not those of the fit")
    _check_sweeps(_weighted(stages, sweeps), "the fitted rows")
    firsts = range(0, replicates, REPLICATES_OF_TASK)
    determined = tuple(result.determined_by(stage) for stage in stages)
    return [
        ReplicateTask(stages, determined, sweeps, seed, range(first, min(first + REPLICATES_OF_TASK, replicates)))
        for first in firsts
    ]


def check_replicates(replicates: int, recordings: Sequence[Recording] = ()) -> None:
    """Raise FitError for too few replicates, or too few sweeps in all rows of recordings, before a fit."""
    if replicates < MIN_REPLICATES:
        raise FitError(f"{replicates} bootstrap replicates: at least {MIN_REPLICATES} are required")
    if recordings:
        _check_sweeps(int(sweeps_of(recordings)[-1]) + 1, "the recordings")


def replicates_of(task: ReplicateTask) -> FloatArray:
    """Compute the replicates of a task, in any process.

    Returns shape (n_replicates, n_coefficients): in the order of `ReplicateTask.names`; a row of NaN for a replicate
    that did not converge.
    """
    imposed = [ConstraintFunctions(stage.problem, stage.constraints) for stage in task.stages]
    tolerances = [STEP_TOLERANCE**2 * len(stage.x) * cost_of_a_row(stage.problem, stage.x) for stage in task.stages]
    count = int(task.sweeps.max()) + 1
    replicates = np.full((len(task.numbers), len(task.names)), np.nan)
    for row, number in zip(replicates, task.numbers, strict=True):
        drawn = np.random.default_rng([task.seed, number]).exponential(size=count)
        weights = drawn[task.sweeps]
        values: dict[str, float] = {}
        for stage, names, constraints, tolerance in zip(task.stages, task.determined, imposed, tolerances, strict=True):
            solved = _replicate(stage, constraints, weights, tolerance)
            if solved is None:
                break
            values |= {name: value for name, value in solved.items() if name in names}
        else:
            row[:] = list(values.values())
    return replicates


def bootstrap_of(result: FitResult, tasks: Sequence[ReplicateTask], replicates: FloatArray) -> FitResult:
    """Return a fit with the intervals of its bootstrap.

    `replicates`, shape (n_replicates, n_coefficients): of `replicates_of`, in adapted SAE. Raises `FitError` if too few
    replicates converged.
    """
    converged = replicates[np.isfinite(replicates).all(axis=1)]
    if len(converged) < MIN_REPLICATES:
        raise FitError(f"bootstrap: {len(converged)} of {len(replicates)} replicates converged: too few for intervals")
    stages, sweeps = tasks[0].stages, tasks[0].sweeps
    free = {coefficient.name for coefficient in result.coefficients if not np.isinf(coefficient.interval)}
    corrected = {
        name: (correction, stage)
        for stage, determined in zip(stages, tasks[0].determined, strict=True)
        for name, correction in corrections(stage, determined, sweeps).items()
    }
    intervals = tuple(
        _interval(name, column, *corrected.get(name, (None, None))) if name in free
        else BootstrapInterval(name, np.nan, np.nan, np.nan)
        for name, column in zip(tasks[0].names, converged.T, strict=True)
    )  # fmt: skip
    failed = len(replicates) - len(converged)
    bootstrap = Bootstrap(len(converged), failed, _weighted(stages, sweeps), tasks[0].seed, intervals)
    return replace(result.in_signs("adapted-sae"), bootstrap=bootstrap).in_signs(result.signs)


def _interval(
    name: str, replicates: FloatArray, correction: Correction | None, stage: StageResult | None
) -> BootstrapInterval:
    """Return the percentiles of a coefficient, expanded around its value within its bounds; plain ones at a bound."""
    # Between the smallest and the largest of N replicates are (N - 1) / (N + 1) of all: Hyndman and Fan, 1996, type 6.
    low, high = np.percentile(replicates, [2.5, 97.5], method="weibull").tolist()
    deviation = float(replicates.std(ddof=1))
    if correction is None or stage is None:
        return BootstrapInterval(name, low, high, deviation)
    i = stage.problem.free.index(name)
    value, least, most = (float(x[i] * stage.problem.scale[i]) for x in (stage.x, stage.lower, stage.upper))
    lower, upper = (value + correction.expansion * (end - value) for end in (low, high))
    return BootstrapInterval(name, max(lower, least), min(upper, most), correction.leverage * deviation)


def _weighted(stages: Sequence[StageResult], sweeps: IntArray) -> int:
    """Return the number of sweeps with fitted rows."""
    return len(np.unique(sweeps[np.concatenate([stage.numbers for stage in stages])]))


def _check_sweeps(count: int, where: str) -> None:
    if count < MIN_SWEEPS:
        raise FitError(f"bootstrap: {count} sweeps in {where}, at least {MIN_SWEEPS} are required")


def _replicate(
    stage: StageResult, imposed: ConstraintFunctions, weights: FloatArray, tolerance: float
) -> dict[str, float] | None:
    """Return the free values of a stage for weights of all rows; None if the solver did not converge."""
    problem, factor = stage.problem, weights[stage.numbers]
    rows = replace(problem.rows, weight=problem.rows.weight * factor / factor.mean())
    targets = tuple(_reweighted(target, weights[target.rows]) for target in problem.targets)
    weighted = replace(problem, rows=rows, targets=targets)
    x = solve_near(stage, weighted, imposed, stage.x, tolerance)
    return None if x is None else dict(zip(problem.free, (x * problem.scale).tolist(), strict=True))


def _reweighted(target: SlopeTarget, weights: FloatArray) -> SlopeTarget:
    """Return the slope that the weighted rows give: the influence of each row is multiplied by its weight."""
    size = np.abs(target.influence)
    influence = target.influence * weights * (size.sum() / (size @ weights))
    return replace(target, influence=influence, slope=float(influence @ target.force))
