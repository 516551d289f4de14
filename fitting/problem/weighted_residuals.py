"""The least-squares problem: measured rows, weights, free coefficients; cost, gradient, Gauss-Newton matrix.

All signs are adapted SAE, the convention of the bounds in declarations and recipes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.measurements.operating_conditions.held_levels import held_levels
from tirefmu.symbolic.model import Model
from tirefmu.tires.code import CHUNK, Code, WeightedRows, fastest_code, forces_of_each, normal_equations
from tirefmu.tires.tire import Tire

from .loss import LOSSES, Loss, robust_scale
from .slope_targets import SlopeTarget, slope_jacobian, slope_residuals

FloatArray = npt.NDArray[np.float64]

#: Least noise of a channel, relative to its root mean square.
LEAST_NOISE = 1e-4
#: The slip of each channel, and the weight factor of recordings that sweep it.
OWN_SLIP = {"Fx": "kappa", "Fy": "alpha", "Mz": "alpha"}
SWEPT = 1.75


@dataclass(frozen=True)
class Rows:
    """Measured rows.

    Attributes
    ----------
    inputs : ndarray, shape (n_inputs, n)
        In the model's order, SI units.
    measured : ndarray, shape (n, n_forces)
        NaN if a channel was not measured or is not fitted.
    group : ndarray of int, shape (n,)
        Number of the recording of each row.
    segment : ndarray of int, shape (n,)
        Number of the segment without gaps of each row; by default each recording is one segment.
    weight : ndarray, shape (n,)
        Weight of each row within its recording; by default 1.
    """

    inputs: FloatArray
    measured: FloatArray
    group: npt.NDArray[np.int64]
    segment: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    weight: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if len(self.segment) != len(self.group):
            object.__setattr__(self, "segment", self.group)
        if len(self.weight) != len(self.group):
            object.__setattr__(self, "weight", np.ones(len(self.group)))

    @classmethod
    def of(cls, table: pd.DataFrame, tire: Tire, channels: Sequence[str]) -> Rows:
        """Return the rows of a table; only the given channels are fitted."""
        absent = pd.Series(np.nan, table.index)
        inputs = [table.get(name, pd.Series(tire.nominal(name), table.index)) for name in tire.inputs]
        measured = [table.get(name, absent) if name in channels else absent for name in tire.outputs]
        group = table["recording"] if "recording" in table else pd.Series(0, table.index)
        segment, weight = table.get("segment", group), table.get("weight", pd.Series(1.0, table.index))
        return cls(
            np.stack([column.to_numpy(dtype=float) for column in inputs]),
            np.stack([column.to_numpy(dtype=float) for column in measured]).T,
            np.asarray(group, dtype=np.int64),
            np.asarray(segment, dtype=np.int64),
            np.asarray(weight, dtype=float),
        )

    def __len__(self) -> int:
        return len(self.measured)

    def only(self, fitted: Sequence[bool]) -> Rows:
        """Return the rows with some of their forces, and NaN instead of the others; all else is shared."""
        dropped = ~np.array(fitted, dtype=np.bool_) & ~np.isnan(self.measured).all(axis=0)
        if not dropped.any():
            return self
        measured = self.measured.copy(order="K")
        measured[:, dropped] = np.nan
        return replace(self, measured=measured)

    def sample(self, n: int, seed: int = 0) -> Rows:
        """Return n random rows, in their order; all rows if there are no more.

        Every k-th row would alias with sweeps. Rows are drawn from the recordings in the order of their size, so the
        sample does not depend on the order in which they are given.
        """
        if n >= len(self):
            return self
        groups, sizes = np.unique(self.group, return_counts=True)
        equal = np.isin(
            sizes, [size for size, times in zip(*np.unique(sizes, return_counts=True), strict=True) if times > 1]
        )
        contents = [
            self.measured[self.group == group].tobytes() if tied else b""
            for group, tied in zip(groups, equal, strict=True)
        ]
        order = sorted(range(len(groups)), key=lambda i: (sizes[i], contents[i]))
        rows = np.concatenate([np.flatnonzero(self.group == groups[i]) for i in order])
        return self.take(np.sort(np.random.default_rng(seed).choice(rows, n, replace=False)))

    def take(self, chosen: npt.NDArray[np.int64]) -> Rows:
        """Return some of the rows."""
        return Rows(
            self.inputs[:, chosen], self.measured[chosen], self.group[chosen], self.segment[chosen],
            self.weight[chosen],
        )  # fmt: skip


@dataclass
class Problem:
    """Weighted least squares over rows in some coefficients of a tire.

    Attributes
    ----------
    tire : Tire
        Contains the value of each coefficient that is not free, in adapted SAE.
    rows : Rows
    free : tuple of str
        Free coefficients.
    weights : ndarray, shape (n_groups, n_forces)
        Weight of a squared residual by recording and channel.
    scale : ndarray, shape (n_free,)
        Size of each free coefficient: the variables of the solver are ``value / scale``.
    loss : Loss
        Loss function of the residuals.
    limits : ndarray, shape (n_groups, n_forces), optional
        Residual of each channel of a recording above which the loss is less than the square.
    targets : tuple of SlopeTarget
        Slopes at zero slip that are residuals, too.
    target_weight : float
        Weight of a squared residual of a target, in its deviations.
    columns : ndarray of int, shape (n_free,)
        Index of each free coefficient in the parameter vector of the generated code.
    reach : ndarray, shape (n_free,)
        Derivative of that parameter by the scaled value.
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
    columns: npt.NDArray[np.int64] = field(init=False)
    reach: FloatArray = field(init=False)
    _code: Code = field(init=False)

    def __post_init__(self) -> None:
        self._code = fastest_code(self.tire.book)
        names = list(self.tire.book.parameters)
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
        self._inputs = np.ascontiguousarray(self.tire.effective_inputs(self.rows.inputs))
        self._parameters = self.tire.parameters()
        self._measured = np.ascontiguousarray(self.rows.measured.T)
        self._applied: FloatArray | None = None  # the weights of the next two attributes
        self._root = np.zeros_like(self._measured)
        self._present: list[int] = []  # outputs with a weight
        self._without: list[tuple[int, slice | npt.NDArray[np.int64]]] = []  # outputs, and their rows without weight
        self._latest: tuple[FloatArray, float, FloatArray, FloatArray] | None = None

    def __reduce__(self) -> tuple[type[Problem], tuple[object, ...]]:
        """Let other processes build the problem from its arguments: compiled code cannot be sent."""
        return Problem, tuple(getattr(self, each.name) for each in fields(self) if each.init)

    def parameters(self, x: FloatArray) -> FloatArray:
        """Return the complete parameter vector for scaled free values x."""
        parameters = self._parameters.copy()
        parameters[self.columns] = x * self.reach
        return parameters

    def cost(self, x: FloatArray) -> float:
        """Return half the weighted sum of squares, or of the loss."""
        residual = self._target_residual(self.parameters(x))
        return self._at(x)[0] + 0.5 * float(residual @ residual)

    def costs(self, population: FloatArray, limits: FloatArray) -> FloatArray:
        """Return the costs of many points; the computation of a point stops when it exceeds its limit.

        Parameters
        ----------
        population : ndarray, shape (n_points, n_free)
        limits : ndarray, shape (n_points,)

        Returns
        -------
        ndarray, shape (n_points,)
            The cost, or a part of it above the limit; infinite if it is not finite.
        """
        self._apply_weights()
        parameters = np.repeat(self._parameters[None, :], len(population), axis=0)
        parameters[:, self.columns] = population * self.reach
        costs, remaining = np.zeros(len(population)), np.arange(len(population))
        if self.targets:
            costs += [0.5 * float(np.sum(self._target_residual(each) ** 2)) for each in parameters]
        for start in range(0, len(self.rows), CHUNK):
            chunk = slice(start, start + CHUNK)
            forces = forces_of_each(self._code, self._inputs[:, chunk], parameters[remaining])
            for output in self._present:
                root = self._root[output, chunk]
                with np.errstate(over="ignore", invalid="ignore"):
                    residual = np.where(root > 0, (forces[:, output] - self._measured[output, chunk]) * root, 0.0)
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
        return np.asarray(np.sqrt(self.target_weight) / np.array([each.deviation for each in self.targets]))

    def by_output(self, x: FloatArray) -> list[tuple[int, npt.NDArray[np.int64], FloatArray, FloatArray]]:
        """Return the contribution of each weighted output: its index, its free coefficients, gradient and matrix."""
        _, root, residual = self._at(x)
        rows = WeightedRows(self._inputs, [entries for entries, _ in self._entries], root, residual)
        parts = []
        equations = normal_equations(self._code, rows, self.parameters(x))
        for output, ((entries, free), (gradient, matrix)) in enumerate(zip(self._entries, equations, strict=True)):
            if output in self._present and entries.size:
                reach = self.reach[free]
                parts.append((output, free, gradient * reach, matrix * np.outer(reach, reach)))
        return parts

    def jacobian_chunks(
        self, x: FloatArray, size: int
    ) -> Iterator[tuple[slice, dict[int, tuple[npt.NDArray[np.int64], FloatArray]]]]:
        """Go through the rows, `size` at a time: which they are, and the derivatives of each weighted output by x.

        The derivatives are by output: its free coefficients, and an array of shape (n_free_of_output, size).
        """
        self._apply_weights()
        used = [(output, *self._entries[output]) for output in self._present if self._entries[output][0].size]
        for chunk, entries in self._code.jacobian_chunks(self._inputs, self.parameters(x), size):
            chosen = {output: (free, entries[own]) for output, own, free in used}
            for free, jacobian in chosen.values():
                jacobian *= self.reach[free, None]
            yield chunk, chosen

    @property
    def root(self) -> FloatArray:
        """Roots of the weights of squared residuals, shape (n_forces, n); 0 if a channel was not measured."""
        self._apply_weights()
        return self._root

    def residual(self, x: FloatArray) -> FloatArray:
        """Return computed minus measured, shape (n_forces, n); 0 if a channel was not measured or has no weight."""
        self._apply_weights()
        residual = self._code.forces(self._inputs, self.parameters(x))
        residual -= self._measured
        for output, rows in self._without:
            residual[output, rows] = 0.0
        return residual

    def _at(self, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return cost, roots of weights and weighted residuals, cached for repeated calls at one point."""
        self._apply_weights()
        if self._latest is None or not np.array_equal(self._latest[0], x):
            residual, root = self.residual(x), self._root
            if self.limits is None:
                weighted = residual
                weighted *= root
                cost = 0.5 * float(np.vdot(weighted, weighted))
            else:
                limits = self.limits[self.rows.group].T
                over = np.abs(residual) / limits
                cost = 0.5 * float(np.sum((root * limits) ** 2 * self.loss.value(over)))
                root = root * np.sqrt(self.loss.weight(over))
                weighted = root * residual
            self._latest = x.copy(), cost, root, weighted
        return self._latest[1:]

    def _apply_weights(self) -> None:
        """Compute the weight of each row and output from `weights`."""
        if self._applied is self.weights:
            return
        root = np.sqrt(self.weights[self.rows.group].T * self.rows.weight)
        self._root = np.ascontiguousarray(np.where(np.isfinite(self.rows.measured.T), root, 0.0))
        self._present = [output for output, channel in enumerate(self._root) if channel.any()]
        self._without = [
            (output, np.flatnonzero(channel == 0.0) if output in self._present else slice(None))
            for output, channel in enumerate(self._root)
        ]
        self._applied, self._latest = self.weights, None


@lru_cache(maxsize=16)
def coefficients_by_output(book: Model, *, straight: bool = False) -> dict[str, frozenset[str]]:
    """Return the coefficients on which each output of a model depends, or depends without turn slip."""
    names = [output.name for output in book.outputs]
    read = {name: book.structure.straight[name] if straight else book.reached([name]) for name in names}
    return {name: frozenset(read[name]) & book.coefficients.keys() for name in names}


def equal_weights(rows: Rows) -> FloatArray:
    """Return weights for the cost of the Trento report: half the sum of 1 - R2 (uncentred) over the channels."""
    squares = np.nansum(rows.measured**2 * rows.weight[:, None], axis=0)
    groups = int(rows.group.max(initial=0)) + 1
    return np.broadcast_to(1.0 / np.where(squares > 0, squares, 1.0), (groups, rows.measured.shape[1])).copy()


def emphasis(data: pd.DataFrame, outputs: Sequence[str]) -> FloatArray:
    """Return weight factors by recording and channel: more than 1 if the slip of the channel is swept.

    If recordings are inconsistent, a sweep contains more information on a force than rows at a few held slips. So the
    cornering test determines the pure side force, and the drive and brake test its reduction by longitudinal slip.

    Parameters
    ----------
    data : pandas.DataFrame
        With the column ``recording``.
    outputs : sequence of str

    Returns
    -------
    ndarray, shape (n_recordings, n_outputs)
    """
    factors = np.ones((int(data["recording"].max()) + 1, len(outputs)))
    for number in range(len(factors)):
        table = data[data["recording"] == number]
        for column, output in enumerate(outputs):
            slip = OWN_SLIP.get(output)
            if slip in table and np.ptp(table[slip]) > 0 and not held_levels(table[slip]):
                factors[number, column] = SWEPT
    return factors


def limits_of(problem: Problem, x: FloatArray) -> FloatArray | None:
    """Return the limits of the loss from the noise of each channel of a recording at x; None for squares."""
    if not np.isfinite(problem.loss.constant):
        return None
    limits = np.ones_like(problem.weights)
    for group, channel, residual, least in _by_channel(problem, x):
        limits[group, channel] = problem.loss.constant * max(robust_scale(residual), least)
    return limits


def noise_weights(problem: Problem, x: FloatArray, factors: FloatArray | None = None) -> FloatArray:
    """Return weights by the residual variance of each channel of a recording at x.

    The noise is assumed to be at least `LEAST_NOISE` of the signal: residuals of exact data are rounding errors. For
    robust losses the variance is estimated without outliers. The factors, shape (n_groups, n_forces), multiply the
    weights.
    """
    weights, robust = np.zeros_like(problem.weights), np.isfinite(problem.loss.constant)
    weighted_rows = np.isfinite(problem.rows.measured) & (problem.weights > 0)[problem.rows.group]
    for group, channel, residual, least in _by_channel(problem, x):
        deviation = robust_scale(residual) if robust else float(np.sqrt(np.mean(residual**2)))
        weights[group, channel] = 1.0 / (max(deviation, least) ** 2 * np.sum(weighted_rows))
    return weights if factors is None else weights * factors[: len(weights)]


def _by_channel(problem: Problem, x: FloatArray) -> Iterator[tuple[int, int, FloatArray, float]]:
    """Yield recording, channel, residuals, and least noise of everything that has a weight and is not 0 everywhere.

    The rows of a stage may contain only zeros of a channel: there is no scale for its noise.
    """
    residual, measured = problem.residual(x), problem.rows.measured.T
    for group, channel in np.argwhere(problem.weights > 0):
        present = (problem.rows.group == group) & np.isfinite(measured[channel])
        least = LEAST_NOISE * float(np.sqrt(np.mean(measured[channel, present] ** 2))) if present.any() else 0.0
        if least > 0.0:
            yield int(group), int(channel), residual[channel, present], least
