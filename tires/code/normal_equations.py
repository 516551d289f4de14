"""Normal equations of weighted least squares in the coefficients of a model, force by force."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...symbolic.model import Model
from .interface import Code
from .kernel import loaded_kernel

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

#: Rows evaluated at a time: their Jacobian, 4 kB per row, fits in the processor cache.
CHUNK = 256
#: Distance of two derivatives in a panel, and rows of whole tiles, as in `symbolic/printers/normal_equations.h`.
STEP, TILE = 264, 12


@dataclass(frozen=True, eq=False)
class WeightedRows:
    """Rows of a least-squares problem.

    - `inputs`, shape (n_inputs, n): in the order of the model, SI.
    - `entries`: for each force, the derivatives to use: indices into `Code.entries`.
    - `roots`, shape (n_forces, n): roots of the weights; 0 without weight, for any residual and derivatives.
    - `residuals`, shape (n_forces, n): weighted residuals.
    """

    inputs: FloatArray
    entries: Sequence[IntArray]
    roots: FloatArray
    residuals: FloatArray

    def take(self, rows: IntArray) -> WeightedRows:
        """Return some of the rows."""
        return WeightedRows(self.inputs[:, rows], self.entries, self.roots[:, rows], self.residuals[:, rows])


#: Of each force: the gradient J^T W r, shape (n,), and J^T W J, shape (n, n), by the chosen coefficients.
Equations = list[tuple[FloatArray, FloatArray]]


def equations_by_chunks(code: Code, rows: WeightedRows, parameters: FloatArray, size: int = CHUNK) -> Equations:
    """Return the normal equations from the Jacobian of a few rows at a time.

    `parameters`, shape (n_parameters,). `size`: rows of a chunk.
    """
    gradients = [np.zeros(len(entries)) for entries in rows.entries]
    matrices = [np.zeros((len(entries), len(entries))) for entries in rows.entries]
    for chunk, jacobian in code.jacobian_chunks(rows.inputs, parameters, size):
        for force, entries in enumerate(rows.entries):
            here = np.flatnonzero(rows.roots[force, chunk])
            if len(here) and len(entries):
                weighted = jacobian[np.ix_(entries, here)] * rows.roots[force, chunk][here]
                gradients[force] += weighted @ rows.residuals[force, chunk][here]
                matrices[force] += weighted @ weighted.T
    return list(zip(gradients, matrices, strict=True))


class EquationsKernel:
    """The kernel that accumulates the normal equations while the derivatives are in the processor's cache.

    It is in the library of the derivatives, for rows without turn slip under default options.

    Raises `CompilerError` if it cannot be compiled.
    """

    def __init__(self, model: Model) -> None:
        self._call = getattr(loaded_kernel(model, "jacobian_parameters"), f"{model.name}_batch_normal_equations")
        self._call.restype = None
        self._call.argtypes = [ctypes.c_size_t, ctypes.c_size_t, *[ctypes.c_void_p] * 9]

    def __call__(self, rows: WeightedRows, parameters: FloatArray) -> tuple[Equations, BoolArray]:
        """Return the normal equations, and which rows are not in them because a derivative is not finite."""
        n, counts = rows.inputs.shape[1], [len(entries) for entries in rows.entries]
        sizes = [-(-(count + 1) // TILE) * TILE for count in counts]
        panels, undone = np.zeros(sum(sizes) * STEP), np.empty(n, dtype=np.bool_)
        matrices = np.zeros(sum(size**2 for size in sizes))
        arrays = [
            np.ascontiguousarray(rows.inputs), np.ascontiguousarray(parameters),
            np.cumsum([0, *counts], dtype=np.uintp), np.concatenate(rows.entries).astype(np.uintp),
            np.ascontiguousarray(rows.roots), np.ascontiguousarray(rows.residuals), panels, matrices, undone,
        ]  # fmt: skip
        self._call(n, n, *(array.ctypes.data for array in arrays))
        equations, start = [], 0
        for count, size in zip(counts, sizes, strict=True):
            lower = matrices[start : start + size**2].reshape(size, size)[: count + 1, : count + 1]
            matrix = np.tril(lower[:count, :count])
            equations.append((lower[count, :count].copy(), matrix + np.tril(matrix, -1).T))
            start += size**2
        return equations, undone
