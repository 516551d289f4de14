"""The least-squares problem of the diagnosis: coefficients of a tire and linear disturbances of its recording."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ..numerics.arrays import BoolArray, FloatArray, IndexArray
from ..numerics.gauss_newton import Damping, minimize
from ..numerics.noise_model import Whitening
from ..symbolic.added import AddedEffect
from ..tires.code.interface import slices
from .signals.disturbances import Disturbances
from .signals.simulation import Simulator
from .weighted_columns import WeightedColumns, joined

#: Width of a coefficient's bounds in standard deviations of its weak prior.
RANGE_IN_DEVIATIONS = 4.0
#: Largest number of iterations of a fit. Convention: computing time. With 5 most refits of measured recordings did not
#: converge, and their names depended on single rows.
ITERATIONS = 20
#: Distance from a bound, as a share of the range, at which a coefficient is at the bound: a clipped step ends there.
AT_BOUND = 1e-6
#: Columns that are whitened at once: more take more memory, fewer more time.
WHITENED_AT_ONCE = 128
#: Damping is scaled by the curvature, as coefficients have different units. Any step that lowers the cost is accepted.
DAMPING = Damping(first=1e-3, least=1e-7, most=10.0, up=8.0, down=0.1, by_curvature=True, trusted=0.0)


@dataclass(frozen=True, eq=False)
class Solution:
    """Solution of a fit.

    - `parameters`, shape (n_parameters,): parameter vector of the generated code.
    - `disturbance`, shape (n_disturbances,): coefficients of the recording's disturbances.
    - `cost`: half the weighted sum of squares, priors included.
    - `residual`, shape (n_channels, n): measured minus simulated minus disturbances, N and N m.
    """

    parameters: FloatArray
    free: tuple[str, ...]
    disturbance: FloatArray
    cost: float
    residual: FloatArray


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """The least-squares problem: signals, weights, disturbances, and the prior of each coefficient.

    - `inverse_noise`, shape (n_channels, n): reciprocal noise standard deviation of each row; 0 for excluded rows.
    - `center`: prior means that differ from the declared default.
    - `whitening`: filter for time-correlated noise; without it, rows are independent.
    - `stop`: called after each iteration of a fit; True ends it.
    """

    simulator: Simulator
    inverse_noise: FloatArray
    disturbances: Disturbances
    center: Mapping[str, float]
    whitening: Whitening | None = None
    stop: Callable[[], bool] = lambda: False

    def over(self, simulator: Simulator) -> LeastSquares:
        """Return the problem with another simulator, for the same rows."""
        other = replace(self, simulator=simulator)
        other.__dict__["disturbance_products"] = self.disturbance_products  # they are not computed again
        return other

    def with_effect(
        self, effect: AddedEffect, solution: Solution, values: Mapping[str, float]
    ) -> tuple[LeastSquares, FloatArray]:
        """Return the problem of the model with a further effect, and parameters: of a solution, and given ones.

        Raises `EffectError` if the model cannot have the effect.
        """
        before = self.simulator
        tire = replace(before.tire, added=(*before.tire.added, effect))
        simulator = Simulator(tire, before.signals.with_inputs_of(tire))  # its states are inputs
        given = {name: solution.parameters[before.index[name]] for name in before.names} | dict(values)
        parameters = tire.parameters()
        parameters[[simulator.index[name] for name in given]] = list(given.values())
        return replace(self, simulator=simulator.driven_at(parameters)), parameters

    def without_disturbances(self, names: Collection[str]) -> LeastSquares:
        """Return the problem without some of its disturbances."""
        return replace(self, disturbances=self.disturbances.without(names))

    def knowing(self, values: Mapping[str, float]) -> LeastSquares:
        """Return the problem with known values of some of its disturbances, without those that are 0."""
        absent = [name for name, value in values.items() if value == 0.0]
        return replace(self, disturbances=self.disturbances.without(absent).known(values))

    def extended(self, names: tuple[str, ...], columns: FloatArray, deviation: FloatArray) -> LeastSquares:
        """Return the problem with additional columns among its disturbances (`Disturbances.extended`)."""
        other = replace(self, disturbances=self.disturbances.extended(names, columns, deviation))
        (first, products), added = self.disturbance_products, self.weighted_columns([columns])
        cross = first.times(added)
        whole = np.block([[products, cross], [cross.T, added.times(added)]])
        other.__dict__["disturbance_products"] = joined([first, added]), whole
        return other

    def bounds(self, free: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        """Return the lower and upper bounds of coefficients."""
        declarations = self.simulator.symbolic_model.coefficients
        lower = np.array([declarations[name].lower for name in free])
        upper = np.array([declarations[name].upper for name in free])
        factor = self._factors(free)
        return lower * factor, upper * factor

    def at_bounds(self, parameters: FloatArray, free: Sequence[str], *, neutral: bool = False) -> tuple[str, ...]:
        """Return the coefficients that are at a bound; at a neutral value, where the effect is absent, on request."""
        declarations, ends = self.simulator.symbolic_model.coefficients, np.stack(self.bounds(free))
        values = parameters[[self.simulator.index[name] for name in free]]
        absent = np.array([np.nan if (value := declarations[name].neutral) is None else value for name in free])
        close = np.isclose(values, ends, rtol=0.0, atol=AT_BOUND * np.ptp(ends, axis=0)).any(axis=0)
        chosen = close & (neutral | ~np.isclose(values, absent))
        return tuple(name for name, at in zip(free, chosen, strict=True) if at)

    def prior(self, free: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        """Return means and standard deviations of the weak priors of coefficients."""
        declarations, factors = self.simulator.symbolic_model.coefficients, self._factors(free)
        lower, upper = self.bounds(free)
        center = np.array([self.center.get(name, declarations[name].default) for name in free]) * factors
        declared = self.simulator.symbolic_model.prior_spread
        spread = np.array([declared.get(name, np.inf) for name in free]) * np.abs(factors)
        return center, np.minimum((upper - lower) / RANGE_IN_DEVIATIONS, spread)

    def _factors(self, free: Sequence[str]) -> FloatArray:
        """Return the factors from declared coefficients to parameters of the generated code.

        An absent effect rescales coefficients (`Effect.rescales`) unless a coefficient of this effect alone is free.
        """
        model, factors = self.simulator.symbolic_model, dict[str, float]()
        for name, effect in model.effects.items():
            if effect.rescales and name not in self.simulator.tire.has:
                others = (model.owned(other) for other in model.effects if other != name)
                if model.owned(name).difference(*others).isdisjoint(free):
                    factors |= dict(effect.rescales)
        return np.array([factors.get(name, 1.0) for name in free])

    def solve(
        self, start: FloatArray, free: Sequence[str], *, iterations: int = ITERATIONS, tolerance: float = 1e-5,
        above: float = 0.0,
    ) -> Solution:  # fmt: skip
        """Fit the coefficients from initial values.

        `start`, shape (n_parameters,). `tolerance`: iterations stop when the predicted reduction is below this share of
        what the cost is above a given one.
        """
        lower, upper = self.bounds(free)
        projected = Projected(self, start, free)
        first = np.clip(start[projected.indices], lower, upper)
        end = minimize(
            projected, first, lower, upper, lambda _, cost: tolerance * (cost - above), DAMPING, steps=iterations,
            stop=self.stop,
        )  # fmt: skip
        return self._solution(projected.point(end.x), free)

    def driven(self, solution: Solution) -> LeastSquares:
        """Return the problem whose states are driven by the forces of a solution."""
        return self.over(self.simulator.driven_at(solution.parameters))

    def fitted(self, start: FloatArray, free: Sequence[str]) -> tuple[LeastSquares, Solution]:
        """Return a solution of the final fits, and the problem whose states its forces drive."""
        solution = self.solve(start, free)
        after = self.driven(solution)
        return after, after.at(solution.parameters, solution.free)

    def at(self, parameters: FloatArray, free: Sequence[str]) -> Solution:
        """Return the solution at given parameters, with the best-fitting disturbances."""
        center, deviation = self.prior(free)
        values = parameters[[self.simulator.index[name] for name in free]]
        return self._solution(self._point(parameters, (values - center) / deviation), free)

    def _point(self, parameters: FloatArray, distance: FloatArray) -> _Point:
        """Return parameters, at a distance from their prior means, with the best-fitting disturbances."""
        misfit, errors = self.misfit(parameters), self.disturbances
        weighted = self.weighted(misfit)
        target = self.disturbance_products[0].along(weighted) + errors.center / errors.deviation**2
        disturbance = np.asarray(cho_solve(self._disturbance_factor, target, check_finite=False))
        power = sum(float(np.sum(part**2)) for part in (weighted, distance, errors.center / errors.deviation))
        cost = 0.5 * max(power - float(target @ disturbance), 0.0)
        return _Point(parameters, distance, misfit, weighted, disturbance, cost)

    def _solution(self, point: _Point, free: Sequence[str]) -> Solution:
        residual = point.misfit - self.disturbances.columns @ point.disturbance
        return Solution(point.parameters, tuple(free), point.disturbance, point.cost, residual)

    def holdout_gains(self, before: Solution, after: Solution) -> FloatArray:
        """Return by how much a solution is better than another one in each block of the hold-out set, (n_blocks,).

        As a share of the squared misfit on the whole set.

        `before`, `after`: channels are weighted by the misfit of `before` on the training rows.
        """
        signals = self.simulator.signals
        holdout, training = signals.present & signals.holdout, self.inverse_noise > 0.0
        powers = np.sum(before.residual**2, axis=1, where=training) / np.maximum(training.sum(axis=1), 1)
        scale = np.where(training.any(axis=1), powers, np.inf)[:, None]  # without training rows, nothing is stated
        squares = np.array([np.sum(s.residual**2 / scale, axis=0, where=holdout) for s in (before, after)])
        total = float(squares[0].sum())
        blocks = signals.block[signals.holdout]
        gains = [float(np.subtract(*squares[:, signals.block == block].sum(axis=1))) for block in np.unique(blocks)]
        return np.asarray(gains) / total if total > 0.0 else np.zeros(len(gains))

    def sizes(self, residual: FloatArray) -> FloatArray:
        """Return the root mean square of a residual over noise in each channel, shape (n_channels,); 0 without rows."""
        used = self.inverse_noise > 0.0
        squares = np.sum((self.inverse_noise * residual) ** 2, axis=1, where=used)
        return np.asarray(np.sqrt(squares / np.maximum(used.sum(axis=1), 1)))

    def misfit(self, parameters: FloatArray) -> FloatArray:
        """Return measured minus simulated forces, shape (n_channels, n)."""
        return self.simulator.signals.measured - self.simulator.forces(parameters)

    def weighted(self, rows: FloatArray) -> FloatArray:
        """Return rows divided by their noise, shape (n_channels, n) or (n_channels, n, m)."""
        over = self.inverse_noise.reshape(*self.inverse_noise.shape, *(1,) * (rows.ndim - 2)) * rows
        return self.whitening(over) if self.whitening else np.asarray(over)

    def weighted_columns(self, groups: Iterable[FloatArray]) -> WeightedColumns:
        """Return the columns of groups, each of shape (n_channels, n, k), one after another, divided by their noise.

        Groups are stored one by one, without the zeros of other channels. Many of their columns are whitened at once,
        in place: the columns of an explanation take much memory.
        """
        number, parts = 0, [(list[IndexArray](), list[FloatArray]()) for _ in self.inverse_noise]
        for columns in groups:
            for (chosen, stored), of_channel in zip(parts, columns, strict=True):
                used = np.flatnonzero(np.any(of_channel, axis=0))
                chosen.append(number + used)
                stored.append(of_channel[:, used])
            number += columns.shape[-1]
        weighted = list[tuple[IndexArray, FloatArray]]()
        for i, (chosen, stored) in enumerate(parts):
            rows = np.concatenate(stored, axis=1)
            stored.clear()
            rows *= self.inverse_noise[i][:, None]
            if self.whitening:
                for at in slices(rows.shape[1], WHITENED_AT_ONCE):
                    rows[:, at] = self.whitening(rows[None, :, at], slice(i, i + 1))[0]
            weighted.append((np.concatenate(chosen), rows))
        return WeightedColumns(number, tuple(weighted))

    @cached_property
    def disturbance_products(self) -> tuple[WeightedColumns, FloatArray]:
        """Weighted columns of the disturbances, and their cross products, shape (k, k)."""
        weighted = self.weighted_columns([self.disturbances.columns])
        return weighted, weighted.times(weighted)

    @cached_property
    def _disturbance_factor(self) -> tuple[FloatArray, bool]:
        """The Cholesky factor of the disturbances' Gauss-Newton matrix."""
        return cho_factor(self.disturbance_products[1] + np.diag(self.disturbances.deviation**-2))

    def _normal(self, point: _Point, free: Sequence[str], deviation: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return gradient and Gauss-Newton matrix in the coefficients, the disturbances eliminated."""
        jacobian = self.weighted_columns([self.simulator.jacobian(point.parameters, free)])
        cross = self.disturbance_products[0].times(jacobian)
        gradient = point.distance / deviation + cross.T @ point.disturbance - jacobian.along(point.weighted)
        matrix = jacobian.times(jacobian) + np.diag(deviation**-2.0)
        return gradient, matrix - cross.T @ cho_solve(self._disturbance_factor, cross, check_finite=False)

    def subsampled(self, rows: slice) -> LeastSquares:
        """Return the problem over some of the compared rows, which are then independent."""
        signals = self.simulator.signals
        subsample = replace(
            signals, rows=signals.rows[rows], table_rows=signals.table_rows[rows], measured=signals.measured[:, rows],
            present=signals.present[:, rows], block=signals.block[rows], holdout=signals.holdout[rows],
        )  # fmt: skip
        return replace(
            self, simulator=self.simulator.with_signals(subsample), inverse_noise=self.inverse_noise[:, rows],
            disturbances=replace(self.disturbances, columns=self.disturbances.columns[:, rows]), whitening=None,
        )  # fmt: skip


def density_gains(before: FloatArray, after: FloatArray, fitted: BoolArray, judged: BoolArray) -> FloatArray:
    """Return by how much the logarithm of the predictive density of each judged value increases, 0 for others.

    Residuals are normal with the standard deviation that they have in the fitted rows of their channel: a tire that
    fits these better is more certain, and loses more where it is wrong.

    All have the shape (n_channels, n), as the result. A channel without fitted rows states nothing.
    """
    determined = fitted.any(axis=1, keepdims=True)

    def density(residual: FloatArray) -> FloatArray:
        squares = np.where(fitted | judged, residual, 0.0) ** 2
        power = np.sum(squares, axis=1, where=fitted, keepdims=True) / np.maximum(fitted.sum(axis=1, keepdims=True), 1)
        variance = np.where(power > 0.0, power, 1e-300)
        return np.where(judged & determined, -0.5 * (np.log(variance) + squares / variance), 0.0)

    return density(after) - density(before)


@dataclass(frozen=True, eq=False)
class _Point:
    """Parameters with the best-fitting disturbances.

    - `distance`, shape (n_free,): of the free coefficients from their prior means, in standard deviations.
    - `misfit`, `weighted`, shape (n_channels, n): without disturbances, and divided by the noise.
    - `disturbance` and `cost`: as of `Solution`.
    """

    parameters: FloatArray
    distance: FloatArray
    misfit: FloatArray
    weighted: FloatArray
    disturbance: FloatArray
    cost: float


class Projected:
    """The cost as a function of the free coefficients, minimized over the disturbances (variable projection).

    - `indices`: index of each free coefficient among the parameters.
    """

    def __init__(self, problem: LeastSquares, start: FloatArray, free: Sequence[str]) -> None:
        self._problem, self._start, self._free = problem, start, free
        self.indices = [problem.simulator.index[name] for name in free]
        self._center, self._deviation = problem.prior(free)
        self._latest: tuple[FloatArray, _Point] | None = None

    def point(self, x: FloatArray) -> _Point:
        """Return the point at the free coefficients x, shape (n_free,).

        The latest one is stored, as the derivatives of an accepted step are evaluated next.
        """
        if self._latest is None or not np.array_equal(self._latest[0], x):
            parameters = self._start.copy()
            parameters[self.indices] = x
            self._latest = x.copy(), self._problem._point(parameters, (x - self._center) / self._deviation)
        return self._latest[1]

    def cost(self, x: FloatArray) -> float:
        """Return the cost at the free coefficients."""
        return self.point(x).cost

    def derivatives(self, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return cost, gradient (n_free,) and Gauss-Newton matrix (n_free, n_free)."""
        return self.cost(x), *self._problem._normal(self.point(x), self._free, self._deviation)
