"""The estimate over a whole drive: motion, longitudinal slips, car and factors of the tires that explain the log best.

A least-squares problem in the states of all nodes and the unknowns. Its Jacobian is exact (CasADi). The Gauss-Newton
matrix is block tridiagonal in the nodes with a border of the unknowns; its banded Cholesky factor also gives the
covariance. The deviations of the balance of forces (how much the motion requires beyond the tires) are those at the
fixed point of MacKay, Bayesian interpolation, Neural Computation 4 (1992). The unknowns maximize the posterior
integrated over the states: the optimum in both together would have too low a stiffness, as fits to noisy slip angles
have.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_factor, cho_solve, cho_solve_banded, cholesky_banded

from tirefmu.estimation.correlation import correlation_length

from .inputs.car import Car
from .inputs.car_entries import ENTRIES
from .inputs.grid import MEASURED, Grid, with_steering
from .inputs.log import Log
from .interval import BALANCE, CHUNK, Added, Interval, Linear
from .unknowns import Unknowns

FloatArray = npt.NDArray[np.float64]

#: Deviations of the balance, per load: at the start, and the smallest one (the error of the midpoint rule).
START_DEVIATION, MIN_DEVIATION = 0.1, 1e-3
#: Longest step of an unknown, in its standard deviations.
LONGEST_STEP = 1.0
#: Largest deviation of an unknown: one that reaches it contradicts the car file.
LARGEST = 10.0
#: Residual in standard deviations beyond which it has less weight, as that of Huber.
OUTLYING = 3.0
#: Most solutions for given deviations; steps of a solution; relative decrease of the cost at which it ends.
ROUNDS, MAX_STEPS, TOLERANCE = 12, 12, 1e-7
#: Change of the logarithm of a deviation, or of an unknown in its standard deviations, that ends the rounds; change of
#: a deviation below which the integral over the states counts; limits of such a change.
SETTLED, NEAR, LARGEST_CHANGES = 0.1, 0.7, (-2.0, 1.0)


#: Added forces from the grid, states and unknowns.
Forces = Callable[[Grid, FloatArray, FloatArray], Added]


def no_forces(grid: Grid, states: FloatArray, z: FloatArray) -> Added:
    """Return no added forces."""
    return Added(np.zeros((len(grid.t), len(BALANCE))), np.zeros((len(grid.t), len(BALANCE), 0)))


@dataclass(frozen=True)
class Estimate:
    """An estimate.

    - `states`, shape (n_nodes, n_states). `z`, shape (n_z,). `deviations`, shape (2,): of `BALANCE`.
    - `noise`, shape (n_measured,): factor of the standard deviation of each measured channel.
    - `residuals`, `outputs`: of the intervals at the solution.
    - `covariance`, shape (n_z, n_z). `pairs`, shape (n, 2 n_states, 2 n_states): covariance of the nodes of an interval
      for given unknowns; `slopes`, shape (n, 2 n_states, n_z): their change with the unknowns.
    - `weights`, shape (n, 2): by which the residuals of the balance, per static load, are multiplied.
    - `evidence`: logarithm of the probability of the log, integrated over states and unknowns (Laplace), up to a
      constant of the grid.
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
    weights: FloatArray
    evidence: float
    converged: bool

    def variances(self, J: FloatArray) -> FloatArray:
        """Return the variances of functions with the Jacobian J, shape (n, n_functions, 2 n_states + n_z)."""
        n = self.pairs.shape[1]
        by_z = J[:, :, n:] + J[:, :, :n] @ self.slopes
        return np.asarray(
            np.einsum("kri,kij,krj->kr", J[:, :, :n], self.pairs, J[:, :, :n], optimize=True)
            + np.einsum("kri,ij,krj->kr", by_z, self.covariance, by_z, optimize=True)
        )

    def information(self, grid: Grid, added: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the information of the log on the unknowns and on coefficients of added forces, and its score at 0.

        `added`, shape (n, 2, n_added): side force per static load for a coefficient of 1. Priors are not included.
        Returns matrix and vector of n_z + n_added.
        """
        J, r, n = self.residuals.jacobian, self.residuals.values, self.states.shape[1]
        factor, columns = _Factor(grid, self.residuals, n, 1e-9), -added * self.weights[:, :, None]
        balance = J[:, -len(BALANCE) :]
        at_nodes = np.zeros((grid.n_nodes, n, added.shape[2]))
        for nodes, part in ((grid.left, balance[:, :, :n]), (grid.right, balance[:, :, n : 2 * n])):
            np.add.at(at_nodes, nodes, np.einsum("kri,krj->kij", part, columns))
        border = at_nodes.reshape(grid.n_nodes * n, added.shape[2])
        solved = cho_solve_banded((factor.band, True), border, check_finite=False) if border.size else border
        cross = np.einsum("kri,krj->ij", balance[:, :, 2 * n :], columns) - factor.solved_border.T @ border
        corner = np.einsum("kri,krj->ij", columns, columns) - border.T @ solved
        slope = np.einsum("krj,kr->j", columns, r[:, -len(BALANCE) :]) - solved.T @ factor.gradient
        precision = np.linalg.inv(self.covariance)
        both = np.block([[precision - np.eye(len(self.z)), cross], [cross.T, corner]])
        # The unknowns are at their optimum; the score is that at 0, for a quadratic cost.
        return both, np.concatenate([precision @ self.z, cross.T @ self.z - slope])


def estimated(
    grid: Grid, interval: Interval, unknowns: Unknowns, start: FloatArray, log: Log, car: Car,
    forces: Forces = no_forces, near: Estimate | None = None,
) -> tuple[Grid, Estimate]:  # fmt: skip
    """Return the grid with the estimated steering, and the estimate from initial states, shape (n_nodes, n_states).

    `forces`: added to those of the tires, for a fixed motion in each round. `near`: an estimate without them, from
    which this one starts.
    """
    states, z = start, np.zeros(len(unknowns))
    deviations, noise = np.full(len(BALANCE), START_DEVIATION), np.ones(len(MEASURED))
    if near:
        states, z, deviations, noise = near.states, near.z, near.deviations, near.noise
    added = forces(grid, states, z)
    further = added.columns.shape[2]
    z = np.concatenate([z, np.zeros(further)])
    balance, weights = slice(-len(BALANCE), None), np.ones((len(grid.t), len(interval.residuals)))
    # The motion first: from a poor one the unknowns would run away.
    tilt, steps = np.zeros(len(z)), np.zeros((0, 2, len(BALANCE)))
    if not near:
        states, *_ = _solved(grid, interval, added, states, z, 10.0 * deviations, noise, weights, tilt, longest=0.0)
    for number in range(ROUNDS):
        added = forces(grid, states, z) if number else added
        states, z, linear, converged = _solved(grid, interval, added, states, z, deviations, noise, weights, tilt)
        estimate = _with_covariance(grid, interval, states, z, deviations, noise, linear, weights, converged, further)
        variance = estimate.variances(linear.jacobian[:, balance])
        determined = np.maximum(len(grid.t) - variance.sum(axis=0), 1.0)
        excess = np.log(np.sum(linear.values[:, balance] ** 2, axis=0) / determined) / 2
        steps = np.concatenate([steps, [[np.log(deviations), excess]]])
        used, deviations = deviations, np.maximum(deviations * np.exp(_secant(steps)), MIN_DEVIATION)
        change = float(np.abs(np.log(deviations / used)).max())
        slope = _volume_slope(grid, interval, unknowns, estimate, used, weights) if change < NEAR else np.zeros(len(z))
        shift = np.abs(slope - tilt) * np.sqrt(np.diag(estimate.covariance))
        if converged and max(change, shift.max()) < SETTLED:
            break
        tilt = (tilt + slope) / 2 if tilt.any() else slope
        noise = noise * _excess(linear.values[:, : len(MEASURED)])
        grid = with_steering(grid, log, car, unknowns.car_values(z))
        scaled = linear.values / weights / np.maximum(np.sqrt(np.mean(linear.values**2, axis=0)), 1e-12)
        weights = np.sqrt(np.minimum(1.0, OUTLYING / np.maximum(np.abs(scaled), OUTLYING)))
    # A residual that is correlated over time has the information of fewer independent ones.
    lengths = [correlation_length(linear.values[:, balance][:, i], grid.segment) for i in range(len(BALANCE))]
    widened = deviations * np.sqrt(lengths)
    linear = _residuals(grid, interval, added, states, z, widened, interval_data(grid, noise)).weighted(weights)
    final = _with_covariance(grid, interval, states, z, widened, noise, linear, weights, converged, further)
    return grid, replace(final, deviations=deviations, evidence=estimate.evidence)


def _residuals(
    grid: Grid, interval: Interval, added: Added, states: FloatArray, z: FloatArray, deviations: FloatArray,
    data: FloatArray,
) -> Linear:  # fmt: skip
    def of_tires(z: FloatArray) -> Linear:
        return evaluated(interval.residual_chunk, grid, states, z, deviations, data)

    return added.residuals(of_tires, z, deviations)


def _secant(steps: FloatArray) -> FloatArray:
    """Return the change of logarithms x at which f is 0, from the last pairs of x and f, shape (n, 2, n_x)."""
    (x, f), (last_x, last_f) = steps[-1], steps[-2] if len(steps) > 1 else steps[-1]
    with np.errstate(invalid="ignore", divide="ignore"):
        slope = np.nan_to_num((f - last_f) / (x - last_x), nan=-1.0)
    return np.asarray(np.clip(-f / np.clip(slope, -1.0, -0.2), *LARGEST_CHANGES))


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
    function: Any, grid: Grid, states: FloatArray, z: FloatArray, deviations: FloatArray, data: FloatArray,
    more: FloatArray | None = None,
) -> Linear:  # fmt: skip
    """Return a function of `Interval` at all intervals; `more`, shape (n, n_more): its last argument."""
    n, m, width = len(grid.t), function.size1_out(0), 2 * states.shape[1] + len(z)
    values, jacobian = np.empty((n, m)), np.empty((n, m, width))
    constant = np.concatenate([z, deviations, grid.used])
    for first in range(0, n, CHUNK):
        rows = np.minimum(np.arange(first, first + CHUNK), n - 1)  # the last interval fills the last chunk
        ends = states[grid.left[rows]], states[grid.right[rows]]
        results = [np.empty((CHUNK, m)), np.empty((CHUNK, m * width))]
        last = [] if more is None else [more[rows]]
        _call(function, [*ends, data.T[rows], np.tile(constant, (CHUNK, 1)), *last], results)
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
    grid: Grid, interval: Interval, added: Added, states: FloatArray, z: FloatArray, deviations: FloatArray,
    noise: FloatArray, weights: FloatArray, tilt: FloatArray, longest: float = LONGEST_STEP,
) -> tuple[FloatArray, FloatArray, Linear, bool]:  # fmt: skip
    """Return states, unknowns, problem there, and whether the Gauss-Newton steps converged (Levenberg, Marquardt)."""
    data = interval_data(grid, noise)
    linear = _residuals(grid, interval, added, states, z, deviations, data).weighted(weights)
    cost, damping = linear.cost(z) + float(tilt @ z), 1e-6
    for _ in range(MAX_STEPS):
        change, change_z = _step(grid, linear, states, z, tilt, damping, longest)
        ends = states + change, z + change_z
        tried = _residuals(grid, interval, added, *ends, deviations, data).weighted(weights)
        lower = tried.cost(z + change_z) + float(tilt @ (z + change_z))
        if np.isfinite(lower) and lower <= cost:
            gain = (cost - lower) / abs(cost)
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
    grid: Grid, linear: Linear, states: FloatArray, z: FloatArray, tilt: FloatArray, damping: float, longest: float
) -> tuple[FloatArray, FloatArray]:
    """Return the step of states and unknowns; a matrix that rounding makes indefinite is damped more."""
    while True:
        try:
            return _Factor(grid, linear, states.shape[1], damping).step(z + tilt, z, longest)
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
        self.gradient = np.zeros(size)
        np.add.at(self.gradient, rows.ravel(), slopes[:, : 2 * n].ravel())
        self._gradient_z = slopes[:, 2 * n :].sum(axis=0)
        self._border = border
        self.solved_border = cho_solve_banded((self.band, True), border, check_finite=False)
        corner = blocks[:, 2 * n :, 2 * n :].sum(axis=0) + np.eye(border.shape[1])
        self.schur = corner - border.T @ self.solved_border
        self.log_volume = float(np.log(self.band[0]).sum() + np.linalg.slogdet(self.schur)[1] / 2)
        self.damping = damping

    def step(self, slope: FloatArray, z: FloatArray, longest: float) -> tuple[FloatArray, FloatArray]:
        """Return the step of the states and of the unknowns; of an unknown at most `longest`."""
        solved = cho_solve_banded((self.band, True), self.gradient, check_finite=False)
        gradient = self._gradient_z + slope - self._border.T @ solved
        damped = self.schur + self.damping * np.diag(np.diag(self.schur))
        change_z = -cho_solve(cho_factor(damped), gradient)
        change_z *= min(1.0, longest / max(float(np.abs(change_z).max()), 1e-12))
        change_z = np.clip(z + change_z, -LARGEST, LARGEST) - z
        return (-solved - self.solved_border @ change_z).reshape(self._shape), change_z


def _volume_slope(
    grid: Grid, interval: Interval, unknowns: Unknowns, estimate: Estimate, deviations: FloatArray, weights: FloatArray
) -> FloatArray:
    """Return the derivatives by the unknowns of what the integral over the states adds to the cost (Laplace).

    Without it, forces that depend on estimated slip angles have too low a stiffness. Sensors and brakes shift what is
    measured and pushed, which changes no volume but that of the linearization.
    """
    n = estimate.pairs.shape[1]
    shares = (estimate.residuals.jacobian[:, :, :n] @ estimate.pairs) * weights[:, :, None]
    more = shares.transpose(0, 2, 1).reshape(len(shares), -1)
    data = interval_data(grid, estimate.noise)
    z = estimate.z[: len(unknowns)]
    slopes = evaluated(interval.volume_chunk, grid, estimate.states, z, deviations, data, more).jacobian[:, 0]
    result = np.einsum("ki,kij->j", slopes[:, :n], estimate.slopes)
    result[: len(z)] += slopes[:, n:].sum(axis=0)
    result[[i for i, name in enumerate(unknowns.car) if ENTRIES[name].section in ("sensors", "wheels")]] = 0.0
    return np.asarray(result)


def _with_covariance(
    grid: Grid, interval: Interval, states: FloatArray, z: FloatArray, deviations: FloatArray, noise: FloatArray,
    linear: Linear, weights: FloatArray, converged: bool, further: int,
) -> Estimate:  # fmt: skip
    n = states.shape[1]
    factor = _Factor(grid, linear, n, 1e-9)
    covariance = np.linalg.inv(factor.schur)
    pairs = _pair_covariances(factor.band, grid, n)
    slopes = -factor.solved_border.reshape(grid.n_nodes, n, -1)
    of_pairs = np.concatenate([slopes[grid.left], slopes[grid.right]], axis=1)
    data, known = interval_data(grid, noise), z[: len(z) - further]
    outputs = evaluated(interval.output_chunk, grid, states, known, deviations, data)
    scale = weights[:, -len(BALANCE) :] / deviations
    # The density that the balance gives the next motion depends on mass and inertia.
    nothing = np.zeros((len(grid.t), linear.values.shape[1] * 2 * n))
    density = -evaluated(interval.volume_chunk, grid, states, known, deviations, data, nothing).values.sum()
    sampled = np.isfinite(grid.means).sum(axis=1)
    evidence = density - linear.cost(z) - factor.log_volume - sampled @ np.log(noise)
    return Estimate(
        states, z, deviations, noise, linear, outputs.with_columns(further), covariance, pairs, of_pairs, scale,
        float(evidence), converged,
    )  # fmt: skip


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
