r"""Damped Gauss-Newton with bounds and linearized constraints, used by the fit and the diagnosis.

Each step minimizes the quadratic model of the cost, g'p + p'(H + damping D)p/2, subject to bounds and linearized
constraints (`best_step`): the Levenberg-Marquardt method with the exact solution of the bounded subproblem.
Nocedal and Wright, Numerical Optimization, 2nd ed. 2006, chapters 10.3 (Gauss-Newton with damping), 12 (active
constraints), 16 (the quadratic program) and 18 (sequential programs).

The loop ends when the predicted reduction of the quadratic model is at most the tolerance of the caller. The predicted
reduction is half the squared norm of the projected gradient in the metric of the inverse matrix of the model. It
depends neither on units nor on the path to the point.

In the metric of the Cholesky factor of H, the minimum of g'p + p'Hp/2 subject to bounds on A p is the point of a
polyhedron nearest to the origin. This is a non-negative least-squares problem (Lawson and Hanson, Solving Least Squares
Problems, 1974, chapter 23).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls

from .arrays import FloatArray
from .one_thread import one_blas_thread

#: Reason of a loop that ends because no step from its point lowers the cost as predicted.
NO_STEP = "no step is accepted"
#: Tolerance of a satisfied row, relative to its length times the length of the step.
ROUNDING = 1e-12
#: Upper limit of corrections of a step that violates constraints because they are nonlinear.
CORRECTIONS = 2
#: Upper limit of steps towards the constraints from a point that violates them slightly.
RESTORING_STEPS = 5


class Objective(Protocol):
    """A cost with its Gauss-Newton model."""

    def cost(self, x: FloatArray) -> float:
        """Return the cost at x, shape (n,)."""

    def derivatives(self, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return cost, gradient (n,) and Gauss-Newton matrix (n, n) at x."""


class Constraints(Protocol):
    """Inequalities ``low <= values(x) <= high``."""

    @property
    def low(self) -> FloatArray:
        """Lower bounds, shape (m,)."""

    @property
    def high(self) -> FloatArray:
        """Upper bounds, shape (m,)."""

    def values(self, x: FloatArray) -> FloatArray:
        """Return the constrained values at x, shape (m,)."""

    def slopes(self, x: FloatArray) -> FloatArray:
        """Return their derivatives by x, shape (m, n)."""

    def satisfied(self, values: FloatArray) -> bool:
        """Return whether values are within the bounds, with the tolerance of the caller; NaN is not."""


class Unconstrained:
    """No constraints except the bounds."""

    low = high = np.zeros(0)

    def values(self, x: FloatArray) -> FloatArray:
        """Return an empty array."""
        return np.zeros(0)

    def slopes(self, x: FloatArray) -> FloatArray:
        """Return an empty array."""
        return np.zeros((0, len(x)))

    def satisfied(self, values: FloatArray) -> bool:
        """Return True."""
        return True


@dataclass(frozen=True)
class Damping:
    """Settings of the damping.

    - `first`, `least`, `most`: initial value and limits. The loop ends if the step with damping `most` is rejected.
    - `up`, `down`: factors after a rejected and an accepted step; with ``down`` 0 each iteration starts with `least`.
    - `by_curvature`: whether D is the diagonal of H (Marquardt), for coefficients in their own units, or the identity
      (Levenberg), for scaled ones.
    - `trusted`: a step is accepted if it lowers the cost by more than this share of the predicted reduction.
    """

    first: float
    least: float
    most: float
    up: float
    down: float
    by_curvature: bool
    trusted: float


@dataclass(frozen=True, eq=False)
class Minimum:
    """The result of the loop.

    - `x`, shape (n,).
    - `cost`: the cost at x.
    - `steps`: number of steps, without the last one after convergence.
    - `converged`: whether the predicted reduction is within the tolerance.
    - `predicted`: the predicted reduction; infinite if it cannot be computed.
    - `reason`: why there is no optimum; empty if the loop converged, or if `steps` or `stop` ended it.
    """

    x: FloatArray
    cost: float
    steps: int
    converged: bool
    predicted: float
    reason: str = ""


