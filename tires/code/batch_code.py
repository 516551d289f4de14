"""The batch kernels of a model; the C code computes the rows that they do not cover."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from ...symbolic.model import Model
from .buffer_pool import RESULTS
from .c_code import c_code
from .interface import Code, all_plain, plain_rows, slices
from .kernel import ChosenDerivatives, Kernel
from .normal_equations import Equations, EquationsKernel, WeightedRows, equations_by_chunks

FloatArray = npt.NDArray[np.float64]
#: Number of rows whose derivatives by inputs (35 numbers a row in MF6.1) fit into the L2 cache. Not a multiple of 64:
#: the derivatives of a row would share a few cache lines, and transposing would take three times as long.
ROWS_IN_CACHE = 1016


def batch_code(model: Model) -> Code:
    """Return the batch kernels of a model.

    Raises `CompilerError` if they cannot be compiled.
    """
    return _BatchCode(model)


def forces_of_each(code: Code, inputs: FloatArray, population: FloatArray) -> FloatArray:
    """Return the forces of many tires of one model at the same rows.

    `code`: of the model, in any language. `inputs`, shape (n_inputs, n): in the order of the model, SI, signs of the
    parameters. `population`, shape (n_tires, n_parameters): they differ in coefficients, not in options. Returns shape
    (n_tires, n_forces, n): N and N m.
    """
    if isinstance(code, _BatchCode):
        return code.forces_of_each(inputs, population)
    return np.stack([code.forces(inputs, parameters) for parameters in population])


def chosen_derivatives(
    code: Code, inputs: FloatArray, parameters: FloatArray, entries: npt.NDArray[np.intp]
) -> FloatArray:
    """Return some derivatives of the forces by coefficients.

    `code`: of the model, in any language. `inputs`, shape (n_inputs, n): in the order of the model, SI, signs of the
    parameters. `parameters`, shape (n_parameters,): from `Tire.parameters`. `entries`, shape (n_chosen,): indices into
    `Code.entries`. Returns shape (n_chosen, n): those of the given entries, in SI units.
    """
    if isinstance(code, _BatchCode):
        return code.chosen_derivatives(inputs, parameters, entries)
    return code.jacobian_entries(inputs, parameters)[entries]


def normal_equations(code: Code, rows: WeightedRows, parameters: FloatArray) -> Equations:
    """Return the normal equations of weighted least squares in chosen coefficients, force by force.

    `code`: of the model, in any language. `rows`: inputs, residual weights and channels. `parameters`, shape
    (n_parameters,): from `Tire.parameters`. Returns: gradient J^T W r and matrix J^T W J of each force.
    """
    if isinstance(code, _BatchCode):
        return code.normal_equations(rows, parameters)
    return equations_by_chunks(code, rows, parameters)


class _BatchCode(Code):
    """Kernels for whole tables; what they do not cover is computed row by row in C."""

    def __init__(self, model: Model) -> None:
        super().__init__(model)
        self._kernels: dict[str, Kernel] = {}
        self._equations: EquationsKernel | None = None
        self._chosen: ChosenDerivatives | None = None
        self._kernel("forces")  # raises CompilerError here rather than at the first use

    def forces_of_each(self, inputs: FloatArray, population: FloatArray) -> FloatArray:
        plain = plain_rows(self._model, inputs, population[0])
        results, undone = self._kernel("forces").each(inputs, population)
        undone |= ~plain
        for i in np.flatnonzero(undone.any(axis=1)):
            results[i][:, undone[i]] = self._single.forces(inputs[:, undone[i]], population[i])
        return results

    def chosen_derivatives(
        self, inputs: FloatArray, parameters: FloatArray, entries: npt.NDArray[np.intp]
    ) -> FloatArray:
        if not all_plain(self._model, inputs, parameters):
            return self.jacobian_entries(inputs, parameters)[entries]
        if self._chosen is None:
            self._chosen = ChosenDerivatives(self._model)
        results, undone = self._chosen(inputs, parameters, entries)
        if undone.any():
            results[:, undone] = self._row_by_row("jacobian_parameters", inputs[:, undone], parameters)[entries]
        return results

    def normal_equations(self, rows: WeightedRows, parameters: FloatArray) -> Equations:
        if not all_plain(self._model, rows.inputs, parameters):
            return equations_by_chunks(self, rows, parameters)
        if self._equations is None:
            self._equations = EquationsKernel(self._model)
        equations, undone = self._equations(rows, parameters)
        if undone.any():
            others = equations_by_chunks(self._single, rows.take(np.flatnonzero(undone)), parameters)
            equations = [(g + h, m + o) for (g, m), (h, o) in zip(equations, others, strict=True)]
        return equations

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._single.quantities(inputs, parameters)

    def state_lines(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._single.state_lines(inputs, parameters)

    def relaxation(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._single.relaxation(inputs, parameters)

    def jacobian_inputs(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        if not all_plain(self._model, inputs, parameters):
            return super().jacobian_inputs(inputs, parameters)
        n, forces, columns = inputs.shape[1], len(self._module.FORCES), len(self._module.INPUTS)
        matrices = RESULTS.empty((n, forces * columns))
        for rows, results in self._chunks("jacobian_inputs", inputs, parameters, ROWS_IN_CACHE):
            matrices[rows] = results.T
        return matrices.reshape(n, forces, columns)

    def jacobian_parameters(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        force, coefficient = self.entries
        jacobian = np.zeros((inputs.shape[1], len(self._module.FORCES), len(self._module.COEFFICIENTS)))
        jacobian[:, force, coefficient] = self.jacobian_entries(inputs, parameters).T
        return jacobian

    def jacobian_entries(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._table("jacobian_parameters", inputs, parameters)

    def jacobian_chunks(
        self, inputs: FloatArray, parameters: FloatArray, size: int
    ) -> Iterator[tuple[slice, FloatArray]]:
        if not all_plain(self._model, inputs, parameters):
            yield from super().jacobian_chunks(inputs, parameters, size)
            return
        yield from self._chunks("jacobian_parameters", inputs, parameters, size)

    def _chunks(
        self, routine: str, inputs: FloatArray, parameters: FloatArray, size: int
    ) -> Iterator[tuple[slice, FloatArray]]:
        """Yield the results of plain rows, shape (n_results, size), each in the same memory.

        One buffer for all chunks: it stays in the processor's cache, and no new memory is allocated.
        """
        kernel = self._kernel(routine)
        buffer = np.empty(kernel.n_results * min(size, inputs.shape[1]))
        for rows in slices(inputs.shape[1], size):
            columns = inputs[:, rows]
            results = buffer[: kernel.n_results * columns.shape[1]].reshape(-1, columns.shape[1])
            _, undone = kernel(columns, parameters, into=results)
            if undone.any():
                results[:, undone] = self._row_by_row(routine, columns[:, undone], parameters)
            yield rows, results

    @property
    def _single(self) -> Code:
        return c_code(self._model)

    def _kernel(self, routine: str) -> Kernel:
        if routine not in self._kernels:
            forces, inputs = len(self._module.FORCES), len(self._module.INPUTS)
            sizes = {
                "forces": forces,
                "jacobian_inputs": forces * inputs,
                "jacobian_parameters": self.entries.shape[1],
            }
            self._kernels[routine] = Kernel(self._model, routine, sizes[routine])
        return self._kernels[routine]

    def _table(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        plain = None if all_plain(self._model, inputs, parameters) else plain_rows(self._model, inputs, parameters)
        if plain is not None and not plain.any():
            return self._row_by_row(routine, inputs, parameters)
        results, undone = self._kernel(routine)(inputs, parameters)
        if plain is not None:
            undone |= ~plain
        if np.count_nonzero(undone):
            results[:, undone] = self._row_by_row(routine, inputs[:, undone], parameters)
        return results

    def _row_by_row(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        if routine == "forces":
            return self._single.forces(inputs, parameters)
        if routine == "jacobian_inputs":
            return self._single.jacobian_inputs(inputs, parameters).reshape(inputs.shape[1], -1).T
        return self._single.jacobian_entries(inputs, parameters)
