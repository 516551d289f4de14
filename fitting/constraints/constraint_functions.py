"""Conditions at their points, as IPOPT wants them: values and a sparse Jacobian by the free coefficients.

A quantity of the book, or how it grows with load, is differentiated once, by CasADi, by every coefficient that it
depends on; a solve then evaluates it at its points and picks what is free.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.model import Model
from tirefmu.tires.printed import casadi_module

from ..problem.weighted_residuals import Problem
from .physical import TOLERANCE, Constraint

FloatArray = npt.NDArray[np.float64]
#: At how many random points beside the present one it is looked whether a free coefficient moves a quantity.
PROBES = 3


class ConstraintFunctions:
    """Conditions on the free coefficients of a problem, each divided by its usual size.

    A quantity that no free coefficient reaches cannot be constrained and is left out.

    Parameters
    ----------
    problem : Problem
    constraints : sequence of (Constraint, ndarray of shape (n_inputs, n_points))
        Conditions and the points at which they hold.

    Attributes
    ----------
    low, high : ndarray, shape (n_conditions,)
        Bounds of `values`.
    sparsity : casadi.Sparsity
        Of `jacobian`, shape (n_conditions, n_free).
    """

    def __init__(self, problem: Problem, constraints: Sequence[tuple[Constraint, FloatArray]]) -> None:
        self._problem = problem
        self._latest: tuple[FloatArray, FloatArray, FloatArray] | None = None
        self._each: Any = None
        blocks = [_Block(problem, constraint, points) for constraint, points in constraints if points.shape[1]]
        blocks = [block for block in blocks if block.free.size]
        sizes = [block.points.shape[1] for block in blocks]
        self.low, self.high = (_joined(np.full(n, b.bounds[i]) for b, n in zip(blocks, sizes, strict=True))
                               for i in (0, 1))  # fmt: skip
        firsts = np.cumsum([0, *sizes])
        row = _joined((np.repeat(first + np.arange(n), block.free.size)
                       for block, n, first in zip(blocks, sizes, firsts, strict=False)), int)  # fmt: skip
        column = _joined((np.tile(block.free, n) for block, n in zip(blocks, sizes, strict=True)), int)
        order = np.lexsort((row, column))  # CasADi keeps nonzeros column by column
        shape = len(self.low), len(problem.free)
        self.sparsity = ca.Sparsity.triplet(*shape, row[order].tolist(), column[order].tolist())
        starts = np.cumsum([0, *(block.width * n for block, n in zip(blocks, sizes, strict=True))])
        #: Of all derivatives: which are by a free coefficient, in CasADi's order, and what they count.
        self._picked = _joined((first + block.entries for block, first in zip(blocks, starts, strict=False)), int)[
            order
        ]
        self._factors = _joined(np.tile(block.reach, n) for block, n in zip(blocks, sizes, strict=True))[order]
        self._blocks = blocks
        self._divisors = _joined(np.full(n, block.size) for block, n in zip(blocks, sizes, strict=True))
        self._function = _all_of(blocks, len(problem.tire.book.parameters)) if blocks else None

    def __len__(self) -> int:
        return len(self.low)

    def values(self, x: FloatArray) -> FloatArray:
        """Return the conditioned quantities at scaled free values x."""
        return self._at(x)[0]

    def values_of_each(self, population: FloatArray) -> FloatArray:
        """Return the conditioned quantities at many points at once.

        Parameters
        ----------
        population : ndarray, shape (n, n_free)

        Returns
        -------
        ndarray, shape (n, n_conditions)
        """
        if not len(self) or not len(population):
            return np.zeros((len(population), len(self)))
        if self._each is None:
            self._each = self._written_out()
        return np.array(self._each.map(len(population))(population.T)).T

    def _written_out(self) -> Any:
        """Return all quantities at all their points as one function of the free values, without derivatives."""
        x = ca.SX.sym("x", len(self._problem.free))
        parameters = ca.SX(self._problem.parameters(np.zeros(len(self._problem.free))))
        for i, column in enumerate(self._problem.columns):
            parameters[int(column)] = x[i] * self._problem.reach[i]
        values = [value for block in self._blocks for value in block.written_out(parameters)]
        return ca.Function("conditions", [x], [ca.vertcat(*values)])

    def jacobian(self, x: FloatArray) -> Any:
        """Return their derivatives by x as a sparse casadi.DM."""
        return ca.DM(self.sparsity, self._at(x)[1])

    def _at(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return values and the entries of the Jacobian; kept for the point at which a solver asks again."""
        if self._function is None:
            return np.zeros(0), np.zeros(0)
        if self._latest is None or not np.array_equal(self._latest[0], x):
            values, gradients = self._function(self._problem.parameters(x))
            entries = np.array(gradients).ravel()[self._picked] * self._factors
            self._latest = x.copy(), np.array(values).ravel() / self._divisors, entries
        return self._latest[1:]

    def slopes(self, x: FloatArray) -> FloatArray:
        """Return the whole `jacobian`, shape (n_conditions, n_free)."""
        return np.array(self.jacobian(x)).reshape(len(self), len(x))

    def satisfied(self, values: FloatArray) -> bool:
        """Return whether such values are within the bounds; NaN is not."""
        return bool(np.all(values >= self.low - TOLERANCE) and np.all(values <= self.high + TOLERANCE))