def minimize(
    objective: Objective,
    x: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    enough: Callable[[FloatArray, float], float],
    damping: Damping,
    *,
    steps: int,
    constraints: Constraints | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> Minimum:
    """Take damped Gauss-Newton steps until the predicted reduction is small enough.

    `x`, `lower`, `upper`, shape (n,): start, within the bounds, and the bounds. `enough`: returns for x and its cost
    the largest predicted reduction of an optimum (the tolerance). The last step is taken, too. `steps`: upper limit;
    with 0 the criterion is only evaluated at the start. `stop`: called after every step; True ends the loop. There is a
    result also if the start violates a constraint, a value is not finite, or no step is accepted.

    >>> class Line:  # residuals 2 x - 3
    ...     def cost(self, x):
    ...         return float(0.5 * (2.0 * x - 3.0) @ (2.0 * x - 3.0))
    ...     def derivatives(self, x):
    ...         return self.cost(x), 2.0 * (2.0 * x - 3.0), np.full((1, 1), 4.0)
    >>> levenberg = Damping(1e-9, 1e-9, 1.0, 10.0, 0.0, by_curvature=False, trusted=0.1)
    >>> zero, one = np.zeros(1), np.ones(1)
    >>> free = minimize(Line(), zero, -9.0 * one, 9.0 * one, lambda x, cost: 1e-12, levenberg, steps=9)
    >>> bounded = minimize(Line(), zero, -one, one, lambda x, cost: 1e-12, levenberg, steps=9)
    >>> free.x.round(6).tolist(), bounded.x.tolist(), free.converged
    ([1.5], [1.0], True)
    """
    limits = constraints or Unconstrained()
    damped = damping.first
    with one_blas_thread():
        for taken in range(steps + 1):
            here = _Point.at(objective, limits, x, lower, upper)
            if here.reason:
                return Minimum(x, here.cost, taken, converged=False, predicted=np.inf, reason=here.reason)
            tolerance = enough(x, here.cost)
            candidate = here.step(damping, damped, tolerance)
            if candidate.predicted <= tolerance:
                last = candidate.x if candidate.x is not None and steps else x
                cost = candidate.cost if candidate.x is not None and steps else here.cost
                return Minimum(last, cost, taken, converged=True, predicted=candidate.predicted)
            if candidate.x is None or taken == steps or stop():
                reason = NO_STEP if candidate.x is None else ""
                return Minimum(x, here.cost, taken, converged=False, predicted=candidate.predicted, reason=reason)
            x, damped = candidate.x, max(candidate.damping * damping.down, damping.least)
    raise AssertionError("the loop returns at its last step")


def restore(
    objective: Objective, x: FloatArray, lower: FloatArray, upper: FloatArray, damping: float, constraints: Constraints
) -> FloatArray | None:
    """Return a point near x that satisfies the constraints: minimum of the quadratic model with linearized constraints.

    `x`, `lower`, `upper`, shape (n,): a point that violates the constraints slightly, and the bounds. `damping`:
    multiple of the identity that is added to the Gauss-Newton matrix. Returns shape (n,): none if a few steps do not
    satisfy the constraints.
    """
    with one_blas_thread():
        for _ in range(RESTORING_STEPS):
            values, slopes = constraints.values(x), constraints.slopes(x)
            if constraints.satisfied(values):
                return x
            _, gradient, matrix = objective.derivatives(x)
            if not all(np.isfinite(array).all() for array in (gradient, matrix, values, slopes)):
                return None
            rows = np.concatenate([np.eye(len(x)), slopes])
            least = np.concatenate([lower - x, constraints.low - values])
            most = np.concatenate([upper - x, constraints.high - values])
            try:
                step, _ = best_step(gradient, matrix + damping * np.eye(len(x)), rows, least, most)
            except np.linalg.LinAlgError:
                return None
            x = _moved(x, step, lower, upper)
    return x if constraints.satisfied(constraints.values(x)) else None


def _moved(x: FloatArray, step: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Return x after a step, exactly on each bound from which it is apart by rounding errors."""
    moved, span = np.clip(x + step, lower, upper), upper - lower
    apart = ROUNDING * np.max([np.abs(x), np.abs(step), np.where(np.isfinite(span), span, 0.0)], axis=0)
    return np.where(moved - lower <= apart, lower, np.where(upper - moved <= apart, upper, moved))


@dataclass(frozen=True, eq=False)
class _Step:
    """The step from a point: the predicted reduction, the new point (None if no step is accepted), the damping."""

    predicted: float
    x: FloatArray | None
    cost: float
    damping: float


@dataclass(frozen=True, eq=False)
class _Point:
    """A point with the quadratic model of the cost and the linearized constraints."""

    objective: Objective
    constraints: Constraints
    x: FloatArray
    lower: FloatArray
    upper: FloatArray
    cost: float
    gradient: FloatArray
    matrix: FloatArray
    values: FloatArray
    slopes: FloatArray
    reason: str

    @classmethod
    def at(
        cls, objective: Objective, constraints: Constraints, x: FloatArray, lower: FloatArray, upper: FloatArray
    ) -> _Point:
        cost, gradient, matrix = objective.derivatives(x)
        values, slopes = constraints.values(x), constraints.slopes(x)
        reason = ""
        if not np.isfinite(cost) or not all(np.isfinite(array).all() for array in (gradient, matrix, values, slopes)):
            reason = "cost, constraints or derivatives are not finite"
        elif not constraints.satisfied(values):
            beyond = max(np.max(constraints.low - values), np.max(values - constraints.high))
            reason = f"a constraint is violated by {beyond:.0e} of its size"
        return cls(objective, constraints, x, lower, upper, cost, gradient, matrix, values, slopes, reason)

    def step(self, damping: Damping, damped: float, tolerance: float) -> _Step:
        """Return the step with the least damping that is accepted, and its predicted reduction.

        If the first predicted reduction is within the tolerance, it is returned even if its step is rejected, because
        more damping predicts less. A step is tried nevertheless: the last one leads exactly to the active bounds and
        constraints.
        """
        predicted = np.inf
        while damped <= damping.most:
            reduction, after, cost = self._tried(damped, damping)
            if not np.isfinite(predicted) or predicted > tolerance:
                predicted = reduction
            if after is not None:
                return _Step(predicted, after, cost, damped)
            damped *= damping.up
        return _Step(predicted, None, self.cost, damped)

    def _tried(self, damped: float, damping: Damping) -> tuple[float, FloatArray | None, float]:
        """Return the predicted reduction of a damped model, the new point if it is accepted, and its cost."""
        n = len(self.x)
        size = np.sqrt(np.diag(self.matrix)) if damping.by_curvature else np.ones(n)
        size = np.where(size > 0.0, size, 1.0)  # steps are scaled, so that the damping is the identity
        matrix = self.matrix / np.outer(size, size) + damped * np.eye(n)
        rows = np.concatenate([np.eye(n), self.slopes / size])
        now, predicted = self.values, np.inf
        for correction in range(1 + CORRECTIONS):
            least = np.concatenate([(self.lower - self.x) * size, self.constraints.low - now])
            most = np.concatenate([(self.upper - self.x) * size, self.constraints.high - now])
            if not correction:  # constraints may be violated within the tolerance
                least, most = np.minimum(least, 0.0), np.maximum(most, 0.0)
            try:
                scaled, reduction = best_step(self.gradient / size, matrix, rows, least, most)
            except np.linalg.LinAlgError:
                break
            predicted = reduction if not correction else predicted
            step = scaled / size
            after = _moved(self.x, step, self.lower, self.upper)
            values = self.constraints.values(after)
            if self.constraints.satisfied(values):
                cost = self.objective.cost(after)
                return predicted, after if self.cost - cost > damping.trusted * predicted else None, cost
            now = values - self.slopes @ step
        return predicted, None, self.cost


def best_step(
    gradient: FloatArray, matrix: FloatArray, rows: FloatArray, least: FloatArray, most: FloatArray
) -> tuple[FloatArray, float]:
    """Return the step that minimizes a quadratic model within bounds, and the reduction of the model.

    `gradient`, shape (n,). `matrix`, shape (n, n): positive definite. `rows`, shape (m, n). `least`, `most`, shape
    (m,): bounds of ``rows @ step``; infinite without a bound. A step of zero must be within them. Returns `step`, shape
    (n,). Raises `numpy.linalg.LinAlgError` if the matrix is not positive definite, or no step is found.

    >>> step, reduction = best_step(
    ...     np.array([-2.0, 1.0]), np.eye(2), np.eye(2), np.array([-9.0, 0.0]), np.array([0.5, 9.0])
    ... )
    >>> bool(np.allclose(step, [0.5, 0.0])), round(reduction, 9)
    (True, 0.875)
    """
    factor = cholesky(matrix, lower=True)
    pull = solve_triangular(factor, gradient, lower=True)
    size = float(np.linalg.norm(pull))
    if size == 0.0:
        return np.zeros(len(gradient)), 0.0
    sides = np.concatenate([rows, -rows])
    floors = np.concatenate([least, -most])
    reached = np.isfinite(floors)
    sides, floors = sides[reached], floors[reached]
    lengths = np.linalg.norm(sides, axis=1)
    binding = np.zeros(len(sides), dtype=np.bool_)
    # In the metric of the factor, relative to the unbounded minimum, divided by its distance from the start.
    nearest = np.zeros(len(gradient))
    while True:
        step = solve_triangular(factor, size * nearest - pull, lower=True, trans=1)
        crossed = sides @ step < floors - ROUNDING * lengths * np.linalg.norm(step)
        if not (crossed & ~binding).any():
            break
        binding |= crossed  # only the few active bounds enter the least-squares problem
        nearest = _nearest(factor, sides[binding], floors[binding], pull, size)
    return step, -float(gradient @ step + 0.5 * step @ matrix @ step)


def _nearest(factor: FloatArray, sides: FloatArray, floors: FloatArray, pull: FloatArray, size: float) -> FloatArray:
    """Return the shortest z with ``sides @ step >= floors`` for the step of z."""
    directions = solve_triangular(factor, sides.T, lower=True).T
    heights = (floors + directions @ pull) / size
    lengths = np.linalg.norm(directions, axis=1)
    system = np.concatenate([directions, heights[:, None]], axis=1) / np.where(lengths > 0, lengths, 1.0)[:, None]
    target = np.zeros(system.shape[1])
    target[-1] = 1.0
    try:
        factors, _ = nnls(system.T, target, maxiter=30 * len(system))
    except RuntimeError as error:
        raise np.linalg.LinAlgError(str(error)) from error
    rest = system.T @ factors - target
    if not rest[-1] < 0.0:
        raise np.linalg.LinAlgError("no step is within the bounds")
    return np.asarray(-rest[:-1] / rest[-1])
