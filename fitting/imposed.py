"""Conditions at their points, as IPOPT wants them: values and a sparse Jacobian by the free coefficients.

A quantity of the book is differentiated once, by CasADi, by every coefficient that it depends on; a solve then
evaluates it at its points and picks what is free.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.model import Model
from tirefmu.tires.printed import casadi_module

from .constraints import TOLERANCE, Constraint
from .problem import Problem

FloatArray = npt.NDArray[np.float64]


class Imposed:
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
        self._each: Any = None
        self._blocks: list[_Block] = []
        low, high = [np.zeros(0)], [np.zeros(0)]
        rows, columns = [np.zeros(0, dtype=int)], [np.zeros(0, dtype=int)]
        for constraint, points in constraints:
            block = _Block(problem, constraint, points)
            n = points.shape[1]
            if not n or not block.free.size:
                continue
            first = sum(len(bounds) for bounds in low)
            rows.append(np.repeat(np.arange(first, first + n), block.free.size))
            columns.append(np.tile(block.free, n))
            lower, upper = constraint.scaled_bounds
            low.append(np.full(n, lower))
            high.append(np.full(n, upper))
            self._blocks.append(block)
        self.low, self.high = np.concatenate(low), np.concatenate(high)
        row, column = np.concatenate(rows), np.concatenate(columns)
        self._order = np.lexsort((row, column))  # CasADi keeps nonzeros column by column
        shape = len(self.low), len(problem.free)
        self.sparsity = ca.Sparsity.triplet(*shape, row[self._order].tolist(), column[self._order].tolist())

    def __len__(self) -> int:
        return len(self.low)

    def values(self, x: FloatArray) -> FloatArray:
        """Return the conditioned quantities at scaled free values x."""
        parameters = self._problem.parameters(x)
        return np.concatenate([np.zeros(0), *(block.evaluate(parameters)[0] for block in self._blocks)])

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
        parameters = self._problem.parameters(x)
        entries = np.concatenate([np.zeros(0), *(block.evaluate(parameters)[1].ravel() for block in self._blocks)])
        return ca.DM(self.sparsity, entries[self._order])

    def kept(self, values: FloatArray) -> bool:
        """Return whether such values are within the bounds; NaN is not."""
        return bool(np.all(values >= self.low - TOLERANCE) and np.all(values <= self.high + TOLERANCE))


class _Block:
    """One condition at its points."""

    def __init__(self, problem: Problem, constraint: Constraint, points: FloatArray) -> None:
        self._function, reached = _with_gradient(problem.tire.book, constraint.quantity)
        self._points, self._size = points, constraint.size
        place = {int(column): i for i, column in enumerate(problem.columns)}
        picked = [(i, place[column]) for i, column in enumerate(reached) if column in place]
        self._picked = np.array([i for i, _ in picked], dtype=int)
        self.free = np.array([free for _, free in picked], dtype=int)
        self._reach = problem.reach[self.free]
        self._mapped = self._function.map(max(points.shape[1], 1))

    def evaluate(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return values, shape (n_points,), and derivatives by the reached free values, shape (n_points, n_reached)."""
        n = self._points.shape[1]
        values, gradient = self._mapped(self._points, np.repeat(parameters[:, None], n, axis=1))
        by_point = np.array(gradient).reshape(-1, n).T
        return np.array(values).ravel() / self._size, by_point[:, self._picked] * self._reach / self._size

    def written_out(self, parameters: Any) -> list[Any]:
        """Return the value at each point as an expression of the parameters."""
        arguments = self._function.sx_in()
        value = ca.Function("value", arguments, self._function(*arguments)[:1])  # without what only derivatives need
        return [value(point, parameters) / self._size for point in self._points.T]


@lru_cache(maxsize=256)
def _with_gradient(book: Model, quantity: str) -> tuple[Any, tuple[int, ...]]:
    """Return a quantity of a model with its nonzero derivatives, and by which parameters these are."""
    generated = casadi_module(book)
    inputs, parameters = ca.SX.sym("inputs", len(generated.INPUTS)), ca.SX.sym("parameters", len(generated.PARAMETERS))
    value = generated.quantities(inputs, parameters)[generated.QUANTITIES.index(quantity)]
    gradient = ca.jacobian(value, parameters)
    reached = tuple(int(column) for column in gradient.sparsity().get_triplet()[1])
    nonzeros = ca.vertcat(*gradient.nonzeros()) if reached else ca.SX(0, 1)
    return ca.Function(f"{quantity}_with_gradient", [inputs, parameters], [value, nonzeros]), reached
