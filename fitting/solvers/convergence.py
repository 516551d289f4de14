r"""Whether a point is the optimum of a fit, by what a step from it could still gain; and the last steps to it.

`tirefmu.estimation.gauss_newton` takes the steps. How little predicted reduction is little enough follows from the
noise. N independent rows with cost F = N sigma^2 / 2 give n coefficients an error whose squared length, in the measure
of J^T W J, is n sigma^2: fitting noise lowers the cost by n F / N. A predicted reduction of `TENTH`^2 of that is a step
of a tenth of a standard error, root mean square over the coefficients. N is the effective sample size, as noise is
correlated in time. Data without noise count as having the least that weights are made for (`LEAST_NOISE`): the
remaining cost is rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.correlation import effective_sample_size
from tirefmu.estimation.gauss_newton import Damping, minimize

from ..constraints.constraint_functions import ConstraintFunctions
from ..problem.regularization import Ridge
from ..problem.weighted_residuals import LEAST_NOISE, Problem

FloatArray = npt.NDArray[np.float64]
#: The step that counts as none, in standard errors.
STEP_TOLERANCE = 0.1
#: In scaled coefficients: from the least for which the matrix is safely regular, anew at each step.
DAMPING = Damping(first=1e-7, least=1e-7, most=1.0, up=10.0, down=0.0, by_curvature=False, trusted=0.1)


@dataclass(frozen=True)
class LastSteps:
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


class _Criterion:
    """The predicted reduction at which a point of a problem counts as the optimum; what it is a share of."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._whole, self._size = "cost", 1.0

    def __call__(self, x: FloatArray, cost: float) -> float:
        noise, rows = noise_of(self._problem, x)
        self._whole, self._size = "cost" if cost >= noise else "least noise", max(cost, noise)
        return STEP_TOLERANCE**2 * self._size * min(len(x) / max(rows, 1.0), 1.0)

    def share(self, reduction: float) -> str:
        """Return what a reduction is of the cost, or of the least noise where there is less than that."""
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
    """Take Gauss-Newton steps until the point is the optimum by the criterion of this module, and report whether it is.

    Parameters
    ----------
    cost : Ridge
    x, lower, upper : ndarray, shape (n_free,)
        Scaled free values and their bounds.
    imposed : ConstraintFunctions
        The physical constraints.
    steps : int
        Upper limit; with 0 of them x is only judged.
    stop : callable
        Called after every step: whether to end there.

    Returns
    -------
    LastSteps
    """
    enough = _Criterion(cost.problem)
    end = minimize(cost, x, lower, upper, enough, DAMPING, steps=steps, constraints=imposed, stop=stop)
    reason = end.reason
    if np.isfinite(end.predicted):
        reason = f"predicted reduction {enough.share(end.predicted)}" + f", {reason}" * bool(reason)
    return LastSteps(end.x, end.steps, end.converged, reason)
