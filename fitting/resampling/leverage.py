"""Corrections of a bootstrap by sweeps for sweeps that the fit follows, and for few sweeps.

A fit follows each of its sweeps, so residuals of a sweep are smaller than its noise, and replicates with random weights
of sweeps differ less than fits to new noise. Let A_g = J_g^T W J_g be the matrix of sweep g, A their sum, and C the
inverse of the matrix of the fit, which has slope targets and the regularization as well. If the noise of all rows is
independent, the fit has the covariance C A C. Replicates have on average C B C, where B is the sum over the sweeps of

    A_g - 2 A_g C A_g + A_g C A C A_g.

The deviations of a coefficient are multiplied by the root of the ratio of both (Bell and McCaffrey, Bias reduction in
standard errors for linear regression with multi-stage samples, 2002; for generalized linear models Kauermann and
Carroll, 2001). A variance that is estimated from few sweeps is itself uncertain: if the shares of the sweeps in the
variance of a coefficient are p_g, it has (sum p_g)^2 / sum p_g^2 degrees of freedom (Satterthwaite, 1946), and an
interval is expanded by Student's quantile over that of the normal distribution (Hesterberg, What teachers should know
about the bootstrap, 2015).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from ...numerics.arrays import FloatArray, IntArray
from ..problem.weighted_residuals import Ridge
from ..results.stages import StageResult
from ..uncertainty.sandwich import MIN_CURVATURE, QUANTILE


@dataclass(frozen=True)
class Correction:
    """What multiplies the deviations of the replicates of a coefficient.

    - `leverage`: for sweeps that the fit follows; 1 without.
    - `sweeps`: degrees of freedom: the effective number of sweeps.
    """

    leverage: float
    sweeps: float

    @property
    def expansion(self) -> float:
        """Of the interval: for the leverage, and by Student's distribution for few sweeps."""
        return self.leverage * float(stdtrit(max(self.sweeps, 1.0), 0.975)) / QUANTILE


def corrections(stage: StageResult, determined: Collection[str], sweeps: IntArray) -> dict[str, Correction]:
    """Return the correction of each coefficient that a stage determines.

    `determined`: the coefficients of which the stage is the last. `sweeps`: number of the sweep of each row of all
    recordings (`tirefmu.fitting.resampling.bootstrap.sweeps_of`). Returns: coefficients at a bound have none.
    """
    problem = stage.problem
    free = np.flatnonzero((stage.x > stage.lower) & (stage.x < stage.upper))
    whole = Ridge(problem, stage.x, stage.ridge).derivatives(stage.x)[2][np.ix_(free, free)]
    sweep_of_row = sweeps[stage.numbers]
    matrices = []
    for number in np.unique(sweep_of_row):
        rows = problem.rows.take(np.flatnonzero(sweep_of_row == number))
        part = replace(problem, rows=rows, targets=())
        matrices.append(part.derivatives(stage.x)[2][np.ix_(free, free)])
    leverage, shares = corrections_of(whole, matrices)
    return {
        problem.free[i]: Correction(float(factor), float(count))
        for i, factor, count in zip(free, leverage, shares, strict=True) if problem.free[i] in determined
    }  # fmt: skip


def corrections_of(whole: FloatArray, sweeps: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return factor and degrees of freedom of each coefficient of a linear problem.

    `whole`, shape (n, n): matrix of the problem. `sweeps`, shape (n, n): contribution of each sweep. Returns `leverage,
    degrees_of_freedom`, shape (n,).

    A mean of two values: the fit follows each of them by half.

    >>> leverage, freedom = corrections_of(np.array([[2.0]]), [np.array([[1.0]])] * 2)
    >>> round(float(leverage[0] ** 2), 9), float(freedom[0])
    (2.0, 2.0)
    """
    values, vectors = np.linalg.eigh(whole)
    determined = values > MIN_CURVATURE * max(float(values[-1]), 0.0)
    inverse = (vectors[:, determined] / values[determined]) @ vectors[:, determined].T
    total = np.sum(sweeps, axis=0)
    followed = inverse @ total @ inverse
    middle, squares = np.zeros_like(whole), np.zeros(len(whole))
    for matrix in sweeps:
        middle += matrix - 2.0 * matrix @ inverse @ matrix + matrix @ followed @ matrix
        squares += np.einsum("ij,jk,ki->i", inverse, matrix, inverse) ** 2
    variance = np.diag(followed)
    expected = np.einsum("ij,jk,ki->i", inverse, middle, inverse)
    with np.errstate(divide="ignore", invalid="ignore"):
        leverage = np.sqrt(np.where(expected > 0.0, variance / expected, 1.0))
        freedom = np.where(squares > 0.0, variance**2 / squares, np.inf)
    return np.maximum(leverage, 1.0), freedom
