"""Values of the constraints at their points and the sparse Jacobian with respect to the free coefficients.

CasADi differentiates a quantity of the model, or its change with load, once with respect to all its coefficients. A
solver evaluates it at its points and selects the derivatives by free coefficients.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from ...numerics.arrays import BoolArray, FloatArray
from ...symbolic.model import Model
from ...tires.code.casadi_code import casadi_expression
from ...tires.code.modules import numpy_module
from ..problem.weighted_residuals import Problem
from .buffered_function import BufferedFunction
from .physical import TOLERANCE, Constraint

#: Number of random points near the initial values at which the influence of a coefficient is tested.
PROBES = 3


class ConstraintFunctions:
    """Constraints on the free coefficients of a problem, each divided by its typical size.

    A quantity that no free coefficient influences cannot be constrained and is omitted.

    - `low`, `high`, shape (n_constraints,): bounds of `values`.
    - `sparsity`: of `jacobian`, shape (n_constraints, n_free).

    `constraints`, shape (n_inputs, n_points): constraints, each with the points at which it is imposed.
    """

    def __init__(self, problem: Problem, constraints: Sequence[tuple[Constraint, FloatArray]]) -> None:
        self._problem = problem
        self._latest: tuple[FloatArray, FloatArray, FloatArray] | None = None
        self._valued: tuple[FloatArray, FloatArray] | None = None
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
        order = np.lexsort((row, column))  # CasADi stores nonzeros by column
        shape = len(self.low), len(problem.free)
        self._row, self._column = row[order], column[order]
        self.sparsity = ca.Sparsity.triplet(*shape, self._row.tolist(), self._column.tolist())
        starts = np.cumsum([0, *(block.width * n for block, n in zip(blocks, sizes, strict=True))])
        #: Indices of the derivatives by free coefficients, in CasADi's order, and their scale factors.
        self._picked = _joined((first + block.entries for block, first in zip(blocks, starts, strict=False)), int)[
            order
        ]
        self._factors = _joined(np.tile(block.reach, n) for block, n in zip(blocks, sizes, strict=True))[order]
        self._blocks = blocks
        self._divisors = _joined(np.full(n, block.size) for block, n in zip(blocks, sizes, strict=True))

    def __len__(self) -> int:
        return len(self.low)

    def values(self, x: FloatArray) -> FloatArray:
        """Return the constrained quantities at scaled free values x."""
        if self._latest is not None and np.array_equal(self._latest[0], x):
            return self._latest[1]
        if self._valued is None or not np.array_equal(self._valued[0], x):
            parameters = self._problem.parameters(x)
            self._valued = x.copy(), _joined(block.values(parameters) for block in self._blocks) / self._divisors
        return self._valued[1]

    def values_of_each(self, population: FloatArray) -> FloatArray:
        """Return the constrained quantities at many points at once.

        `population`, shape (n, n_free). Returns shape (n, n_constraints).
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
        return ca.Function("constraints", [x], [ca.vertcat(*values)])

    def jacobian(self, x: FloatArray) -> Any:
        """Return their derivatives by x as a sparse casadi.DM."""
        return ca.DM(self.sparsity, self.at(x)[1])

    def at(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return values, and the nonzeros of the Jacobian in the order of `sparsity`."""
        if self._latest is None or not np.array_equal(self._latest[0], x):
            parameters = self._problem.parameters(x)
            parts = [block.with_gradients(parameters) for block in self._blocks]
            entries = _joined(gradients for _, gradients in parts)[self._picked] * self._factors
            self._latest = x.copy(), _joined(values for values, _ in parts) / self._divisors, entries
        return self._latest[1:]

    def slopes(self, x: FloatArray) -> FloatArray:
        """Return the dense `jacobian`, shape (n_constraints, n_free)."""
        slopes = np.zeros((len(self), len(x)))
        slopes[self._row, self._column] = self.at(x)[1]
        return slopes

    def satisfied(self, values: FloatArray) -> bool:
        """Return whether values are within the bounds; NaN is not."""
        return bool(np.all(values >= self.low - TOLERANCE) and np.all(values <= self.high + TOLERANCE))


class _Block:
    """One constraint at its points.

    - `points`, shape (n_inputs, n_points).
    - `size`: typical size, by which the quantity is divided.
    - `bounds`: of the quantity divided by its size.
    - `value`: the quantity at one point.
    - `width`: number of its nonzero derivatives by parameters.
    - `free`, shape (n_reached,): the free coefficients that influence it.
    - `reach`, shape (n_reached,): scale factors of the derivatives.
    - `entries`, shape (n_points * n_reached,): indices of the derivatives by free coefficients among all derivatives,
      point by point.
    """

    def __init__(self, problem: Problem, constraint: Constraint, points: FloatArray) -> None:
        self.value, _, reached = _functions(problem.tire.symbolic_model, constraint.quantity, constraint.measure)
        single = _at_points(problem.tire.symbolic_model, constraint.quantity, constraint.measure, points.shape[1])
        self._values, self._with_gradients = (BufferedFunction(function) for function in single)
        for function in (self._values, self._with_gradients):
            function.arguments[0][:] = points.ravel(order="F")
        self.points, self.size, self.bounds = points, constraint.size, constraint.scaled_bounds
        index = {int(column): i for i, column in enumerate(problem.columns)}
        self.width = len(reached)
        sought = np.array([column in index for column in reached], dtype=np.bool_)
        influential = self._influential(problem, sought) if sought.any() else np.zeros(self.width, dtype=np.bool_)
        picked = [(i, index[column]) for i, column in enumerate(reached) if column in index and influential[i]]
        self.free = np.array([free for _, free in picked], dtype=int)
        self.reach = problem.reach[self.free] / self.size
        within = np.array([i for i, _ in picked], dtype=int)
        self.entries = np.add.outer(self.width * np.arange(points.shape[1]), within).ravel()

    def _influential(self, problem: Problem, sought: BoolArray) -> BoolArray:
        """Return which of the sought derivatives are nonzero at any tested point.

        If PDX2 is fixed at 0, no free coefficient changes the decrease of friction with load. Such rows of zeros are
        omitted, because an interior-point method cannot move them away from a bound.
        """
        random = np.random.default_rng(0)
        present = np.array([problem.tire.values[name] for name in problem.free]) / problem.scale
        influential = np.zeros(self.width, dtype=np.bool_)
        for _ in range(PROBES):
            nearby = problem.parameters(present + random.uniform(-0.3, 0.3, len(present)))
            gradients = self.with_gradients(nearby)[1]
            influential |= np.any(gradients.reshape(-1, self.width) != 0.0, axis=0)
            if influential[sought].all():
                break
        return influential

    def values(self, parameters: FloatArray) -> FloatArray:
        """Return the quantity at the points, until the next call."""
        self._values.arguments[1][:] = parameters
        return self._values()[0]

    def with_gradients(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the quantity at the points, and its nonzero derivatives point by point, until the next call."""
        self._with_gradients.arguments[1][:] = parameters
        values, gradients = self._with_gradients()
        return values, gradients

    def written_out(self, parameters: Any) -> list[Any]:
        """Return the value at each point as an expression of the parameters."""
        return [self.value(point, parameters) / self.size for point in self.points.T]


def _joined(arrays: Iterable[npt.NDArray[Any]], kind: type = float) -> npt.NDArray[Any]:
    """Return the concatenation of any number of arrays, also of none."""
    return np.concatenate([np.zeros(0, dtype=kind), *arrays])


def measured_values(model: Model, constraint: Constraint, points: FloatArray, parameters: FloatArray) -> FloatArray:
    """Return the values that a constraint bounds, at points.

    `points`, shape (n_inputs, n). `parameters`, shape (n_parameters,). Returns shape (n,): in the quantity's unit.
    """
    value = BufferedFunction(_at_points(model, constraint.quantity, constraint.measure, points.shape[1])[0])
    value.arguments[0][:] = points.ravel(order="F")
    value.arguments[1][:] = parameters
    return value()[0]


@lru_cache(maxsize=256)
def value_with_slopes(model: Model, quantity: str, measure: str) -> Any:
    """Return a function of inputs and parameters: the bounded value and its derivatives by the inputs."""
    inputs, parameters, value = _expression(model, quantity, measure)
    slopes = ca.densify(ca.gradient(value, inputs))
    return ca.Function(f"{quantity}_{measure}_slopes", [inputs, parameters], [value, slopes])


@lru_cache(maxsize=1024)
def _at_points(model: Model, quantity: str, measure: str, n: int) -> tuple[Any, Any]:
    """Return the bounded value, and the value with its nonzero derivatives, at n points with equal parameters."""
    value, with_gradient, _ = _functions(model, quantity, measure)
    parameters = 1  # index of the argument that all points share
    return tuple(
        function.map(f"{function.name()}_{n}", "serial", n, [parameters], []) for function in (value, with_gradient)
    )


@lru_cache(maxsize=256)
def _functions(model: Model, quantity: str, measure: str) -> tuple[Any, Any, tuple[int, ...]]:
    """Return the bounded value, the value with its nonzero derivatives, and the parameters of these derivatives."""
    inputs, parameters, value = _expression(model, quantity, measure)
    gradient = ca.jacobian(value, parameters)
    reached = tuple(int(column) for column in gradient.sparsity().get_triplet()[1])
    nonzeros = ca.vertcat(*gradient.nonzeros()) if reached else ca.SX(0, 1)
    arguments = [inputs, parameters]
    return (
        ca.Function(f"{quantity}_{measure}", arguments, [value]),
        ca.Function(f"{quantity}_{measure}_with_gradient", arguments, [value, nonzeros]),
        reached,
    )


def _expression(model: Model, quantity: str, measure: str) -> tuple[Any, Any, Any]:
    """Return symbols of inputs and parameters, and the bounded value."""
    module = numpy_module(model)
    inputs, parameters, quantities = _quantities(model)
    value = quantities[module.QUANTITIES.index(quantity)]
    if measure != "value":
        load = inputs[module.INPUTS.index("Fz")]
        growth = load * ca.jacobian(value, load)
        value = {"growth": growth, "excess": growth - value}[measure]
    return inputs, parameters, ca.densify(value)


@lru_cache(maxsize=16)
def _quantities(model: Model) -> tuple[Any, Any, Any]:
    """Return symbols of inputs and parameters, and all named quantities as expressions of them."""
    inputs, parameters = ca.SX.sym("inputs", len(model.inputs)), ca.SX.sym("parameters", len(model.parameters))
    return inputs, parameters, casadi_expression(model, "quantities", inputs, parameters)
