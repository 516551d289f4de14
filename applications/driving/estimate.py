"""The estimate over a whole drive: motion, longitudinal slips, car and factors of the tires that explain the log best.

A least-squares problem in the states of all nodes and the unknowns. Its Jacobian is exact (CasADi). The Gauss-Newton
matrix is block tridiagonal in the nodes with a border of the unknowns; its banded Cholesky factor also gives the
covariance. The unknowns maximize the posterior integrated over the states: the optimum in both together would have too
low a stiffness, as fits to noisy slip angles have, or, where accelerations are not logged, no force at all. The
deviations of the sensors and of the balance of forces (how much the motion requires beyond the tires) maximize it, too;
their steps lead to the fixed point of MacKay, Bayesian interpolation, Neural Computation 4 (1992).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ...numerics.correlation import correlation_length
from ...numerics.ties import graded
from .dynamics.discrepancy import SIZED, USUAL, discrepancy_columns, size_of
from .dynamics.lagging import with_lags
from .evaluation import curved, evaluated, interval_data, values_of
from .inputs.car import Car
from .inputs.grid import Grid, with_delays
from .inputs.log import Log
from .inputs.unknowns import Unknowns
from .interval import BALANCE, MOTION, Interval
from .linear import AddedForces, Linear
from .linear_solution import LARGEST, LONGEST_STEP, Factor, posterior_of
from .motion import MotionProblem

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

#: Standard deviation of the force balance over load: first guess, lower limit (the error of the integration).
START_DEVIATION, MIN_DEVIATION = 0.02, 5e-4
#: Those with which a motion is sought that begins without side slip: first one that the sensors give.
WIDE = (0.1, START_DEVIATION)
#: Upper limit of the noise of a sensor over that of the fast changes in its log. A larger residual is not noise, but
#: for channels whose errors are slower: a motion capture or a satellite errs for longer than a sample, and so does a
#: rate that is the slope of a smoothed speed.
LARGEST_NOISE, SLOWER = 1.5, ("x", "y", "heading", "speed_rate")
#: Degrees of freedom of Student's distribution of the residuals: what a model does not resolve, the release of a brake
#: or a wheel that is about to lock, comes in bursts.
FREEDOM = 4.0
#: Most steps of the unknowns; smallest part of a step that is tried.
ROUNDS, SHORTEST = 60, 1e-2
#: Least part of a step of the unknowns that is taken after one that it reverses. Convention: computing time.
LEAST = 0.3
#: Rounds for which the slope of the volume is kept, but for steps shorter than this, and forces that are added, but for
#: longer ones.
SLOPE_ROUNDS, NEAR = 3, 1.0
#: The estimate ends at a step of an unknown in its standard deviations and of the logarithm of a deviation below the
#: first number, or at a step below 1 that gains less than the second one in the logarithm of the posterior.
SETTLED, FLAT = 0.1, 0.05
#: Intervals in a piece of a drive, number of pieces that are estimated first, and how many times as many next, up to
#: half the drive. Convention: computing time.
PIECE, PIECES, GROWTH = 100, 4, 5
#: Difference of the logarithms of the evidence below which two estimates are one optimum: near their lower limit,
#: deviations hardly change it. Convention: computing time.
SAME_OPTIMUM = 2.0
#: Added forces from the grid, states and unknowns.
Forces = Callable[[Grid, FloatArray, FloatArray], AddedForces]


def no_forces(grid: Grid, states: FloatArray, z: FloatArray) -> AddedForces:
    """Return no added forces."""
    shape = len(grid.t), len(BALANCE)
    return AddedForces(np.zeros(shape), np.zeros((*shape, 0)), np.zeros((*shape, len(MOTION))))


@dataclass(frozen=True)
class Estimate:
    """An estimate.

    - `states`, shape (n_nodes, n_states). `z`, shape (n_z,), and its `covariance`. `deviations`, shape (n_residuals,):
      those of `BALANCE` are the last ones.
    - `residuals`: of the intervals at the solution. `outputs`, shape (n, n_outputs): `OUTPUTS` there.
    - `beyond`, shape (n, 2): side force that the motion requires of each axle beyond its tires and an effect that they
      lack, per static load: what no entry of the car explains.
    - `weights`, shape (n, 2): by which the residuals of the balance, per static load, are multiplied.
    - `evidence`: logarithm of the probability of the log, integrated over states and unknowns (Laplace), up to a
      constant of the log.
    - `size`: of the discrepancy, relative to the side force that the motion requires; its coefficients are last in `z`.
    - `converged`: whether the last step was shorter than its tolerance.
    - `scatter`: what the scatter over parts of the drive added to `covariance`.
    """

    states: FloatArray
    z: FloatArray
    covariance: FloatArray
    deviations: FloatArray
    residuals: Linear
    outputs: FloatArray
    beyond: FloatArray
    weights: FloatArray
    evidence: float
    size: float
    converged: bool
    scatter: FloatArray | float = 0.0

    @property
    def unexplained(self) -> FloatArray:
        """Deviation of what the motion requires of each axle beyond its tires, per static load, shape (2,)."""
        return self.deviations[-len(BALANCE) :]

    def of_part(self, grid: Grid, rows: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the information on the unknowns of some intervals alone, and the slope of their cost."""
        part, _ = grid.part(rows)
        factor = Factor(part, self.residuals.part(rows))
        return factor.schur - np.eye(len(self.z)), factor.slope(np.zeros(len(self.z)))

    def information(self, grid: Grid, added: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the information of the log on the unknowns and on coefficients of added forces, and its score at 0.

        `added`, shape (n, 2, n_added): side force per static load for a coefficient of 1. Priors are not included.
        Returns matrix and vector of n_z + n_added. What the scatter over parts adds is not included.
        """
        residuals, balance = self.residuals, slice(-len(BALANCE), None)
        factor, columns = Factor(grid, residuals), -added * self.weights[:, :, None]
        border = factor.at_nodes(np.einsum("kri,krj->kij", residuals.by_nodes[:, balance], columns))
        solved = factor.solved(border) if border.size else border
        cross = sum(by_z.T @ columns[:, i] for i, by_z in enumerate(residuals.by_z[balance])) + factor.slopes.T @ border
        corner = np.einsum("kri,krj->ij", columns, columns) - border.T @ solved
        slope = np.einsum("krj,kr->j", columns, residuals.values[:, balance]) - solved.T @ factor.gradient
        precision = np.linalg.inv(self.covariance - self.scatter)
        both = np.block([[precision - np.eye(len(self.z)), cross], [cross.T, corner]])
        # The unknowns are at their optimum; the score is that at 0, for a quadratic cost.
        return both, np.concatenate([precision @ self.z, cross.T @ self.z - slope])

    def output_deviations(self, grid: Grid, interval: Interval, n: int) -> FloatArray:
        """Return the standard deviations of `UNCERTAIN`, shape (n_intervals, n_uncertain).

        `n`: number of the unknowns of tires and car.
        """
        given = grid, self.states, self.z[:n], interval_data(grid)
        posterior = replace(posterior_of(grid, Factor(grid, self.residuals)), covariance=self.covariance)
        return np.sqrt(np.maximum(posterior.variances(evaluated(interval.output_chunk, *given)), 0.0))


def estimated(
    grid: Grid, interval: Interval, unknowns: Unknowns, start: FloatArray, log: Log, car: Car,
    forces: Forces = no_forces, near: Estimate | None = None,
) -> tuple[Grid, Estimate]:  # fmt: skip
    """Return the grid with the estimated steering, and the estimate from initial states, shape (n_nodes, n_states).

    From two starts: where all unknowns move at once, entries of the car take what the tires differ by, and may end in
    another optimum; where the factors move alone at first, they take what the car differs by. The more probable of the
    optima is the answer. A long log is estimated in larger and larger parts first, each from the one before, and one of
    the starts is left where they end in one optimum.
    """
    given = interval, unknowns, log, car, forces
    if near:
        return _estimated(grid, start, *given, near=near)
    begins: list[tuple[FloatArray, dict[str, Any]]] = [(start, {"together": together}) for together in (False, True)]
    for rows in _samples(grid):
        some, nodes = grid.part(rows)
        parts = [_estimated(some, states[nodes], *given, **chosen)[1] for states, chosen in begins]
        if abs(parts[0].evidence - parts[-1].evidence) < SAME_OPTIMUM:
            parts = parts[:1]
        begins = [(states.copy(), {"part": part}) for (states, _), part in zip(begins, parts, strict=False)]
        for states, chosen in begins:
            states[nodes] = chosen["part"].states
    answers = [_estimated(grid, states, *given, **chosen) for states, chosen in begins]
    return max(answers, key=lambda answer: (answer[1].converged, graded(answer[1].evidence)))


def restarted(
    grid: Grid, interval: Interval, unknowns: Unknowns, start: FloatArray, log: Log, car: Car, estimate: Estimate
) -> tuple[Grid, Estimate]:
    """Return the more probable one of an estimate and what begins at its car, with the factors of the tire files.

    Factors and entries of the car may have moved far together, to an optimum beside the best one: what the other starts
    lack is a car without the factors that belong to it.
    """
    deviations = np.concatenate([estimate.deviations[: -len(BALANCE)], np.full(len(BALANCE), START_DEVIATION)])
    z = np.where(np.arange(len(unknowns)) < len(unknowns.car), estimate.z[: len(unknowns)], 0.0)
    begin = replace(estimate, z=z, deviations=deviations)
    other = _estimated(grid, start, interval, unknowns, log, car, no_forces, part=begin)
    return max([(grid, estimate), other], key=lambda answer: (answer[1].converged, graded(answer[1].evidence)))


def _estimated(
    grid: Grid, start: FloatArray, interval: Interval, unknowns: Unknowns, log: Log, car: Car, forces: Forces,
    near: Estimate | None = None, part: Estimate | None = None, together: bool = False,
) -> tuple[Grid, Estimate]:  # fmt: skip
    """Return what `estimated` does from one start: `near`, that of a `part`, or the given car and tires.

    Steps of the unknowns and of the deviations of all residuals decrease one criterion: minus the logarithm of the
    posterior, integrated over the states. The deviations wait until a step of the unknowns is not shortened: far from
    the optimum, the errors of the unknowns are none of the forces, and a long log would never leave a large deviation.

    `forces`: added to those of the tires, for a fixed motion in each round. `near`: an estimate from which this one
    starts; in its `z`, the unknowns of added forces precede those of the discrepancy, or lack (0).
    """
    n_balance, n = len(BALANCE), len(unknowns)
    z, floor = np.zeros(n), np.ones(len(interval.residuals))
    ceiling = LARGEST_NOISE * floor
    ceiling[np.isin(interval.residuals, SLOWER)] = np.inf
    ceiling[len(grid.sampled) :] = 1.0  # errors of the integration
    floor[-n_balance:], ceiling[-n_balance:] = MIN_DEVIATION, np.inf
    deviations = np.concatenate([floor[:-n_balance], np.full(n_balance, START_DEVIATION)])
    size, rest = USUAL, np.zeros(0)
    if near:
        start, deviations, size, (z, rest) = near.states, near.deviations.copy(), near.size, np.split(near.z, [n])
    elif part:
        deviations, size, z = part.deviations.copy(), part.size, part.z[:n]
        grid = _moved(grid, interval, start, log, car, unknowns.car_values(car, z))

    def acting(grid: Grid, states: FloatArray, z: FloatArray, held: AddedForces) -> AddedForces:
        beyond = values_of(interval.value_chunk, grid, states, z[:n], interval_data(grid))[:, -n_balance:]
        return held.and_columns(*discrepancy_columns(grid, states, unknowns.car_values(car, z), beyond, size))

    held = forces(grid, start, near.z if near else z)
    added = acting(grid, start, z, held)
    n_rest = added.further - held.further
    rest = rest if near else np.zeros(n_rest)
    z = np.concatenate([z, np.zeros(added.further - len(rest)), rest])
    equal = np.ones((len(grid.t), len(floor)))
    for wide in () if near else WIDE:  # what lags follows from the motion
        deviations[-n_balance:] = wide
        start = MotionProblem(grid, interval, added, z, deviations.copy(), equal).solved(start).states
        grid = _moved(grid, interval, start, log, car, unknowns.car_values(car, z))
        added = acting(grid, start, z, held)
    weights = equal
    if near:  # of the estimate that is near
        added = curved(grid, interval, added, start, z)
        weights = _weights(MotionProblem(grid, interval, added, z, deviations, equal).linear(start).values)
    at = MotionProblem(grid, interval, added, z, deviations.copy(), weights).solved(start)
    converged, arrived, length, last, resized = False, bool(near or part), 1.0, np.zeros(len(z)), 0.0
    radius = LONGEST_STEP
    limits = np.full((2, len(z)), LARGEST) * [[-1.0], [1.0]]
    limits[:, n : n + held.further] = held.limits
    longest, slope, stalled = np.inf, np.zeros(len(z)), False
    of_tires = (np.arange(len(z)) >= len(unknowns.car)) & (np.arange(len(z)) < n)
    for round_ in range(ROUNDS):
        fresh = stalled or longest < NEAR or round_ % SLOPE_ROUNDS == 0
        if fresh:  # it changes slowly
            slope = at.volume_slope()
        change, change_z = at.factor.step(z + slope, z, of_tires | arrived | together, radius, limits)
        widening = at.widening(floor, ceiling)
        arrived = arrived or bool(np.abs(change_z).max() < (1.0 - 1e-9) * LONGEST_STEP)
        widening *= arrived
        variances = np.diag(at.posterior.covariance)
        if not (variances > 0.0).all():  # forces so large that rounding hides the priors
            break
        step = change_z / np.sqrt(variances)
        longest = max(np.abs(step).max(), np.abs(widening).max(), resized)
        if longest < SETTLED:
            converged = True
            break
        length, last = _part(length, last, step), step
        share, gain = 3.0 * length, -np.inf
        while not gain > 0.0 and share > SHORTEST:
            share /= 3.0
            to = at.problem.deviations * np.exp(share * widening)
            problem = MotionProblem(grid, interval, added, z + share * change_z, to, at.problem.weights)
            try:
                tried = problem.solved(at.states + share * change)
            except np.linalg.LinAlgError:  # a motion that the model does not have
                continue
            gain = at.criterion - tried.criterion
        converged = bool(gain < FLAT * share and longest < 1.0)
        stalled = not gain > 0.0 and not fresh  # an old slope need not point downwards
        if stalled:
            continue
        if converged or not gain > 0.0:
            break
        radius = max((2.0 if share == 1.0 else share) * radius, LONGEST_STEP)
        z = z + share * change_z
        weights = _weights(tried.values / at.problem.weights)
        if longest < 1.0:  # before, errors of the unknowns would be taken for the car's
            coefficients = z[-n_rest:]
            new = size_of(size, coefficients[SIZED], variances[-n_rest:][SIZED])
            resized = abs(np.log(new / size))
            coefficients[SIZED] *= size / new
            size = new
        states, deviations = tried.states, tried.problem.deviations
        del at, tried, problem  # a long log has large arrays
        grid = _moved(grid, interval, states, log, car, unknowns.car_values(car, z))
        if longest > NEAR or round_ % SLOPE_ROUNDS == 0:
            held = forces(grid, states, z)
        added = curved(grid, interval, acting(grid, states, z, held), states, z)
        at = MotionProblem(grid, interval, added, z, deviations, weights).solved(states)
    given = at.problem, at.states, at.linear, at.evidence
    del at  # a long log has large arrays
    return grid, _estimate(*given, size, converged)


def _samples(grid: Grid) -> Iterator[IntArray]:
    """Go through larger and larger parts of a drive, in pieces that are spread over it: their intervals."""
    n, pieces = len(grid.t), PIECES
    while 2 * pieces * PIECE <= n:
        first = np.arange(pieces) * n // pieces + (n // pieces - PIECE) // 2
        yield np.asarray((first[:, None] + np.arange(PIECE)).ravel(), dtype=np.intp)
        pieces *= GROWTH


def _moved(
    grid: Grid, interval: Interval, states: FloatArray, log: Log, car: Car, entries: Mapping[str, float]
) -> Grid:
    """Return the grid with delays and lags for a motion and entries of the car."""
    return with_lags(with_delays(grid, log, car, entries), interval, states, car, entries)


def _estimate(
    problem: MotionProblem, states: FloatArray, linear: Linear, evidence: float, size: float, converged: bool
) -> Estimate:  # fmt: skip
    """Return the estimate of a problem, solved by states; this uses up the residuals there, `linear`.

    A residual that is correlated over time has the information of fewer ones.
    """
    grid, interval, z, n_balance = problem.grid, problem.interval, problem.z, len(BALANCE)
    lengths = [correlation_length(linear.values[:, i], grid.segment) for i in range(-n_balance, 0)]
    scale = np.concatenate([np.ones(len(problem.deviations) - n_balance), np.sqrt(lengths)])
    linear.weigh(np.tile(1.0 / scale, (len(grid.t), 1)))
    outputs = values_of(interval.output_chunk, grid, states, problem.added.tires(z), problem.data)
    weights = (problem.weights / problem.deviations / scale)[:, -n_balance:]
    rest = linear.values[:, -n_balance:] / weights
    beyond = rest + problem.added.columns[:, :, -len(SIZED) :] @ z[-len(SIZED) :]
    covariance = np.asarray(np.linalg.inv(Factor(grid, linear).schur), dtype=np.float64)
    return Estimate(states=states, z=z, covariance=covariance, deviations=problem.deviations, residuals=linear,
                    outputs=outputs, beyond=beyond, weights=weights, evidence=evidence, size=size,
                    converged=converged)  # fmt: skip


def _part(part: float, last: FloatArray, step: FloatArray) -> float:
    """Return the part of a step to be taken, from that of the last one.

    A step that reverses the last one shows by how much that was too long (Aitken's relaxation, as in Kuettler and Wall,
    Computational Mechanics 43, 2008): what is linearized in each round, steering, weights and curvature, would else
    make the steps alternate. A short step says little of a long one.
    """
    turn = step - last
    return min(1.0, 2.0 * part) if last @ step >= 0.0 else max(-part * float(last @ turn / (turn @ turn)), LEAST)


def _weights(residual: FloatArray) -> FloatArray:
    """Return the square roots of the weights of residuals over their deviations, shape (n, n_residuals).

    Those of the expectation-maximization of Student's distribution (Lange, Little, Taylor, JASA 84, 1989).
    """
    return np.asarray(np.sqrt((FREEDOM + 1.0) / (FREEDOM + residual**2)))
