"""The score of an explanation: its evidence by Laplace's approximation.

The coefficients and everything else that an explanation contains are columns of a problem that is linear at its refit.
The likelihood is raised to a power below 1, because no model of a tire is exact (Miller and Dunson, Robust Bayesian
inference via coarsening, JASA 114, 2019). For Gaussian noise this is a larger variance of the noise.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.special import log_ndtr

from ...numerics.arrays import FloatArray, IndexArray, IntArray
from ..signals.signals import Signals
from ..thresholds import COARSENED_ROWS, FOLDS, FORM_ERROR, INEXACT_SHARE

#: Added to the diagonal of scaled matrices, whose diagonal is 1: columns may be equal.
RIDGE = 1e-11


def likelihood_power(rows: int) -> float:
    """Return the power of the likelihood of a recording, as in a coarsened posterior.

    >>> likelihood_power(0), likelihood_power(COARSENED_ROWS)
    (1.0, 0.5)
    """
    return COARSENED_ROWS / (COARSENED_ROWS + rows)


def inflation(explained: float) -> float:
    """Return the factor on the variance of the noise of an explanation whose form is not exact.

    `explained`: logarithm of the likelihood by which the explanation is better than none.

    >>> inflation(0.0), inflation(1.0 / INEXACT_SHARE)
    (1.0, 2.0)
    """
    return 1.0 + INEXACT_SHARE * max(explained, 0.0)


def caution(explained: float, inexact: float) -> float:
    """Return the factor by which probabilities divide the logarithm of the evidence of a comparison, at least 1.

    The form of an effect may err by `FORM_ERROR` of its response: this share, squared, of what is explained states
    nothing about which effect explains it. `explained`: as in `inflation`, by the explanation; `inexact`: that of the
    noise of the comparison.

    >>> caution(0.0, 0.0), bool(caution(1000.0, 1000.0) > 5.0)
    (1.0, True)
    """
    return max((1.0 + FORM_ERROR**2 * max(explained, 0.0)) / inflation(inexact), 1.0)


def folds_of(signals: Signals) -> IntArray:
    """Return the fold, 0 to `FOLDS` - 1, of each compared row: a random part of the blocks of time."""
    blocks = np.unique(signals.block)
    return np.asarray(
        (np.random.default_rng(0).permutation(len(blocks)) % FOLDS)[np.searchsorted(blocks, signals.block)]
    )


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """Cross products of columns and residual in noise standard deviations, and the priors of the columns.

    - `matrix`, shape (m, m), and `target`, shape (m,).
    - `power`: sum of squares of the residual, and of the distances of all values from their prior means.
    - `precision`, shape (m,): inverse variances of the priors.
    - `gradient`, shape (m,): of the priors, where values are away from their means.
    - `limits`, shape (2, m): least and largest change of each coefficient, infinite if it has no bound; None if none
      has one. An effect gains nothing by a coefficient beyond its bound.
    """

    matrix: FloatArray
    target: FloatArray
    power: float
    precision: FloatArray
    gradient: FloatArray
    limits: FloatArray | None = None

    def without(self, columns: Collection[int]) -> NormalEquations:
        """Return the equations without some of the columns."""
        others = np.delete(np.arange(len(self.target)), list(columns))
        limits = None if self.limits is None else self.limits[:, others]
        return NormalEquations(
            self.matrix[np.ix_(others, others)], self.target[others], self.power, self.precision[others],
            self.gradient[others], limits,
        )  # fmt: skip

    def solved(self) -> tuple[FloatArray, float]:
        """Return the estimate, shape (m,), and the logarithm of the evidence, up to a constant of the recording.

        >>> one = NormalEquations(np.eye(1), np.array([3.0]), 9.0, np.ones(1), np.zeros(1))
        >>> estimate, evidence = one.solved()
        >>> estimate.round(6).tolist(), bool(np.isclose(evidence, -0.5 * (9.0 / 2.0 + np.log(2.0))))
        ([1.5], True)

        Only the share of the posterior within the limits counts, relative to that of the prior.

        >>> from dataclasses import replace
        >>> positive = replace(one, limits=np.array([[0.0], [np.inf]]))
        >>> negative = replace(positive, target=-one.target)
        >>> [round(equations.solved()[1] - evidence, 2) for equations in (positive, negative)]
        [0.68, -3.38]
        """
        (factor, _), scale = self.factor
        target = scale * (self.target + self.gradient)
        estimate = cho_solve((factor, True), target)
        curvature = 2.0 * float(np.sum(np.log(np.diag(factor)) - np.log(scale)))
        fit = float(target @ estimate) - self.power
        evidence = 0.5 * (fit - curvature + float(np.sum(np.log(self.precision))))
        return scale * estimate, evidence + self._share_within_limits(scale * estimate)

    def _share_within_limits(self, estimate: FloatArray) -> float:
        """Return the logarithm of the share of the posterior within the limits, relative to that of the prior."""
        if self.limits is None:
            return 0.0
        limited = np.flatnonzero(np.isfinite(self.limits).any(axis=0))
        deviation = np.sqrt(np.sum(self._half_covariance(limited) ** 2, axis=0))
        limits, precision = self.limits[:, limited], self.precision[limited]
        share = _log_share((limits - estimate[limited]) / deviation)
        of_prior = _log_share((limits - self.gradient[limited] / precision) * np.sqrt(precision))
        return float(np.sum(share - of_prior))

    def _half_covariance(self, columns: Sequence[int] | IndexArray) -> FloatArray:
        """Return the factor whose product with itself is the posterior covariance of columns, shape (m, k)."""
        (factor, _), scale = self.factor
        unit = np.zeros((len(scale), len(columns)))
        unit[columns, range(len(columns))] = scale[columns]
        return np.asarray(solve_triangular(factor, unit, lower=True, check_finite=False))

    @cached_property
    def factor(self) -> tuple[tuple[FloatArray, bool], FloatArray]:
        """Cholesky factor of the matrix with the priors, and the factors that scale its diagonal to 1, shape (m,)."""
        return self.factored(RIDGE)

    def factored(self, ridge: float) -> tuple[tuple[FloatArray, bool], FloatArray]:
        """Return the same with an addition to the diagonal."""
        scale = 1.0 / np.sqrt(np.diag(self.matrix) + self.precision)
        whole = scale[:, None] * self.matrix
        whole *= scale
        whole.flat[:: len(scale) + 1] += self.precision * scale**2 + ridge
        return cho_factor(whole.T, lower=True, overwrite_a=True), scale  # the transpose is in the order of LAPACK

    def gain_of(self, columns: Collection[int]) -> float:
        """Return the increase of the logarithm of the evidence by some unlimited columns (Savage and Dickey).

        >>> matrix = np.array([[4.0, 1.0], [1.0, 3.0]])
        >>> both = NormalEquations(matrix, np.array([3.0, 2.0]), 9.0, np.ones(2), np.zeros(2))
        >>> bool(np.isclose(both.gain_of([1]), both.solved()[1] - both.without([1]).solved()[1]))
        True
        """
        chosen = list(columns)
        half = self._half_covariance(chosen)
        covariance, mean = half.T @ half, self.solved()[0][chosen]
        fit = float(mean @ np.linalg.solve(covariance, mean))
        return 0.5 * (fit + float(np.linalg.slogdet(covariance)[1] + np.sum(np.log(self.precision[chosen]))))

    def estimate_of(self, column: int) -> tuple[float, float]:
        """Return the estimate of a column, and its standard deviation.

        >>> both = NormalEquations(np.diag([4.0, 3.0]), np.array([3.0, 2.0]), 9.0, np.ones(2), np.zeros(2))
        >>> [round(value, 6) for value in both.estimate_of(0)]
        [0.6, 0.447214]
        """
        return float(self.solved()[0][column]), float(np.linalg.norm(self._half_covariance([column])))

    def with_target(self, target: FloatArray, power: float, unlimited: Collection[int]) -> NormalEquations:
        """Return the equations of another residual, for which some columns have no limits."""
        limits = None if self.limits is None else self.limits.copy()
        if limits is not None:
            limits[:, list(unlimited)] = [[-np.inf], [np.inf]]
        other = replace(self, target=target, power=power, limits=limits)
        other.__dict__["factor"] = self.factor
        return other

    def extended(self, added: NormalEquations, cross: FloatArray) -> NormalEquations:
        """Return the equations with those of further columns; `cross`, shape (m, k): their products with these."""
        target, precision, gradient = (
            np.concatenate([getattr(equations, name) for equations in (self, added)])
            for name in ("target", "precision", "gradient")
        )
        matrix = np.block([[self.matrix, cross], [cross.T, added.matrix]])
        limits = None if self.limits is None or added.limits is None else np.hstack([self.limits, added.limits])
        return NormalEquations(matrix, target, self.power, precision, gradient, limits)


def _log_share(limits: FloatArray) -> FloatArray:
    """Return the logarithm of the share of a standard normal distribution within limits, shape (2, k)."""
    low, high = np.where(limits[0] > -limits[1], -limits[::-1], limits)  # the share on the other side is the same
    above, below = log_ndtr(high), log_ndtr(low)
    return np.asarray(above + np.log1p(-np.exp(below - above)))


@dataclass(frozen=True, eq=False)
class Projected:
    """Columns of additions, in prior deviations, with the columns of the explanation projected out.

    - `matrix`, shape (k, k), and `target`, shape (k,).
    - `groups`: the columns of each addition.
    """

    matrix: FloatArray
    target: FloatArray
    groups: tuple[slice, ...]

    @classmethod
    def of(cls, normal: NormalEquations, sizes: Sequence[int]) -> Projected:
        """Return the last columns of equations, in groups of given sizes, with all others projected out."""
        always = len(normal.target) - sum(sizes)
        cross = normal.matrix[:always, always:]
        return cls.beside(
            normal.without(range(always, len(normal.target))), normal.without(range(always)), cross, sizes
        )

    @classmethod
    def beside(
        cls, normal: NormalEquations, added: NormalEquations, cross: FloatArray, sizes: Sequence[int]
    ) -> Projected:
        """Return further columns, in groups of given sizes, with those of equations projected out.

        `cross`, shape (m, k): products of the columns of both.
        """
        (factor, _), scale = normal.factor
        beside = solve_triangular(factor, scale[:, None] * cross, lower=True)
        along = solve_triangular(factor, scale * (normal.target + normal.gradient), lower=True)
        deviation = added.precision**-0.5
        matrix = deviation[:, None] * (added.matrix - beside.T @ beside) * deviation
        ends = np.cumsum([0, *sizes]).tolist()
        return cls(matrix, deviation * (added.target - beside.T @ along), tuple(map(slice, ends, ends[1:])))

    def gain(self, group: slice) -> tuple[float, FloatArray]:
        """Return the increase of the logarithm of the evidence by an addition, and its estimate in prior deviations."""
        inner = self.matrix[group, group] + np.eye(group.stop - group.start)
        estimate = np.asarray(np.linalg.solve(inner, self.target[group]))
        return 0.5 * float(self.target[group] @ estimate - np.linalg.slogdet(inner)[1]), estimate

    def correlations(self, group: slice) -> FloatArray:
        """Return the correlation of each column, shape (k,), with the best combination of an addition's columns."""
        size = np.sqrt(np.maximum(np.diag(self.matrix), 1e-300))
        scaled = self.matrix / np.outer(size, size)
        inner = scaled[group, group] + 1e-9 * np.eye(group.stop - group.start)
        return np.asarray(np.sqrt(np.einsum("gk,gk->k", scaled[group], np.linalg.solve(inner, scaled[group]))))