class _Block:
    """One condition at its points.

    Attributes
    ----------
    points : ndarray, shape (n_inputs, n_points)
    size : float
        What the quantity is divided by.
    bounds : tuple of (float, float)
        Of the quantity over its size.
    function : casadi.Function
        The quantity and its nonzero derivatives by parameters, `width` of them, at one point.
    free : ndarray of int, shape (n_reached,)
        The free coefficients that reach it.
    reach : ndarray, shape (n_reached,)
        What a derivative counts in the solver's scale.
    entries : ndarray of int, shape (n_points * n_reached,)
        Place of each derivative by a free coefficient among all of them, point by point.
    """

    def __init__(self, problem: Problem, constraint: Constraint, points: FloatArray) -> None:
        self._value, self.function, reached = _functions(problem.tire.book, constraint.quantity, constraint.measure)
        self.points, self.size, self.bounds = points, constraint.size, constraint.scaled_bounds
        index = {int(column): i for i, column in enumerate(problem.columns)}
        self.width = len(reached)
        influential = self._influential(problem) if self.width else np.zeros(0, dtype=np.bool_)
        picked = [(i, index[column]) for i, column in enumerate(reached) if column in index and influential[i]]
        self.free = np.array([free for _, free in picked], dtype=int)
        self.reach = problem.reach[self.free] / self.size
        within = np.array([i for i, _ in picked], dtype=int)
        self.entries = np.add.outer(self.width * np.arange(points.shape[1]), within).ravel()

    def _influential(self, problem: Problem) -> npt.NDArray[np.bool_]:
        """Tell which derivatives are not 0 wherever one looks.

        Where PDX2 is fixed at 0, nothing that is free makes friction fall with load: rows of zeros, which an
        interior-point method cannot keep off a bound, are left out.
        """
        random, n = np.random.default_rng(0), self.points.shape[1]
        present = np.array([problem.tire.values[name] for name in problem.free]) / problem.scale
        influential = np.zeros(self.width, dtype=np.bool_)
        for _ in range(PROBES):
            nearby = problem.parameters(present + random.uniform(-0.3, 0.3, len(present)))
            gradients = self.function.map(n)(self.points, np.repeat(nearby[:, None], n, axis=1))[1]
            influential |= np.any(np.array(gradients).reshape(self.width, n) != 0.0, axis=1)
        return influential

    def written_out(self, parameters: Any) -> list[Any]:
        """Return the value at each point as an expression of the parameters."""
        return [self._value(point, parameters) / self.size for point in self.points.T]


def _all_of(blocks: Sequence[_Block], n_parameters: int) -> Any:
    """Return one function of the parameters: the values of all blocks, and all their derivatives point by point."""
    parameters = ca.MX.sym("parameters", n_parameters)
    values, gradients = [], []
    for block in blocks:
        n = block.points.shape[1]
        value, gradient = block.function.map(n)(block.points, ca.repmat(parameters, 1, n))
        values.append(ca.vec(value))
        gradients.append(ca.vec(gradient))
    return ca.Function("imposed", [parameters], [ca.vertcat(*values), ca.vertcat(*gradients)])


def _joined(arrays: Iterable[npt.NDArray[Any]], kind: type = float) -> npt.NDArray[Any]:
    """Return arrays one after the other, also none of them."""
    return np.concatenate([np.zeros(0, dtype=kind), *arrays])


def measured_values(book: Model, constraint: Constraint, points: FloatArray, parameters: FloatArray) -> FloatArray:
    """Return what a condition bounds, at points.

    Parameters
    ----------
    book : Model
    constraint : Constraint
    points : ndarray, shape (n_inputs, n)
    parameters : ndarray, shape (n_parameters,)

    Returns
    -------
    ndarray, shape (n,)
        In the quantity's unit.
    """
    value, _, _ = _functions(book, constraint.quantity, constraint.measure)
    return np.array(value(points, parameters), dtype=float).ravel()


@lru_cache(maxsize=256)
def _functions(book: Model, quantity: str, measure: str) -> tuple[Any, Any, tuple[int, ...]]:
    """Return what is bounded, the same with its nonzero derivatives, and by which parameters these are."""
    generated = casadi_module(book)
    inputs, parameters = ca.SX.sym("inputs", len(generated.INPUTS)), ca.SX.sym("parameters", len(generated.PARAMETERS))
    value = generated.quantities(inputs, parameters)[generated.QUANTITIES.index(quantity)]
    if measure != "value":
        load = inputs[generated.INPUTS.index("Fz")]
        growth = load * ca.jacobian(value, load)
        value = growth if measure == "growth" else growth - value
    gradient = ca.jacobian(value, parameters)
    reached = tuple(int(column) for column in gradient.sparsity().get_triplet()[1])
    nonzeros = ca.vertcat(*gradient.nonzeros()) if reached else ca.SX(0, 1)
    arguments = [inputs, parameters]
    return (
        ca.Function(f"{quantity}_{measure}", arguments, [value]),
        ca.Function(f"{quantity}_{measure}_with_gradient", arguments, [value, nonzeros]),
        reached,
    )
