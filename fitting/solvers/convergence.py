r"""The convergence criterion of a fit: the predicted reduction of the cost; and the last Gauss-Newton steps.

`tirefmu.estimation.gauss_newton` takes the steps. The noise determines the tolerance. With N independent rows and the
cost F = N sigma^2 / 2, the estimation error of n coefficients has the squared length n sigma^2 in the norm of J^T W J:
fitting noise reduces the cost by n F / N. A predicted reduction of `STEP_TOLERANCE`^2 times this value is a step of a
tenth of a standard error, root mean square over the coefficients. N is the effective sample size, because noise is
correlated in time. The noise is assumed to be at least `MIN_NOISE` of the signal: below it, the cost is rounding
error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tirefmu.estimation.correlation import effective_sample_size
from tirefmu.estimation.gauss_newton import Damping, minimize, restore
from tirefmu.tires.arrays import FloatArray

from ..constraints.constraint_functions import ConstraintFunctions
from ..problem.regularization import Ridge
from ..problem.weighted_residuals import Problem
from ..problem.weights import MIN_NOISE

#: Largest step of a converged fit, in standard errors.
STEP_TOLERANCE = 0.1
#: In scaled coefficients. Each step starts at the least damping for which the matrix is regular.
DAMPING = Damping(first=1e-7, least=1e-7, most=1.0, up=10.0, down=0.0, by_curvature=False, trusted=0.1)

#: The same for a start from which the undamped step leads too far: the damping of a step depends on the last one.
APPROACH = Damping(first=1e-3, least=1e-7, most=1e3, up=10.0, down=0.1, by_curvature=True, trusted=0.1)
#: Change of the cost, as a share of it, up to which the correlation of the residuals is not estimated again.
SAME_NOISE = 0.01
#: Damping of the step onto violated constraints: the nearest point without damping is far away in directions that the
#: data hardly determine, where the cost is not quadratic. With 1e-4 its cost was a hundred times that of the optimum.
RESTORING_DAMPING = 1e-2


@dataclass(frozen=True)
class LastSteps:
    """The result of the last steps.

    - `x`, shape (n_free,).
    - `steps`: number of steps, without the last one.
    - `reason`: a text for the user.
    """

    x: FloatArray
    steps: int
    converged: bool
    reason: str


def noise_of(problem: Problem, x: FloatArray) -> tuple[float, float]:
    """Return the cost of the least noise that is assumed, and the effective sample size of the residuals.

    `x`, shape (n_free,): scaled free values.
    """
    residual, signal, effective = problem.residual(x), 0.0, 0.0
    for group, channel in np.argwhere(problem.weights > 0):
        rows = (problem.rows.group == group) & np.isfinite(problem.rows.measured[:, channel])
        if rows.any():
            squares = np.sum(problem.rows.weight[rows] * problem.rows.measured[rows, channel] ** 2)
            signal += 0.5 * float(problem.weights[group, channel] * squares)
            effective += effective_sample_size(residual[channel, rows], problem.rows.segment[rows])
    return MIN_NOISE**2 * signal, effective


class _Criterion:
    """The predicted reduction at which a point is the optimum, and the cost to which it is compared."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._whole, self._size = "cost", 1.0
        self._noise: tuple[float, float, float] = (np.nan, 0.0, 0.0)  # for which cost, and the result of `noise_of`

    def __call__(self, x: FloatArray, cost: float) -> float:
        if not abs(cost - self._noise[0]) <= SAME_NOISE * cost:
            self._noise = cost, *noise_of(self._problem, x)
        _, noise, rows = self._noise
        self._whole, self._size = "cost" if cost >= noise else "least noise", max(cost, noise)
        return STEP_TOLERANCE**2 * self._size * min(len(x) / max(rows, 1.0), 1.0)

    def share(self, reduction: float) -> str:
        """Return a reduction relative to the cost, or to the least noise if the cost is smaller."""
        return f"{reduction / self._size:.0e} of the {self._whole}"


def last_steps(
    cost: Ridge,
    x: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    imposed: ConstraintFunctions,
    *,
    steps: int,
    stop: Callable[[], bool] = lambda: False,
) -> LastSteps:
    """Take Gauss-Newton steps until the criterion of this module is met or no step is possible.

    `x`, `lower`, `upper`, shape (n_free,): scaled free values and their bounds. `imposed`: the physical constraints.
    `steps`: upper limit; with 0 the criterion is only evaluated at x. `stop`: called after every step; True ends the
    loop.
    """
    return _steps_until(_Criterion(cost.problem), DAMPING, cost, x, lower, upper, imposed, steps, stop)


def _steps_until(
    enough: _Criterion, damping: Damping, cost: Ridge, x: FloatArray, lower: FloatArray, upper: FloatArray,
    imposed: ConstraintFunctions, steps: int, stop: Callable[[], bool],
) -> LastSteps:  # fmt: skip
    """Take Gauss-Newton steps until a criterion is met, and return why they ended."""
    end = minimize(cost, x, lower, upper, enough, damping, steps=steps, constraints=imposed, stop=stop)
    reason = end.reason
    if np.isfinite(end.predicted):
        reason = f"predicted reduction {enough.share(end.predicted)}" + f", {reason}" * bool(reason)
    return LastSteps(end.x, end.steps, end.converged, reason)


def refined(
    cost: Ridge,
    x: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    imposed: ConstraintFunctions,
    *,
    steps: int,
    stop: Callable[[], bool] = lambda: False,
) -> LastSteps:
    """Move a solution onto constraints that it violates slightly, and take the `last_steps` from there.

    The arguments are those of `last_steps`. The result has not converged if the constraints cannot be
    satisfied near x.
    """
    feasible = restore(cost, x, lower, upper, RESTORING_DAMPING, imposed)
    return last_steps(cost, x if feasible is None else feasible, lower, upper, imposed, steps=steps, stop=stop)


def continued(
    cost: Ridge,
    x: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    imposed: ConstraintFunctions,
    *,
    steps: int,
    stop: Callable[[], bool] = lambda: False,
) -> LastSteps:
    """Take Gauss-Newton steps from the solution for fewer rows.

    The arguments are those of `last_steps`, which decides whether the point is the optimum: less damping predicts more.
    """
    enough = _Criterion(cost.problem)
    first = _steps_until(enough, APPROACH, cost, x, lower, upper, imposed, steps, stop)
    if stop():
        return replace(first, converged=False)
    last = _steps_until(enough, DAMPING, cost, first.x, lower, upper, imposed, steps - first.steps, stop)
    return replace(last, steps=first.steps + last.steps)
