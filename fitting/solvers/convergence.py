r"""Whether a point is the optimum, by what a step from it could still gain; and the last steps to it.

What counts is the quadratic model of the cost, damped as far as it takes to keep what it promises (Levenberg and
Marquardt), over the steps that bounds and linearized conditions allow: Nocedal and Wright, Numerical Optimization,
2nd ed. 2006, chapters 10.3 (Gauss-Newton with damping), 12 (active conditions), 16 (the quadratic program) and 18
(sequential programs). What it promises at most, the predicted reduction, is half the squared norm of the projected
gradient in the measure of the model's inverse: it does not depend on units, nor on how a solver came to the point.

How little is little enough follows from the noise. N independent rows with cost F = N sigma^2 / 2 leave n coefficients
an error whose squared length, in the measure of J^T W J, is n sigma^2: fitting noise lowers the cost by n F / N. A
predicted reduction of `TENTH`^2 of that is a step of a tenth of a standard error, root mean square over the
coefficients. N is the number of effective rows, as noise is correlated in time. Data without noise count as having the
least that weights are made for (`LEAST_NOISE`): what is left of their cost is rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from threadpoolctl import threadpool_limits

from tirefmu.estimation.correlation import effective_sample_size
from tirefmu.estimation.quadratic_step import best_step

from ..constraints.constraint_functions import Imposed
from ..problem.regularization import Ridge
from ..problem.weighted_residuals import LEAST_NOISE, Problem

FloatArray = npt.NDArray[np.float64]
#: The step that counts as none, in standard errors.
TENTH = 0.1
#: The damping that is tried, in scaled coefficients: the least for which the matrix is safely regular, the most.
LEAST_DAMPING, MOST_DAMPING, DAMPING_UP = 1e-7, 1.0, 10.0
#: A model is trusted that keeps this share of its promise.
TRUSTED = 0.1
#: How often a step is bent back to the conditions that it breaks, as these are not linear.
BENT = 2


@dataclass(frozen=True)
class Rest:
    """Where the last steps ended.

    Attributes
    ----------
    x : ndarray, shape (n_free,)
    steps : int
        Taken, the last one not counted.
    converged : bool
    reason : str
        In plain words.
    """

    x: FloatArray
    steps: int
    converged: bool
    reason: str


def noise_of(problem: Problem, x: FloatArray) -> tuple[float, float]:
    """Return what the least noise that data may have costs, and how many independent rows the residuals show.

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_free,)
        Scaled free values.

    Returns
    -------
    least : float
    effective_rows : float
    """
    residual, signal, effective = problem.residual(x), 0.0, 0.0
    for group, channel in np.argwhere(problem.weights > 0):
        rows = (problem.rows.group == group) & np.isfinite(problem.rows.measured[:, channel])
        if rows.any():
            measured, weight = problem.rows.measured[rows, channel], problem.rows.weight[rows]
            signal += 0.5 * float(problem.weights[group, channel] * np.sum(weight * measured**2))
            effective += effective_sample_size(residual[channel, rows], problem.rows.segment[rows])
    return LEAST_NOISE**2 * signal, effective


def settle(
    cost: Ridge,
    x: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    imposed: Imposed,
    *,
    steps: int,
    stop: Callable[[], bool] = lambda: False,
) -> Rest:
    """Take steps until none is worth taking, and say whether it came to that.

    Parameters
    ----------
    cost : Ridge
    x, lower, upper : ndarray, shape (n_free,)
        Scaled free values and their bounds.
    imposed : Imposed
        The conditions.
    steps : int
        The most; with 0 of them x is only judged.
    stop : callable
        Asked after every step whether to end there.

    Returns
    -------
    Rest
    """
    with threadpool_limits(limits=1, user_api="blas"):
        for taken in range(steps + 1):
            here = _Place.at(cost, x, lower, upper, imposed)
            if here.wrong:
                return Rest(x, taken, converged=False, reason=here.wrong)
            promise, after = here.look()
            if promise <= here.enough:
                told = f"predicted reduction {here.share(promise)}"
                return Rest(x if after is None or not steps else after, taken, converged=True, reason=told)
            if after is None or stop():
                break
            if taken < steps:
                x = after
    told = f"predicted reduction {here.share(promise)}"
    if after is None:
        told += ", of which no step keeps enough"
    return Rest(x, taken, converged=False, reason=told)


@dataclass(frozen=True)
class _Place:
    """A point with the model of the cost there."""

    function: Ridge
    imposed: Imposed
    x: FloatArray
    lower: FloatArray
    upper: FloatArray
    cost: float
    gradient: FloatArray
    matrix: FloatArray
    conditions: FloatArray
    slopes: FloatArray
    noise: float
    enough: float
    wrong: str

    @classmethod
    def at(cls, function: Ridge, x: FloatArray, lower: FloatArray, upper: FloatArray, imposed: Imposed) -> _Place:
        cost, gradient, matrix = function.derivatives(x)
        conditions, slopes = imposed.values(x), np.array(imposed.jacobian(x)).reshape(len(imposed), len(x))
        numbers, noise, enough = (gradient, matrix, conditions, slopes), 0.0, 0.0
        if not np.isfinite(cost) or not all(np.isfinite(each).all() for each in numbers):
            wrong = "cost, conditions or derivatives are not finite"
        elif not imposed.kept(conditions):
            beyond = max(np.max(imposed.low - conditions), np.max(conditions - imposed.high))
            wrong = f"a condition is broken by {beyond:.0e} of its size"
        else:
            wrong, (noise, rows) = "", noise_of(function.problem, x)
            enough = TENTH**2 * max(cost, noise) * min(len(x) / max(rows, 1.0), 1.0)
        return cls(function, imposed, x, lower, upper, cost, gradient, matrix, conditions, slopes, noise, enough, wrong)

    def share(self, reduction: float) -> str:
        """Return what a reduction is of the cost, or of the least noise where there is less than that."""
        whole = "cost" if self.cost >= self.noise else "least noise"
        return f"{reduction / max(self.cost, self.noise):.0e} of the {whole}"

    def look(self) -> tuple[float, FloatArray | None]:
        """Return what the least damped model that is trusted promises, and the point to which it leads.

        Where the promise is not worth a step, a model need not be trusted, as more damping promises less. A step is
        looked for all the same: the last one goes right to the bounds and conditions that hold the optimum.
        """
        damping, least = LEAST_DAMPING, np.inf
        while damping <= MOST_DAMPING:
            promise, after = self._tried(damping)
            if not np.isfinite(least) or least > self.enough:
                least = promise
            if after is not None:
                return least, after
            damping *= DAMPING_UP
        return least, None

    def _tried(self, damping: float) -> tuple[float, FloatArray | None]:
        """Return what a damped model promises, and the point to which it leads where it keeps TRUSTED of that."""
        n = len(self.x)
        matrix = self.matrix + damping * np.eye(n)
        rows = np.concatenate([np.eye(n), self.slopes])
        now, promise = self.conditions, np.inf
        for bent in range(1 + BENT):
            least = np.concatenate([self.lower - self.x, self.imposed.low - now])
            most = np.concatenate([self.upper - self.x, self.imposed.high - now])
            if not bent:  # what is met within the tolerance is met
                least, most = np.minimum(least, 0.0), np.maximum(most, 0.0)
            try:
                step, reduction = best_step(self.gradient, matrix, rows, least, most)
            except np.linalg.LinAlgError:
                break
            promise = reduction if not bent else promise
            after = np.clip(self.x + step, self.lower, self.upper)
            conditions = self.imposed.values(after)
            if self.imposed.kept(conditions):
                gained = self.cost - self.function.cost(after)
                return promise, after if gained > TRUSTED * promise else None
            now = conditions - self.slopes @ step
        return promise, None
