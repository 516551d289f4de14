r"""The convergence criterion of a fit: the predicted reduction of the cost; and the last Gauss-Newton steps.

`tirefmu.numerics.gauss_newton` takes the steps. The noise determines the tolerance. With N independent rows and the
cost F = N sigma^2 / 2, the estimation error of n coefficients has the squared length n sigma^2 in the norm of J^T W J:
fitting noise reduces the cost by n F / N. A predicted reduction of `STEP_TOLERANCE`^2 times this value is a step of a
tenth of a standard error, root mean square over the coefficients. N is the effective sample size, because noise is
correlated in time. The noise is assumed to be at least `MIN_NOISE` of the signal: below it, the cost is rounding
error.

The book's equations jump where the argument of a sign function is 0: at a side slip of exactly 0 and QHZ1 = 0, the
trail under longitudinal slip is larger than next to it. If the cost jumps up, the derivatives do not predict it, and no
step that leaves the jump is accepted. The optimum is then the better of two: with these coefficients held at the jump,
and that of steps from next to it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...numerics.arrays import BoolArray, FloatArray
from ...numerics.correlation import effective_sample_size
from ...numerics.gauss_newton import NO_STEP, Damping, Minimum, minimize, restore
from ..constraints.constraint_functions import ConstraintFunctions
from ..problem.weighted_residuals import Problem, Ridge
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
#: Change of a scaled value from a jump to a point next to it.
NEXT_TO = 1e-7


@dataclass(frozen=True)
class LastSteps:
    """The result of the last steps.

    - `x`, shape (n_free,).
    - `steps`: number of steps, without the last one.
    - `reason`: a text for the user.
    - `errors`: most standard errors by which a coefficient differs from its optimum; infinite if it is not known.
    """

    x: FloatArray
    steps: int
    converged: bool
    reason: str
    errors: float


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


def cost_of_a_row(problem: Problem, x: FloatArray) -> float:
    """Return the cost of one independent row with the noise at x, shape (n_free,): scaled free values."""
    least, rows = noise_of(problem, x)
    return max(problem.cost(x), least) / max(rows, 1.0)


class _Criterion:
    """The predicted reduction at which a point is the optimum, and the cost to which it is compared."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._whole, self._size, self._row = "cost", 1.0, 1.0
        self._noise: tuple[float, float, float] = (np.nan, 0.0, 0.0)  # for which cost, and the result of `noise_of`

    def __call__(self, x: FloatArray, cost: float) -> float:
        if not abs(cost - self._noise[0]) <= SAME_NOISE * cost:
            self._noise = cost, *noise_of(self._problem, x)
        _, noise, rows = self._noise
        self._whole, self._size = "cost" if cost >= noise else "least noise", max(cost, noise)
        self._row = self._size / max(rows, 1.0)
        return STEP_TOLERANCE**2 * min(len(x) * self._row, self._size)

    def share(self, reduction: float) -> str:
        """Return a reduction relative to the cost, or to the least noise if the cost is smaller."""
        return f"{reduction / self._size:.0e} of the {self._whole}"

    def standard_errors(self, reduction: float) -> float:
        """Return how far a coefficient may move, in standard errors, for a reduction of the cost."""
        return float(np.sqrt(max(reduction, 0.0) / self._row))


