"""The least-squares problem: measured rows, weights, free coefficients; cost, gradient, Gauss-Newton matrix.

All signs are adapted SAE, the convention of the bounds in declarations and recipes. Rows are gone through in blocks, so
that many of them need little memory beyond their own.

Gradient and J^T W J of each force are accumulated in the compiled kernel of the derivatives, 256 rows at a time, while
the derivatives are in the cache of the processor. The Jacobian is not written out, and one library serves every set of
free coefficients. Without a compiler `equations_by_chunks` computes the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache

import numpy as np

from ...numerics.arrays import FloatArray, IntArray
from ...symbolic.model import Model
from ...tires.code import CHUNK, Code, WeightedRows, fastest_code, forces_of_each, normal_equations
from ...tires.tire import Tire
from .loss import LOSSES, Loss
from .prior import Prior
from .rows import BLOCK, Rows
from .slope_targets import SlopeTarget, slope_jacobian, slope_residuals

#: The contribution of an output: its index, its free coefficients, gradient and Gauss-Newton matrix.
Part = tuple[int, IntArray, FloatArray, FloatArray]


@dataclass(frozen=True, eq=False)
class _Block:
    """Some rows as the kernels take them; arrays by force have the shape (n_forces, n).

    `present` are the outputs with a weight, `without` all outputs with their rows that have none.
    """

    inputs: FloatArray
    measured: FloatArray
    root: FloatArray
    group: IntArray
    segment: IntArray
    present: list[int]
    without: list[tuple[int, slice | IntArray]]


@dataclass
class Problem:
    """Weighted least squares over rows in some coefficients of a tire.

    - `tire`: contains the value of each coefficient that is not free, in adapted SAE.
    - `free`: free coefficients.
    - `weights`, shape (n_groups, n_forces): weight of a squared residual by recording and channel.
    - `scale`, shape (n_free,): size of each free coefficient: the variables of the solver are ``value / scale``.
    - `loss`: loss function of the residuals.
    - `limits`, shape (n_groups, n_forces): residual of each channel of a recording above which the loss is less than
      the square.
    - `targets`: slopes at zero slip that are residuals, too.
    - `target_weight`: weight of a squared residual of a target, in its deviations.
    - `prior`: of the scaled values.
    - `columns`, shape (n_free,): index of each free coefficient in the parameter vector of the generated code.
    - `reach`, shape (n_free,): derivative of that parameter by the scaled value.
    """

    tire: Tire
    rows: Rows
    free: tuple[str, ...]
    weights: FloatArray
    scale: FloatArray
    loss: Loss = LOSSES["squares"]
    limits: FloatArray | None = None
    targets: tuple[SlopeTarget, ...] = ()
    target_weight: float = 0.0
    prior: Prior | None = None
    columns: IntArray = field(init=False)
    reach: FloatArray = field(init=False)
    _code: Code = field(init=False)

    def __post_init__(self) -> None:
        self._code = fastest_code(self.tire.symbolic_model)
        names = list(self.tire.symbolic_model.parameters)
        factors = self.tire.rescaled
        self.columns = np.array([names.index(name) for name in self.free])
        self.reach = self.scale * np.array([factors.get(name, 1.0) for name in self.free])
        force, coefficient = self._code.entries
        index = {int(column): i for i, column in enumerate(self.columns)}
        freed = np.array([index.get(int(column), -1) for column in coefficient], dtype=int)
        #: By output: the entries of the Jacobian by free coefficients, and the indices of these coefficients.
        self._entries = [
            (chosen, freed[chosen])
            for chosen in (np.flatnonzero((force == i) & (freed >= 0)) for i in range(len(self.tire.outputs)))
        ]
        self._parameters = self.tire.parameters()
        self._applied: FloatArray | None = None  # the weights of the next attributes
        self._only: _Block | None = None  # all rows, if they are few
        self._latest: tuple[FloatArray, float, tuple[FloatArray, FloatArray] | None] | None = None

    def __reduce__(self) -> tuple[type[Problem], tuple[object, ...]]:
        """Let other processes build the problem from its arguments: compiled code cannot be sent."""
        return Problem, tuple(getattr(self, attribute.name) for attribute in fields(self) if attribute.init)

    def sampled(self, n: int) -> Problem:
        """Return a problem with up to n random rows, of about the same cost."""
        rows = self.rows.sample(n)
        return replace(self, rows=rows, weights=self.weights * (len(self.rows) / len(rows)))

    def parameters(self, x: FloatArray) -> FloatArray:
        """Return the complete parameter vector for scaled free values x."""
        parameters = self._parameters.copy()
        parameters[self.columns] = x * self.reach
        return parameters

    def cost(self, x: FloatArray) -> float:
        """Return half the weighted sum of squares, or of the loss."""
        residual = self._target_residual(self.parameters(x))
        prior = self.prior.cost(x) if self.prior else 0.0
        return self._cost_of_rows(x) + 0.5 * float(residual @ residual) + prior

    def costs(self, population: FloatArray, limits: FloatArray) -> FloatArray:
        """Return the costs of many points; the computation of a point stops when it exceeds its limit.

        `population`, shape (n_points, n_free). `limits`, shape (n_points,). Returns shape (n_points,): the cost, or a
        part of it above the limit; infinite if it is not finite.
        """
        parameters = np.repeat(self._parameters[None, :], len(population), axis=0)
        parameters[:, self.columns] = population * self.reach
        costs, remaining = np.zeros(len(population)), np.arange(len(population))
        if self.targets:
            costs += [0.5 * float(np.sum(self._target_residual(values) ** 2)) for values in parameters]
        for block, chunk in ((b, slice(i, i + CHUNK)) for b in self._blocks() for i in range(0, len(b.group), CHUNK)):
            forces = forces_of_each(self._code, block.inputs[:, chunk], parameters[remaining])
            for output in block.present:
                root = block.root[output, chunk]
                with np.errstate(over="ignore", invalid="ignore"):
                    residual = np.where(root > 0, (forces[:, output] - block.measured[output, chunk]) * root, 0.0)
                    costs[remaining] += 0.5 * np.einsum("ij,ij->i", residual, residual)
            remaining = remaining[costs[remaining] <= limits[remaining]]
            if not remaining.size:
                break
        return np.where(np.isfinite(costs), costs, np.inf)

    def derivatives(self, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return cost, gradient (n_free,) and the Gauss-Newton matrix J^T W J (n_free, n_free)."""
        n = len(self.free)
        gradient, matrix = np.zeros(n), np.zeros((n, n))
        for _, free, own_gradient, own_matrix in self.by_output(x):
            gradient[free] += own_gradient
            matrix[np.ix_(free, free)] += own_matrix
        if self.targets:
            jacobian = self.target_jacobian(x)
            gradient += jacobian.T @ self._target_residual(self.parameters(x))
            matrix += jacobian.T @ jacobian
        if self.prior:
            gradient += self.prior.gradient(x)
            matrix += self.prior.curvature
        return self.cost(x), gradient, matrix

    def target_jacobian(self, x: FloatArray) -> FloatArray:
        """Return the derivatives of the weighted residuals of the targets by x, shape (n_targets, n_free)."""
        jacobian = slope_jacobian(self.targets, self._code, self.parameters(x), self.columns)
        return jacobian * self.reach * self._target_roots[:, None]

    def _target_residual(self, parameters: FloatArray) -> FloatArray:
        """Return the weighted residuals of the targets, shape (n_targets,)."""
        return slope_residuals(self.targets, self._code, parameters) * self._target_roots

    @property
    def _target_roots(self) -> FloatArray:
        """Roots of the weights of squared residuals of the targets."""
        return np.asarray(np.sqrt(self.target_weight) / np.array([target.deviation for target in self.targets]))

    def by_output(self, x: FloatArray) -> list[Part]:
        """Return the contribution of each weighted output: its index, its free coefficients, gradient and matrix."""
        self._follow_weights()
        parameters, entries = self.parameters(x), [entries for entries, _ in self._entries]
        cost, sums = 0.0, dict[int, tuple[FloatArray, FloatArray]]()
        for block, own_cost, root, residual in self._residuals(x):
            cost += own_cost
            equations = normal_equations(self._code, WeightedRows(block.inputs, entries, root, residual), parameters)
            for output in block.present:
                if entries[output].size:
                    (gradient, matrix), earlier = equations[output], sums.get(output)
                    sums[output] = (gradient + earlier[0], matrix + earlier[1]) if earlier else (gradient, matrix)
        parts: list[Part] = []
        for output in sorted(sums):
            gradient, matrix = sums[output]
            free = self._entries[output][1]
            reach = self.reach[free]
            parts.append((output, free, gradient * reach, matrix * np.outer(reach, reach)))
        if not self._kept(x):
            self._latest = x.copy(), cost, None
        return parts

    def jacobian_chunks(
        self, x: FloatArray, size: int
    ) -> Iterator[tuple[IntArray, FloatArray, dict[int, tuple[IntArray, FloatArray]]]]:
        """Go through the rows, `size` at a time: segments, roots of weights, derivatives of each weighted output by x.

        The derivatives are by output: its free coefficients, and an array of shape (n_free_of_output, size). Roots have
        the shape (n_forces, size), and are 0 if a channel was not measured.
        """
        parameters = self.parameters(x)
        for block in self._blocks():
            used = [(output, *self._entries[output]) for output in block.present if self._entries[output][0].size]
            for chunk, entries in self._code.jacobian_chunks(block.inputs, parameters, size):
                chosen = {output: (free, entries[selected]) for output, selected, free in used}
                for free, jacobian in chosen.values():
                    jacobian *= self.reach[free, None]
                yield block.segment[chunk], block.root[:, chunk], chosen

    def residual(self, x: FloatArray) -> FloatArray:
        """Return computed minus measured of the rows, shape (n_forces, n).

        It is 0 if a channel was not measured or has no weight.
        """
        parameters, residuals = self.parameters(x), np.zeros(self.rows.measured.T.shape)
        start = 0
        for block in self._blocks():
            stop = start + len(block.group)
            residual = self._residual(block, parameters)
            for output in block.present:  # zeros that are never written need no memory
                residuals[output, start:stop] = residual[output]
            start = stop
        return residuals

    def weighted_residual(self, x: FloatArray) -> FloatArray:
        """Return the weighted residuals of all channels, shape (n_forces * n,), without the loss."""
        rows = self.rows
        return np.asarray((np.sqrt(self.weights[rows.group].T * rows.weight) * self.residual(x)).ravel())

    def weighted_jacobian(self, x: FloatArray) -> FloatArray:
        """Return their derivatives by the scaled free values, shape (n_forces * n, n_free)."""
        n = len(self.rows)
        jacobian = np.zeros((self.weights.shape[1], n, len(self.free)))
        for _, root, outputs in self.jacobian_chunks(x, n):
            for channel, (free, derivatives) in outputs.items():
                jacobian[channel][:, free] = (derivatives * root[channel]).T
        return jacobian.reshape(-1, len(self.free))

    def _cost_of_rows(self, x: FloatArray) -> float:
        self._follow_weights()
        if not self._kept(x):
            cost = sum(part for _, part, _, _ in self._residuals(x))
            if not self._kept(x):
                self._latest = x.copy(), cost, None
        assert self._latest is not None
        return self._latest[1]

    def _kept(self, x: FloatArray) -> bool:
        """Return whether the latest cost is that of x."""
        return self._latest is not None and np.array_equal(self._latest[0], x)

    def _residuals(self, x: FloatArray) -> Iterator[tuple[_Block, float, FloatArray, FloatArray]]:
        """Go through the blocks: rows, cost, roots of weights and weighted residuals; those of few rows are kept."""
        parameters = self.parameters(x)
        for block in self._blocks():
            if self._latest is not None and self._latest[2] is not None and self._kept(x):
                yield block, self._latest[1], *self._latest[2]
                continue
            cost, root, weighted = self._weighted(block, parameters)
            if block is self._only:
                self._latest = x.copy(), cost, (root, weighted)
            yield block, cost, root, weighted

    def _weighted(self, block: _Block, parameters: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return cost, roots of weights and weighted residuals of a block."""
        residual, root = self._residual(block, parameters), block.root
        if self.limits is None:
            residual *= root
            return 0.5 * float(np.vdot(residual, residual)), root, residual
        limits = self.limits[block.group].T
        over = np.abs(residual) / limits
        cost = 0.5 * float(np.sum((root * limits) ** 2 * self.loss.value(over)))
        root = root * np.sqrt(self.loss.weight(over))
        return cost, root, root * residual

    def _residual(self, block: _Block, parameters: FloatArray) -> FloatArray:
        residual = self._code.forces(block.inputs, parameters)
        residual -= block.measured
        for output, rows in block.without:
            residual[output, rows] = 0.0
        return residual

    def _follow_weights(self) -> None:
        """Forget what was computed with earlier `weights`."""
        if self._applied is not self.weights:
            self._applied, self._only, self._latest = self.weights, None, None

    def _blocks(self) -> Iterator[_Block]:
        """Go through blocks of rows; few rows are one block, which is made once."""
        self._follow_weights()
        if len(self.rows) > BLOCK:
            yield from map(self._block, self.rows.blocks())
            return
        if self._only is None:
            self._only = self._block(self.rows)
        yield self._only

    def _block(self, rows: Rows) -> _Block:
        """Return rows with the weight of each row and output from `weights`."""
        root = np.sqrt(self.weights[rows.group].T * rows.weight)
        root = np.ascontiguousarray(np.where(np.isfinite(rows.measured.T), root, 0.0))
        present = [output for output, channel in enumerate(root) if channel.any()]
        without: list[tuple[int, slice | IntArray]] = [
            (output, np.flatnonzero(channel == 0.0) if output in present else slice(None))
            for output, channel in enumerate(root)
        ]
        inputs = np.ascontiguousarray(self.tire.effective_inputs(rows.inputs))
        measured = np.ascontiguousarray(rows.measured.T)
        return _Block(inputs, measured, root, rows.group, rows.segment, present, without)


class Ridge:
    """A problem with ridge regularization towards the initial values, for directions that are not identifiable.

    `start`, shape (n_free,). `strength`: twice the cost of one unit of distance from the start.
    """

    def __init__(self, problem: Problem, start: FloatArray, strength: float) -> None:
        self.problem, self._start, self._strength = problem, start.copy(), strength

    def cost(self, x: FloatArray) -> float:
        """Return the cost at scaled free values x, shape (n_free,)."""
        away = x - self._start
        return self.problem.cost(x) + 0.5 * self._strength * float(away @ away)

    def derivatives(self, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return cost, gradient (n_free,) and Gauss-Newton matrix (n_free, n_free)."""
        _, gradient, matrix = self.problem.derivatives(x)
        gradient += self._strength * (x - self._start)
        matrix[np.diag_indices_from(matrix)] += self._strength
        return self.cost(x), gradient, matrix


@lru_cache(maxsize=16)
def coefficients_by_output(model: Model, *, plain: bool = False) -> dict[str, frozenset[str]]:
    """Return the coefficients on which each output of a model depends, or depends without turn slip."""
    names = [output.name for output in model.outputs]
    read = {name: model.structure.plain[name] if plain else model.reached([name]) for name in names}
    return {name: frozenset(read[name]) & model.coefficients.keys() for name in names}
