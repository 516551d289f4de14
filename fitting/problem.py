"""The fit as a problem: rows of measurement, weights, free coefficients; cost, gradient, Gauss-Newton matrix.

Everything in here is in adapted SAE signs, in which cards and recipes write their bounds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.symbolic.errors import TirefmuError
from tirefmu.tires.code import Code, code_for
from tirefmu.tires.tire import Tire

FloatArray = npt.NDArray[np.float64]

#: Rows evaluated at a time: their Jacobian stays in the processor's cache.
CHUNK = 4096
#: The least noise of a channel, as a share of its root mean square.
LEAST_NOISE = 1e-4


@dataclass(frozen=True)
class Rows:
    """Measured rows.

    Attributes
    ----------
    inputs : ndarray, shape (n_inputs, n)
        In the model's order, SI units.
    measured : ndarray, shape (n, n_forces)
        NaN where a channel was not measured or is not to be fitted.
    group : ndarray of int, shape (n,)
        The recording that each row comes from.
    """

    inputs: FloatArray
    measured: FloatArray
    group: npt.NDArray[np.int64]

    @classmethod
    def of(cls, table: pd.DataFrame, tire: Tire, channels: Sequence[str]) -> Rows:
        """Take the rows of a table; only the given channels are fitted."""
        absent = pd.Series(np.nan, table.index)
        inputs = [table.get(name, pd.Series(tire.nominal(name), table.index)) for name in tire.inputs]
        measured = [table.get(name, absent) if name in channels else absent for name in tire.outputs]
        group = table["recording"] if "recording" in table else pd.Series(0, table.index)
        return cls(
            np.stack([column.to_numpy(dtype=float) for column in inputs]),
            np.stack([column.to_numpy(dtype=float) for column in measured], axis=1),
            np.asarray(group, dtype=np.int64),
        )

    def __len__(self) -> int:
        return len(self.measured)

    def sample(self, n: int, seed: int = 0) -> Rows:
        """Return n random rows, in their order; all where there are no more.

        Every k-th row would alias with sweeps.
        """
        if n >= len(self):
            return self
        chosen = np.sort(np.random.default_rng(seed).choice(len(self), n, replace=False))
        return Rows(self.inputs[:, chosen], self.measured[chosen], self.group[chosen])


@dataclass
class Problem:
    """Weighted least squares over rows in some coefficients of a tire.

    Attributes
    ----------
    tire : Tire
        Holds the value of every coefficient that is not free, in adapted SAE.
    rows : Rows
    free : tuple of str
        Free coefficients.
    weights : ndarray, shape (n_groups, n_forces)
        Weight of a squared residual by recording and channel.
    scale : ndarray, shape (n_free,)
        Size of each free coefficient: the solver sees ``value / scale``.
    columns : ndarray of int, shape (n_free,)
        Place of each free coefficient in the parameter vector of the generated code.
    reach : ndarray, shape (n_free,)
        What the parameter vector changes by there, per unit of the scaled value.
    """

    tire: Tire
    rows: Rows
    free: tuple[str, ...]
    weights: FloatArray
    scale: FloatArray
    columns: npt.NDArray[np.int64] = field(init=False)
    reach: FloatArray = field(init=False)
    _code: Code = field(init=False)

    def __post_init__(self) -> None:
        self._code = fastest_code(self.tire.model)
        names = [card.name for card in self.tire.book.parameters]
        factors = self.tire.rescaled
        self.columns = np.array([names.index(name) for name in self.free])
        self.reach = self.scale * np.array([factors.get(name, 1.0) for name in self.free])
        self._parameters = self.tire.parameters()

    def parameters(self, x: FloatArray) -> FloatArray:
        """Return the whole parameter vector for scaled free values x."""
        parameters = self._parameters.copy()
        parameters[self.columns] = x * self.reach
        return parameters

    def cost(self, x: FloatArray) -> float:
        """Return half the weighted sum of squares."""
        residual, weight = self._residual(x, slice(None))
        return 0.5 * float(np.sum(weight * residual**2))

    def derivatives(self, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return cost, gradient (n_free,) and the Gauss-Newton matrix J^T W J (n_free, n_free)."""
        parameters, n = self.parameters(x), len(self.free)
        cost, gradient, matrix = 0.0, np.zeros(n), np.zeros((n, n))
        for start in range(0, len(self.rows), CHUNK):
            chunk = slice(start, start + CHUNK)
            residual, weight = self._residual(x, chunk)
            jacobian = self._code.jacobian_parameters(self.rows.inputs[:, chunk], parameters)
            root = np.sqrt(weight)
            weighted = (jacobian[:, :, self.columns] * root[:, :, None]).reshape(-1, n) * self.reach
            cost += 0.5 * float(np.sum(weight * residual**2))
            gradient += weighted.T @ (root * residual).ravel()
            matrix += weighted.T @ weighted
        return cost, gradient, matrix

    def _residual(self, x: FloatArray, chunk: slice) -> tuple[FloatArray, FloatArray]:
        """Residuals, 0 where not measured, and their weights; both of shape (n, n_forces)."""
        forces = self._code.forces(self.rows.inputs[:, chunk], self.parameters(x)).T
        measured = self.rows.measured[chunk]
        there = np.isfinite(measured)
        residual = np.where(there, forces - measured, 0.0)
        return residual, np.where(there, self.weights[self.rows.group[chunk]], 0.0)


def equal_weights(rows: Rows) -> FloatArray:
    """Return weights that make the cost half the sum of 1 - R2 (uncentred) over the channels: the report's cost."""
    squares = np.nansum(rows.measured**2, axis=0)
    groups = int(rows.group.max(initial=0)) + 1
    return np.broadcast_to(1.0 / np.where(squares > 0, squares, 1.0), (groups, rows.measured.shape[1])).copy()


def noise_weights(problem: Problem, x: FloatArray) -> FloatArray:
    """Return weights by the residual variance that each recording's channel has at x, one mean square for all.

    Residuals below a ten thousandth of the channel count as that: numbers without noise leave only rounding.
    """
    residual, weight = problem._residual(x, slice(None))
    measured = np.nan_to_num(problem.rows.measured)
    weights = np.zeros_like(problem.weights)
    for group in range(len(weights)):
        rows = problem.rows.group == group
        for channel in range(weights.shape[1]):
            there = rows & (weight[:, channel] > 0)
            if there.any():
                least = LEAST_NOISE**2 * np.mean(measured[there, channel] ** 2)
                variance = max(np.mean(residual[there, channel] ** 2), least)
                weights[group, channel] = 1.0 / (variance * np.sum(weight > 0))
    return weights


def fastest_code(model: str) -> Code:
    """Return the C code of a model, or the NumPy code on a machine without a compiler."""
    try:
        return code_for(model, "c")
    except TirefmuError:
        return code_for(model, "numpy")