@dataclass(frozen=True, eq=False)
class GaussNewton:
    """Gauss-Newton steps of a problem with bounds and physical constraints.

    - `lower`, `upper`, shape (n_free,): bounds of the scaled free values.
    - `stop`: called after every step; True ends the loop.

    Its methods take x, shape (n_free,), the scaled free values of the start, and the upper limit of the steps.
    """

    cost: Ridge
    lower: FloatArray
    upper: FloatArray
    imposed: ConstraintFunctions
    stop: Callable[[], bool] = lambda: False

    def last(self, x: FloatArray, steps: int) -> LastSteps:
        """Take steps until the criterion of this module is met or no step is possible; with 0 it is only evaluated."""
        return self._steps(_Criterion(self.cost.problem), DAMPING, x, steps)

    def refined(self, x: FloatArray, steps: int) -> LastSteps:
        """Move a solution onto constraints that it violates slightly, and take the `last` steps from there.

        The result has not converged if the constraints cannot be satisfied near x.
        """
        feasible = restore(self.cost, x, self.lower, self.upper, RESTORING_DAMPING, self.imposed)
        return self.last(x if feasible is None else feasible, steps)

    def continued(self, x: FloatArray, steps: int) -> LastSteps:
        """Take steps from the solution for fewer rows; undamped ones decide whether the point is the optimum."""
        enough = _Criterion(self.cost.problem)
        first = self._steps(enough, APPROACH, x, steps)
        if self.stop():
            return replace(first, converged=False)
        last = self._steps(enough, DAMPING, first.x, steps - first.steps)
        return replace(last, steps=first.steps + last.steps)

    def _steps(self, enough: _Criterion, damping: Damping, x: FloatArray, steps: int) -> LastSteps:
        end = self._minimum(enough, damping, steps, x, self.lower, self.upper)
        if end.reason == NO_STEP:
            end = self._around_jumps(enough, damping, steps, end)
        reason, errors = end.reason, np.inf
        if np.isfinite(end.predicted):
            reason = f"predicted reduction {enough.share(end.predicted)}" + f", {reason}" * bool(reason)
            errors = enough.standard_errors(end.predicted)
        return LastSteps(end.x, end.steps, end.converged, reason, errors)

    def _minimum(
        self, enough: _Criterion, damping: Damping, steps: int, x: FloatArray, lower: FloatArray, upper: FloatArray
    ) -> Minimum:
        return minimize(
            self.cost, x, lower, upper, enough, damping, steps=steps, constraints=self.imposed, stop=self.stop
        )

    def _around_jumps(self, enough: _Criterion, damping: Damping, steps: int, end: Minimum) -> Minimum:
        """Return the better optimum held at the jumps of a point or beyond them; the point itself without any."""
        x = end.x
        changes, jumps = self._jumps(end, damping.trusted * enough(x, end.cost))
        if not jumps.any():
            return end
        side = np.where(changes[0] < changes[1], NEXT_TO, -NEXT_TO)
        starts = [(np.clip(x + side * jumps, self.lower, self.upper), self.lower, self.upper)]
        if (changes[:, jumps] > 0.0).all():
            starts.append((x, np.where(jumps, x, self.lower), np.where(jumps, x, self.upper)))
        ends, taken = list[Minimum](), end.steps
        for start, lower, upper in starts:
            near = self._minimum(enough, APPROACH, steps - end.steps, start, lower, upper)
            last = self._minimum(enough, damping, steps - end.steps - near.steps, near.x, lower, upper)
            ends, taken = [*ends, last], taken + near.steps + last.steps
        optima = [other for other in ends if other.converged and other.cost <= end.cost]
        best = min(optima, key=lambda minimum: minimum.cost, default=end)
        enough(best.x, best.cost)  # the result is reported relative to this cost
        return replace(best, steps=taken)

    def _jumps(self, end: Minimum, threshold: float) -> tuple[FloatArray, BoolArray]:
        """Return the changes of the cost next to a point, shape (2, n_free), and which coefficients make it jump.

        `threshold`: least deviation of a jump from the change that the derivatives predict.
        """
        _, gradient, matrix = self.cost.derivatives(end.x)
        sides = np.array([NEXT_TO, -NEXT_TO])
        changes = np.array([[self.cost.cost(end.x + e) - end.cost for e in s * np.eye(len(end.x))] for s in sides])
        predicted = np.outer(sides, gradient) + 0.5 * np.outer(sides**2, np.diag(matrix))
        return changes, np.asarray(np.any(np.abs(changes - predicted) > threshold, axis=0))
