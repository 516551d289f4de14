"""The motion of a car for given unknowns: the states of all nodes that explain the log best.

It is a least-squares problem, solved by damped Gauss-Newton steps. What is integrated over the states (Laplace) makes
the criterion of the unknowns and its slopes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...numerics.arrays import FloatArray
from .evaluation import evaluated, interval_data
from .inputs.grid import Grid
from .interval import BALANCE, Interval
from .linear import AddedForces, Linear
from .linear_solution import LEAST_DAMPING, LONGEST_STEP, Factor, Posterior, posterior_of

#: Most steps, and predicted decrease of the cost that ends them: this (a tenth of what an estimate gains in its last
#: step), or a part of the largest one.
MAX_STEPS, TOLERANCE, INEXACT = 25, 5e-3, 1e-3
#: Part of a predicted decrease from which the next step is damped less (Marquardt).
RELIABLE = 0.75


@dataclass(frozen=True)
class MotionProblem:
    """What is given for a motion: unknowns, deviations and weights of the residuals, a grid, added forces."""

    grid: Grid
    interval: Interval
    added: AddedForces
    z: FloatArray
    deviations: FloatArray
    weights: FloatArray

    @cached_property
    def data(self) -> FloatArray:
        """The data of the intervals."""
        return interval_data(self.grid)

    def linear(self, states: FloatArray, *, whole: bool = False) -> Linear:
        """Return the weighted residuals and their derivatives by the nodes, and as a whole also by the unknowns."""
        function = self.interval.residual_chunk if whole else self.interval.node_chunk
        further, of_tires = self.added.further if whole else None, self.added.tires(self.z)
        linear = evaluated(function, self.grid, states, of_tires, self.data, further=further)
        self.added.act(linear.values, self.z, states[self.grid.left], states[self.grid.right])
        self.added.slant(linear, states.shape[1])
        linear.weigh(self.weights / self.deviations)
        return linear

    def solved(self, states: FloatArray) -> BestMotion:
        """Return the best states from initial ones (Gauss-Newton steps, damped as Levenberg's)."""
        n, linear, damping, tolerance = states.shape[1], self.linear(states), LEAST_DAMPING, TOLERANCE
        for _ in range(MAX_STEPS):
            try:
                factor = Factor(self.grid, linear, damping)
            except np.linalg.LinAlgError:  # rounding made the matrix indefinite
                damping = 100.0 * damping
                continue
            predicted = float(factor.gradient @ factor.solved_gradient) / 2.0
            tolerance = max(tolerance, INEXACT * predicted)
            if predicted < tolerance:
                break
            moved = states - factor.solved_gradient.reshape(states.shape)
            tried = self.linear(moved)
            gain = linear.cost(self.z) - tried.cost(self.z)
            if gain < 0.0:
                damping = max(damping, 1e-5) * 30.0
            elif gain > RELIABLE * predicted:
                damping = max(damping / 10.0, LEAST_DAMPING)
            if gain >= 0.0:
                states, linear = moved, tried
        else:
            damping = np.inf
        if damping > LEAST_DAMPING:  # of another point or damped, the determinant is not the posterior's
            factor = Factor(self.grid, linear)
        # The density of the next motion that the balance gives and those of sensors have the deviations as scales.
        slopes = np.abs(np.linalg.det(linear.by_nodes[:, -len(BALANCE) :, n + 1 : n + 3]))
        if not slopes.all():
            raise np.linalg.LinAlgError("the balance of forces does not give the next motion")
        density = np.log(slopes).sum()
        density -= np.sum((linear.values != 0.0) * np.log(self.deviations), axis=0)[: -len(BALANCE)].sum()
        criterion = linear.cost(self.z) + float(np.log(factor.band[0]).sum() - density)
        return BestMotion(self, states, linear.values, criterion)


@dataclass(frozen=True)
class BestMotion:
    """The states that explain the log best, and the weighted residuals there.

    `criterion`: minus the logarithm of the posterior, integrated over the states.
    """

    problem: MotionProblem
    states: FloatArray
    values: FloatArray
    criterion: float

    @cached_property
    def linear(self) -> Linear:
        """The residuals with all derivatives."""
        return self.problem.linear(self.states, whole=True)

    @cached_property
    def factor(self) -> Factor:
        """The factored problem."""
        return Factor(self.problem.grid, self.linear)

    @property
    def evidence(self) -> float:
        """Logarithm of the probability of the log, integrated over states and unknowns."""
        return float(-self.criterion - np.linalg.slogdet(self.factor.schur)[1] / 2)

    @cached_property
    def posterior(self) -> Posterior:
        """The linearized posterior."""
        return posterior_of(self.problem.grid, self.factor)

    def widening(self, floor: FloatArray, ceiling: FloatArray) -> FloatArray:
        """Return the steps of the logarithms of deviations, within limits: 0 at MacKay's fixed point.

        Where the motion follows the residuals, their excess over a deviation changes by a part of a step only: by the
        average information of the data on the deviations (Gilmour, Thompson, Cullis, Biometrics 51, 1995).
        """
        values, deviations = self.linear.values, self.problem.deviations
        squares = np.sum(values**2, axis=0)
        sampled = np.sum(values != 0.0, axis=0)
        determined = np.maximum(sampled - self.posterior.variances(self.linear).sum(axis=0), 1.0)
        excess = (squares - determined) / 2
        lowest, highest = np.log(floor / deviations), np.log(ceiling / deviations)
        free = np.flatnonzero((excess > 0.0) & (highest > 0.0) | (excess < 0.0) & (lowest < 0.0))
        result = np.zeros(len(excess))
        if len(free):
            result[free] = np.linalg.solve(self.factor.unexplained(values, free), excess[free])
        result *= min(1.0, LONGEST_STEP / max(float(np.abs(result).max()), 1e-12))
        return np.clip(result, lowest, highest)

    def volume_slope(self) -> FloatArray:
        """Return the derivatives by all unknowns of what the integral over the states adds to the cost (Laplace).

        Without it, forces that depend on estimated slip angles have too low a stiffness. It counts for every unknown in
        proportion to which they change: for the factors alone, these would grow, and the discrepancy would fall.
        """
        pairs, grid, added, z = self.posterior.pairs, self.problem.grid, self.problem.added, self.problem.z
        of_tires, last = added.tires(z), len(added.tires(z))
        shares = (self.linear.by_nodes @ pairs) * (self.problem.weights / self.problem.deviations)[:, :, None]
        more = shares.transpose(0, 2, 1).reshape(len(shares), -1)
        volume = evaluated(self.problem.interval.volume_chunk, grid, self.states, of_tires, self.problem.data, more)
        slopes = volume.by_all(slice(None), last + len(BALANCE))[:, 0]
        result = self.factor.at_nodes(volume.by_nodes.transpose(0, 2, 1))[:, 0] @ self.factor.slopes
        result[:last] += slopes[:, :last].sum(axis=0)
        by_relative = np.einsum("ki,kij->j", slopes[:, last:], added.relative)
        result[len(z) - len(by_relative) :] += by_relative
        return np.asarray(result)
