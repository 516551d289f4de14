"""The linearized problem of a drive, solved: a band of the nodes with a border of the unknowns, and its covariances."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cho_solve_banded, cholesky_banded

from ...numerics.arrays import BoolArray, FloatArray, IndexArray
from .inputs.grid import Grid
from .interval import Linear

#: Longest step of an unknown in the standard deviations of the car file, and of the logarithm of a deviation.
LONGEST_STEP = 1.0
#: Intervals whose variances or parts of the border are computed at a time. Convention: memory.
SOME = 500
#: Largest deviation of an unknown: one that reaches it contradicts the car file.
LARGEST = 20.0


@dataclass(frozen=True)
class Posterior:
    """A linearized posterior.

    - `covariance`, shape (n_z, n_z). `pairs`, shape (n, 2 n_states, 2 n_states): covariance of the nodes of an interval
      for given unknowns.
    - `slopes`, shape (n_nodes, n_states, n_z): change of the nodes with the unknowns. `ends`, shape (n, 2): numbers of
      the nodes of an interval.
    """

    covariance: FloatArray
    pairs: FloatArray
    slopes: FloatArray
    ends: IndexArray

    def variances(self, J: FloatArray) -> FloatArray:
        """Return the variances of functions with the Jacobian J, shape (n, n_functions, 2 n_states + n_z).

        J may lack the last unknowns, on which the functions do not depend.
        """
        n, result = self.pairs.shape[1], np.empty(J.shape[:2])
        for first in range(0, len(J), SOME):  # a long log has large arrays
            rows = slice(first, first + SOME)
            of_nodes, slopes = J[rows, :, :n], self.slopes[self.ends[rows]].reshape(-1, n, len(self.covariance))
            by_z = of_nodes @ slopes
            by_z[:, :, : J.shape[2] - n] += J[rows, :, n:]
            given_z = np.sum(of_nodes @ self.pairs[rows] * of_nodes, axis=2)
            result[rows] = given_z + np.sum(by_z @ self.covariance * by_z, axis=2)
        return result


class Factor:
    """The Gauss-Newton matrix, factored: a band of the nodes and, when it is used, a border of the unknowns."""

    def __init__(self, grid: Grid, linear: Linear, n: int, damping: float) -> None:
        self.n, self._J, self._size = n, linear.jacobian, grid.n_nodes * n
        self._slopes = np.einsum("kri,kr->ki", linear.jacobian, linear.values)
        nodes = linear.jacobian[:, :, : 2 * n]
        blocks = np.matmul(nodes.transpose(0, 2, 1), nodes)
        at = np.stack([grid.left, grid.right], axis=1)
        self._rows = (at[:, :, None] * n + np.arange(n)).reshape(len(at), 2 * n)
        band = np.zeros((2 * n, self._size))
        for i in range(2 * n):
            for j in range(i + 1):
                band[i - j, self._rows[:, j]] += blocks[:, i, j]  # no node is twice at the same end of intervals
        band[0] = band[0] * (1.0 + damping) + 1e-12
        self.band = cholesky_banded(band, lower=True, overwrite_ab=True, check_finite=False)
        self.gradient = self.at_nodes(self._slopes[:, : 2 * n, None])[:, 0]
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
            sums[self._rows[some, end]] += parts[:, end]

    @cached_property
    def _border(self) -> FloatArray:
        n, J = self.n, self._J
        sums = np.zeros((self._size, J.shape[2] - 2 * n))
        for first in range(0, len(J), SOME):
            some = slice(first, first + SOME)
            self._add(sums, some, np.matmul(J[some, :, : 2 * n].transpose(0, 2, 1), J[some, :, 2 * n :]))
        return sums

    @cached_property
    def solved_border(self) -> FloatArray:
        """The change of the states with the unknowns, negative."""
        return self.solved(self._border)

    @cached_property
    def schur(self) -> FloatArray:
        """The precision of the unknowns, their prior included."""
        rows = self._J[:, :, 2 * self.n :].swapaxes(0, 1)
        inner = sum((by_z.T @ by_z for by_z in rows), np.eye(rows.shape[2]))
        return np.asarray(inner - self._border.T @ self.solved_border)

    def slope(self, more: FloatArray) -> FloatArray:
        """Return the derivatives of the cost by the unknowns, for the best states, and `more`."""
        return np.asarray(self._slopes[:, 2 * self.n :].sum(axis=0) + more - self._border.T @ self.solved_gradient)

    def unexplained(self, values: FloatArray, kinds: IndexArray) -> FloatArray:
        """Return the products of residuals of some kinds with what states and unknowns leave of others, shape (k, k).

        `values`, shape (n, n_residuals).
        """
        rows = values.T[kinds]
        parts = [residual[:, None] * self._J[:, kind] for kind, residual in zip(kinds, rows, strict=True)]
        at_nodes = self.at_nodes(np.stack([part[:, : 2 * self.n] for part in parts], axis=2))
        by_z = np.array([part[:, 2 * self.n :].sum(axis=0) for part in parts]) - at_nodes.T @ self.solved_border
        explained = at_nodes.T @ self.solved(at_nodes) + by_z @ np.linalg.solve(self.schur, by_z.T)
        return np.asarray(np.diag(np.sum(rows**2, axis=1)) - explained)

    def step(
        self, slope: FloatArray, z: FloatArray, free: BoolArray, longest: float, limits: FloatArray
    ) -> tuple[FloatArray, FloatArray]:  # fmt: skip
        """Return the step of the states and of the unknowns, of which some are free, each by `longest` at most.

        `limits`, shape (2, n_z): an unknown that is at one of them and would pass it stays there.
        """
        change_z, whole = np.zeros(len(z)), self.slope(slope)
        free = free & ~((z <= limits[0]) & (whole > 0.0)) & ~((z >= limits[1]) & (whole < 0.0))
        change_z[free] = -cho_solve(cho_factor(self.schur[free][:, free]), whole[free])
        change_z *= min(1.0, longest / max(float(np.abs(change_z).max()), 1e-12))
        change_z = np.clip(z + change_z, *limits) - z
        return (-self.solved_gradient - self.solved_border @ change_z).reshape(-1, self.n), change_z


def posterior_of(grid: Grid, factor: Factor) -> Posterior:
    """Return the linearized posterior of a factored problem."""
    covariance = np.asarray(np.linalg.inv(factor.schur), dtype=np.float64)
    slopes = -factor.solved_border.reshape(grid.n_nodes, factor.n, -1)
    ends = np.stack([grid.left, grid.right], axis=1)
    return Posterior(covariance, _pair_covariances(factor.band, grid, factor.n), slopes, ends)


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
