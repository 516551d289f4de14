"""The estimate over a whole drive: motion, longitudinal slips, car and factors of the tires that explain the log best.

A least-squares problem in the states of all nodes and the unknowns. Its Jacobian is exact (CasADi). The Gauss-Newton
matrix is block tridiagonal in the nodes with a border of the unknowns; its banded Cholesky factor also gives the
covariance. The deviations of the balance of forces (how much the motion requires beyond the tires) follow from the
residuals by the fixed point of MacKay, Bayesian interpolation, Neural Computation 4 (1992).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_factor, cho_solve, cho_solve_banded, cholesky_banded

from tirefmu.estimation.correlation import correlation_length

from .inputs.car import Car
from .inputs.grid import MEASURED, Grid, with_steering
from .inputs.log import Log
from .interval import BALANCE, CHUNK, Interval
from .unknowns import Unknowns

FloatArray = npt.NDArray[np.float64]

#: Deviations of the balance, per load: at the start, and the smallest one (the error of the midpoint rule).
START_DEVIATION, MIN_DEVIATION = 0.05, 1e-3
#: Longest step of an unknown, in its standard deviations.
LONGEST_STEP = 1.0
#: Largest deviation of an unknown: one that reaches it contradicts the car file.
LARGEST = 4.0
#: Residual in standard deviations beyond which it has less weight, as that of Huber.
OUTLYING = 3.0
#: Solutions for given deviations; steps of a solution; relative decrease of the cost at which it ends.
ROUNDS, MAX_STEPS, TOLERANCE = 4, 30, 1e-7


@dataclass(frozen=True)
class Linear:
    """Functions of all intervals at a point, shape (n, n_functions), and their Jacobian by left node, right node, z."""

    values: FloatArray
    jacobian: FloatArray

    def weighted(self, weights: FloatArray) -> Linear:
        """Return the functions times weights, shape (n, n_functions)."""
        return Linear(self.values * weights, self.jacobian * weights[:, :, None])

    def cost(self, z: FloatArray) -> float:
        """Return half the sum of squares, priors included."""
        return 0.5 * float(np.sum(self.values**2) + z @ z)


@dataclass(frozen=True)
class Estimate:
    """An estimate.

    - `states`, shape (n_nodes, n_states). `z`, shape (n_z,). `deviations`, shape (2,): of `BALANCE`.
    - `noise`, shape (n_measured,): factor of the standard deviation of each measured channel.
    - `residuals`, `outputs`: of the intervals at the solution.
    - `covariance`, shape (n_z, n_z). `pairs`, shape (n, 2 n_states, 2 n_states): covariance of the nodes of an interval
      for given unknowns; `slopes`, shape (n, 2 n_states, n_z): their change with the unknowns.
    - `converged`: whether the last solution ended by its tolerance.
    """

    states: FloatArray
    z: FloatArray
    deviations: FloatArray
    noise: FloatArray
    residuals: Linear
    outputs: Linear
    covariance: FloatArray
    pairs: FloatArray
    slopes: FloatArray
    converged: bool

    def variances(self, J: FloatArray) -> FloatArray:
        """Return the variances of functions with the Jacobian J, shape (n, n_functions, 2 n_states + n_z)."""
        n = self.pairs.shape[1]
        by_z = J[:, :, n:] + J[:, :, :n] @ self.slopes
        return np.asarray(
            np.einsum("kri,kij,krj->kr", J[:, :, :n], self.pairs, J[:, :, :n], optimize=True)
            + np.einsum("kri,ij,krj->kr", by_z, self.covariance, by_z, optimize=True)
        )


def estimated(
    grid: Grid, interval: Interval, unknowns: Unknowns, start: FloatArray, log: Log, car: Car
) -> tuple[Grid, Estimate]:
    """Return the grid with the estimated steering, and the estimate from initial states, shape (n_nodes, n_states)."""
    states, z = start, np.zeros(len(unknowns))
    deviations, noise = np.full(len(BALANCE), START_DEVIATION), np.ones(len(MEASURED))
    balance, weights = slice(-len(BALANCE), None), np.ones((len(grid.t), len(interval.residuals)))
    # The motion first: from a poor one the unknowns would run away.
    states, *_ = _solved(grid, interval, states, z, 10.0 * deviations, noise, weights, longest=0.0)
    for _ in range(ROUNDS):
        states, z, linear, converged = _solved(grid, interval, states, z, deviations, noise, weights)
        estimate = _with_covariance(grid, interval, states, z, deviations, noise, linear, converged)
        variance = estimate.variances(linear.jacobian[:, balance])
        determined = np.maximum(len(grid.t) - variance.sum(axis=0), 1.0)
        deviations = np.maximum(
            deviations * np.sqrt(np.sum(linear.values[:, balance] ** 2, axis=0) / determined), MIN_DEVIATION
        )
        noise = noise * _excess(linear.values[:, : len(MEASURED)])
        grid = with_steering(grid, log, car, unknowns.car_values(z))
        scaled = linear.values / weights / np.maximum(np.sqrt(np.mean(linear.values**2, axis=0)), 1e-12)
        weights = np.sqrt(np.minimum(1.0, OUTLYING / np.maximum(np.abs(scaled), OUTLYING)))
    # A residual that is correlated over time has the information of fewer independent ones.
    lengths = [correlation_length(linear.values[:, balance][:, i], grid.segment) for i in range(len(BALANCE))]
    widened = deviations * np.sqrt(lengths)
    states, z, linear, converged = _solved(grid, interval, states, z, widened, noise, weights)
    final = _with_covariance(grid, interval, states, z, widened, noise, linear, converged)
    return grid, replace(final, deviations=deviations)


def _excess(residual: FloatArray) -> FloatArray:
    """Return by how much the residuals of each channel exceed its noise, at least 1."""
    sampled = np.sum(residual != 0.0, axis=0)
    mean = np.sum(residual**2, axis=0) / np.maximum(sampled, 1)
    return np.asarray(np.where(sampled > 0, np.maximum(np.sqrt(mean), 1.0), 1.0))


def interval_data(grid: Grid, noise: FloatArray) -> FloatArray:
    """Return the data of the intervals, shape (n_data, n): means, weights, steering at both ends and its slopes."""
    known = np.isfinite(grid.means)
    weights = np.where(known, 1.0 / (np.where(known, grid.noise, 1.0) * noise[:, None]), 0.0)
    return np.concatenate([np.where(known, grid.means, 0.0), weights, grid.steer, grid.steer_slopes, grid.rims])


def evaluated(
    function: Any, grid: Grid, states: FloatArray, z: FloatArray, deviations: FloatArray, data: FloatArray
) -> Linear:
    """Return a function of `Interval` at all intervals."""
    n, m, width = len(grid.t), function.size1_out(0), 2 * states.shape[1] + len(z)
    values, jacobian = np.empty((n, m)), np.empty((n, m, width))
    constant = np.concatenate([z, deviations, grid.used])
    for first in range(0, n, CHUNK):
        rows = np.minimum(np.arange(first, first + CHUNK), n - 1)  # the last interval fills the last chunk
        ends = states[grid.left[rows]], states[grid.right[rows]]
        results = [np.empty((CHUNK, m)), np.empty((CHUNK, m * width))]
        _call(function, [*ends, data.T[rows], np.tile(constant, (CHUNK, 1))], results)
        some = slice(first, min(first + CHUNK, n))
        count = some.stop - first
        values[some] = results[0][:count]
        jacobian[some] = results[1][:count].reshape(count, width, m).transpose(0, 2, 1)
    return Linear(values, jacobian)


def _call(function: Any, arguments: list[FloatArray], results: list[FloatArray]) -> None:
    """Evaluate a CasADi function on arrays, one row a column of it, without copies into its own matrices."""
    buffer, trigger = function.buffer()
    stored = [np.ascontiguousarray(argument) for argument in arguments]
    for i, argument in enumerate(stored):
        buffer.set_arg(i, memoryview(argument.data))
    for i, result in enumerate(results):
        buffer.set_res(i, memoryview(result.data))
    trigger()


def _solved(
    grid: Grid, interval: Interval, states: FloatArray, z: FloatArray, deviations: FloatArray, noise: FloatArray,
    weights: FloatArray, longest: float = LONGEST_STEP,
) -> tuple[FloatArray, FloatArray, Linear, bool]:  # fmt: skip
    """Return states, unknowns, problem there, and whether the Gauss-Newton steps converged (Levenberg, Marquardt)."""
    data = interval_data(grid, noise)
    linear = evaluated(interval.residual_chunk, grid, states, z, deviations, data).weighted(weights)
    cost, damping = linear.cost(z), 1e-6
    for _ in range(MAX_STEPS):
        change, change_z = _step(grid, linear, states, z, damping, longest)
        tried = evaluated(interval.residual_chunk, grid, states + change, z + change_z, deviations, data).weighted(
            weights
        )
        lower = tried.cost(z + change_z)
        if np.isfinite(lower) and lower <= cost:
            gain = (cost - lower) / cost
            states, z, linear, cost = states + change, z + change_z, tried, lower
            damping = max(damping / 10, 1e-9)
            if gain < TOLERANCE:
                return states, z, linear, True
        else:
            damping = max(damping, 1e-6) * 30
            if damping > 1e6:
                break
    return states, z, linear, False


def _step(
    grid: Grid, linear: Linear, states: FloatArray, z: FloatArray, damping: float, longest: float
) -> tuple[FloatArray, FloatArray]:
    """Return the step of states and unknowns; a matrix that rounding makes indefinite is damped more."""
    while True:
        try:
            return _Factor(grid, linear, states.shape[1], damping).step(z, longest)
        except np.linalg.LinAlgError:
            damping = max(100.0 * damping, 1e-9)


class _Factor:
    """The Gauss-Newton matrix, factored: a band of the nodes and a border of the unknowns."""

    def __init__(self, grid: Grid, linear: Linear, n: int, damping: float) -> None:
        J, r = linear.jacobian, linear.values
        blocks = np.matmul(J.transpose(0, 2, 1), J)
        slopes = np.einsum("kri,kr->ki", J, r)
        self._n, self._shape = n, (grid.n_nodes, n)
        size, at = grid.n_nodes * n, np.stack([grid.left, grid.right], axis=1)
        rows = (at[:, :, None] * n + np.arange(n)).reshape(len(at), 2 * n)
        band = np.zeros((2 * n, size))
        for i in range(2 * n):
            for j in range(i + 1):
                np.add.at(band[i - j], rows[:, j], blocks[:, i, j])
        band[0] = band[0] * (1.0 + damping) + 1e-12
        self.band = cholesky_banded(band, lower=True, overwrite_ab=True, check_finite=False)
        border = np.zeros((size, J.shape[2] - 2 * n))
        np.add.at(border, rows.ravel(), blocks[:, : 2 * n, 2 * n :].reshape(-1, border.shape[1]))
        self._gradient = np.zeros(size)
        np.add.at(self._gradient, rows.ravel(), slopes[:, : 2 * n].ravel())
        self._gradient_z = slopes[:, 2 * n :].sum(axis=0)
        self._border = border
        self.solved_border = cho_solve_banded((self.band, True), border, check_finite=False)
        corner = blocks[:, 2 * n :, 2 * n :].sum(axis=0) + np.eye(border.shape[1])
        self.schur = corner - border.T @ self.solved_border
        self.damping = damping

    def step(self, z: FloatArray, longest: float) -> tuple[FloatArray, FloatArray]:
        """Return the step of the states and of the unknowns; of an unknown at most `longest`."""
        solved = cho_solve_banded((self.band, True), self._gradient, check_finite=False)
        gradient = self._gradient_z + z - self._border.T @ solved
        damped = self.schur + self.damping * np.diag(np.diag(self.schur))
        change_z = -cho_solve(cho_factor(damped), gradient)
        change_z *= min(1.0, longest / max(float(np.abs(change_z).max()), 1e-12))
        change_z = np.clip(z + change_z, -LARGEST, LARGEST) - z
        return (-solved - self.solved_border @ change_z).reshape(self._shape), change_z


def _with_covariance(
    grid: Grid, interval: Interval, states: FloatArray, z: FloatArray, deviations: FloatArray, noise: FloatArray,
    linear: Linear, converged: bool,
) -> Estimate:  # fmt: skip
    n = states.shape[1]
    factor = _Factor(grid, linear, n, 1e-9)
    covariance = np.linalg.inv(factor.schur)
    pairs = _pair_covariances(factor.band, grid, n)
    slopes = -factor.solved_border.reshape(grid.n_nodes, n, -1)
    of_pairs = np.concatenate([slopes[grid.left], slopes[grid.right]], axis=1)
    outputs = evaluated(interval.output_chunk, grid, states, z, deviations, interval_data(grid, noise))
    return Estimate(states, z, deviations, noise, linear, outputs, covariance, pairs, of_pairs, converged)


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
    own = np.matmul(inverse.transpose(0, 2, 1), inverse)
    gain = np.matmul(below, inverse)  # L21 L11^-1
    node, cross = np.empty((size, n, n)), np.zeros((size, n, n))
    node[-1] = own[-1]
    for k in range(size - 2, -1, -1):
        cross[k] = -node[k + 1] @ gain[k]
        node[k] = own[k] - gain[k].T @ cross[k]
    left = grid.left
    return np.block([[node[left], cross[left].transpose(0, 2, 1)], [cross[left], node[left + 1]]])
