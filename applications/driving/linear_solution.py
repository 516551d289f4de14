"""The linearized problem of a drive, solved: a band of the nodes with a border of the unknowns, and its covariances."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cho_solve_banded, cholesky_banded
from scipy.linalg.lapack import dtbtrs

from ...numerics.arrays import BoolArray, FloatArray, IndexArray
from .inputs.grid import Grid
from .linear import Linear

#: Longest step of an unknown in the standard deviations of the car file, and of the logarithm of a deviation.
LONGEST_STEP = 1.0
#: Intervals whose variances or parts of the border are computed at a time. Convention: memory.
SOME = 500
#: Share by which the diagonal of the matrix of the motion is larger, at least: rounding.
LEAST_DAMPING = 1e-9
#: Largest deviation of an unknown: one that reaches it contradicts the car file.
LARGEST = 20.0


@dataclass(frozen=True)
class Posterior:
    """A linearized posterior.

    - `covariance`, shape (n_z, n_z). `pairs`, shape (n, 2 n_states, 2 n_states): covariance of the nodes of an interval
      for given unknowns.
    - `slopes`, shape (n_nodes n_states, n_z): change of the nodes with the unknowns. `ends`, shape (n, 2 n_states):
      which of its rows are the nodes of an interval.
    """

    covariance: FloatArray
    pairs: FloatArray
    slopes: FloatArray
    ends: IndexArray

    def variances(self, linear: Linear) -> FloatArray:
        """Return the variances of functions, shape (n, n_differentiated)."""
        result, n_z = np.empty(linear.by_nodes.shape[:2]), len(self.covariance)
        for some in in_parts(linear):
            of_nodes = linear.by_nodes[some]
            by_z = of_nodes @ self.slopes[self.ends[some]] + linear.by_all(some, n_z)
            given_z = np.sum(of_nodes @ self.pairs[some] * of_nodes, axis=2)
            result[some] = given_z + np.sum(by_z @ self.covariance * by_z, axis=2)
        return result


def in_parts(linear: Linear) -> Iterator[slice]:
    """Go through the intervals, some at a time: a long log has large arrays."""
    for first in range(0, len(linear.values), SOME):
        yield slice(first, first + SOME)


class Factor:
    """The Gauss-Newton matrix, factored: a band of the nodes and, when it is used, a border of the unknowns.

    `linear`: residuals, the last one of which depends on all unknowns.
    """

    def __init__(self, grid: Grid, linear: Linear, damping: float = LEAST_DAMPING) -> None:
        n = linear.by_nodes.shape[2] // 2
        self.n, self._linear, self._size = n, linear, grid.n_nodes * n
        blocks = np.matmul(linear.by_nodes.transpose(0, 2, 1), linear.by_nodes)
        at = np.stack([grid.left, grid.right], axis=1)
        self.ends = (at[:, :, None] * n + np.arange(n)).reshape(len(at), 2 * n)
        band = np.zeros((2 * n, self._size))
        for i in range(2 * n):
            for j in range(i + 1):
                band[i - j, self.ends[:, j]] += blocks[:, i, j]  # no node is twice at the same end of intervals
        band[0] = band[0] * (1.0 + damping) + 1e-12
        self.band = cholesky_banded(band, lower=True, overwrite_ab=True, check_finite=False)
        self.gradient = self.at_nodes(np.einsum("kri,kr->ki", linear.by_nodes, linear.values)[:, :, None])[:, 0]
        self.solved_gradient = self.solved(self.gradient)

    def solved(self, right: FloatArray) -> FloatArray:
        """Return the states for right sides of the band."""
        return np.asarray(cho_solve_banded((self.band, True), right, check_finite=False))

    def at_nodes(self, parts: FloatArray) -> FloatArray:
        """Return the sums at the nodes of parts at both ends of the intervals, shape (n_nodes n, n_columns)."""
        sums = np.zeros((self._size, parts.shape[2]))
        self._add(sums, slice(None), parts)
        return sums

    def _add(self, sums: FloatArray, some: slice, parts: FloatArray) -> None:
        """Add parts at both ends of some intervals to the sums at the nodes."""
        for end in (slice(0, self.n), slice(self.n, 2 * self.n)):
            sums[self.ends[some, end]] += parts[:, end]

    @cached_property
    def _eliminated(self) -> tuple[FloatArray, FloatArray]:
        """The change of the states with the unknowns, and the precision of the unknowns, their prior included."""
        linear = self._linear
        n_z = len(linear.depends[-1])
        precision = np.eye(n_z)
        for by_z, depends in zip(linear.by_z, linear.depends, strict=True):
            precision[np.ix_(depends, depends)] += by_z.T @ by_z
        border = np.zeros((n_z, self._size)).T  # the order of LAPACK, which solves it in place
        for some in in_parts(linear):
            self._add(border, some, np.matmul(linear.by_nodes[some].transpose(0, 2, 1), linear.by_all(some, n_z)))
        half, _ = dtbtrs(self.band, border, uplo="L", overwrite_b=True)
        precision -= half.T @ half
        whole, _ = dtbtrs(self.band, half, uplo="L", trans="T", overwrite_b=True)
        return np.negative(whole, out=whole), precision

    @property
    def slopes(self) -> FloatArray:
        """The change of the states with the unknowns, shape (n_nodes n, n_z)."""
        return self._eliminated[0]

    @property
    def schur(self) -> FloatArray:
        """The precision of the unknowns, their prior included."""
        return self._eliminated[1]

    def _by_z(self, values: FloatArray) -> FloatArray:
        """Return the derivatives of half the squares of residuals by the unknowns, shape (n_residuals, n_z).

        `values`, shape (n, n_residuals).
        """
        linear = self._linear
        result = np.zeros((len(linear.by_z), len(linear.depends[-1])))
        for row, residual, by_z, depends in zip(result, values.T, linear.by_z, linear.depends, strict=True):
            row[depends] = residual @ by_z
        return result

    def slope(self, more: FloatArray) -> FloatArray:
        """Return the derivatives of the cost by the unknowns, for the best states, and `more`."""
        return np.asarray(self._by_z(self._linear.values).sum(axis=0) + more + self.slopes.T @ self.gradient)

    def unexplained(self, values: FloatArray, kinds: IndexArray) -> FloatArray:
        """Return the products of residuals of some kinds with what states and unknowns leave of others, shape (k, k).

        `values`, shape (n, n_residuals).
        """
        rows = values.T[kinds]
        at_nodes = self.at_nodes((self._linear.by_nodes[:, kinds] * rows.T[:, :, None]).transpose(0, 2, 1))
        by_z = self._by_z(values)[kinds] + at_nodes.T @ self.slopes
        explained = at_nodes.T @ self.solved(at_nodes) + by_z @ np.linalg.solve(self.schur, by_z.T)
        return np.asarray(np.diag(np.sum(rows**2, axis=1)) - explained)

    def step(
        self, slope: FloatArray, z: FloatArray, free: BoolArray, longest: float, limits: FloatArray
    ) -> tuple[FloatArray, FloatArray]:  # fmt: skip
        """Return the step of the states and of the unknowns, of which some are free, each by `longest` at most.

        `limits`, shape (2, n_z): an unknown that is at one of them and would pass it stays there, and the others have
        the step for that.
        """
        whole, change_z = self.slope(slope), np.zeros(len(z))
        while True:
            change_z[free] = -cho_solve(cho_factor(self.schur[free][:, free]), whole[free])
            beyond = (z <= limits[0]) & (change_z < 0.0) | (z >= limits[1]) & (change_z > 0.0)
            if not beyond.any():
                break
            free, change_z = free & ~beyond, np.zeros(len(z))
        change_z *= min(1.0, longest / max(float(np.abs(change_z).max()), 1e-12))
        change_z = np.clip(z + change_z, *limits) - z
        return (self.slopes @ change_z).reshape(-1, self.n), change_z


def posterior_of(grid: Grid, factor: Factor) -> Posterior:
    """Return the linearized posterior of a factored problem."""
    covariance = np.asarray(np.linalg.inv(factor.schur), dtype=np.float64)
    pairs = _pair_covariances(factor.band, grid, factor.n)
    return Posterior(covariance, pairs, factor.slopes, factor.ends)


def _pair_covariances(band: FloatArray, grid: Grid, n: int) -> FloatArray:
    """Return the covariances of neighboring nodes from the banded Cholesky factor (Takahashi's recursion by blocks)."""
    size = grid.n_nodes
    diagonal, below = np.zeros((2, size, n, n))
    for i in range(n):
        for j in range(n):
            if i >= j:
                diagonal[:, i, j] = band[i - j, j::n]
            if n + i - j < len(band):
                below[:, i, j] = band[n + i - j, j::n]  # row of the next node, column of this one
    inverse = np.linalg.inv(diagonal)
    local = np.matmul(inverse.transpose(0, 2, 1), inverse)
    gain = np.matmul(below, inverse)  # L21 L11^-1
    node, cross = np.empty((size, n, n)), np.zeros((size, n, n))
    node[-1] = local[-1]
    for k in range(size - 2, -1, -1):
        cross[k] = -node[k + 1] @ gain[k]
        node[k] = local[k] - gain[k].T @ cross[k]
    left = grid.left
    return np.block([[node[left], cross[left].transpose(0, 2, 1)], [cross[left], node[left + 1]]])
