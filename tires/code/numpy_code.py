"""The NumPy code of a model, for a few thousand rows at a time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from ...symbolic.model import Model
from .interface import Code, plain_rows
from .modules import numpy_routine

FloatArray = npt.NDArray[np.float64]

#: Rows that NumPy computes at a time: the intermediate results stay in the processor's cache.
CHUNK = 8192


def numpy_code(model: Model) -> Code:
    """Return the NumPy code of a model."""
    return _NumpyCode(model)


class _NumpyCode(Code):
    """The NumPy module, some thousand rows at a time."""

    def jacobian_entries(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        force, coefficient = self.entries
        table = self._table("jacobian_parameters", inputs, parameters)
        chosen: FloatArray = table[force * len(self._module.COEFFICIENTS) + coefficient]
        return chosen

    def _table(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        plain = bool(plain_rows(self._model, inputs, parameters).all())
        function = numpy_routine(self._model, routine, plain=plain)
        starts = range(0, inputs.shape[1], CHUNK) or range(1)
        return np.concatenate([_chunk(function, inputs[:, i : i + CHUNK], parameters) for i in starts], axis=1)


def _chunk(function: Callable[..., Any], inputs: FloatArray, parameters: FloatArray) -> FloatArray:
    """Return the results of a printed function, shape (n_results, n)."""
    # Far outside a tire's range a line may divide by zero; the row then has NaN or infinity.
    with np.errstate(all="ignore"):
        results = function(inputs, parameters)
    values = [value for row in results for value in row] if isinstance(results[0], tuple) else results
    table = np.empty((len(values), inputs.shape[1]))
    for row, value in zip(table, values, strict=True):
        row[:] = value
    return table
