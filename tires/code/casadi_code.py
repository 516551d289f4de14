"""The CasADi code of a model, as a casadi.Function over columns."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.model import Model

from .interface import Code, chunks_of, jacobian_entries_of
from .modules import casadi_module

FloatArray = npt.NDArray[np.float64]


def casadi_code(book: Model) -> Code:
    """Return the CasADi code of a model."""
    return _CasadiCode(book)


class _CasadiCode:
    """The CasADi module, a casadi.Function over columns."""

    def __init__(self, book: Model) -> None:
        self._module: ModuleType = casadi_module(book)
        self.quantities_names: tuple[str, ...] = self._module.QUANTITIES
        self.entries = jacobian_entries_of(self._module)

    def forces(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._columns("forces", inputs, parameters)

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._columns("quantities", inputs, parameters)

    def drives(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._columns("drives", inputs, parameters)

    def jacobian_inputs(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._matrices("jacobian_inputs", inputs, parameters)

    def jacobian_parameters(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._matrices("jacobian_parameters", inputs, parameters)

    def jacobian_entries(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        force, coefficient = self.entries
        return self.jacobian_parameters(inputs, parameters)[:, force, coefficient].T

    def jacobian_chunks(
        self, inputs: FloatArray, parameters: FloatArray, size: int
    ) -> Iterator[tuple[slice, FloatArray]]:
        return chunks_of(self, inputs, parameters, size)

    def _matrices(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        function = self._module.function(getattr(self._module, routine))
        results = [np.array(function(column, parameters)) for column in inputs.T]
        return np.array(results).reshape(-1, *function.size_out(0))

    def _columns(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        function = self._module.function(getattr(self._module, routine))
        n = inputs.shape[1]
        if n == 0:  # CasADi maps over one column at least
            return np.empty((function.size1_out(0), 0))
        return np.array(function.map(n)(inputs, np.repeat(parameters[:, None], n, axis=1)))
