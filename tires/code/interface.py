"""The interface of a model's code in every language, and the common parts of the languages."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ...symbolic.model import Model
from .modules import numpy_module

FloatArray = npt.NDArray[np.float64]


class Code(ABC):
    """What a language's code offers: rows of inputs in, rows of results out.

    - `quantities_names`: names of the rows of `quantities`, in the letters of the book.
    - `entries`, shape (2, n_entries): force and coefficient of each derivative by coefficients that is not 0
      everywhere.
    """

    def __init__(self, model: Model) -> None:
        self._model, self._module = model, numpy_module(model)
        self.quantities_names: tuple[str, ...] = self._module.QUANTITIES
        column = {name: i for i, name in enumerate(self._module.COEFFICIENTS)}
        entries = [(force, column[name]) for force, reached in enumerate(self._module.REACH) for name in reached]
        self.entries: npt.NDArray[np.intp] = np.array(entries, dtype=np.intp).reshape(-1, 2).T

    def forces(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return forces, shape (n_forces, n), at inputs of shape (n_inputs, n)."""
        return self._table("forces", inputs, parameters)

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return named quantities, shape (n_quantities, n), at inputs of shape (n_inputs, n)."""
        return self._table("quantities", inputs, parameters)

    def state_lines(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return the lines of `Model.state_lines`, shape (3 n_states, n): target, rate and start of each state."""
        return self._table("state_lines", inputs, parameters)

    def relaxation(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return the relaxation lengths that act on kappa and tan(alpha), shape (2, n), of a model that has them."""
        return self._table("relaxation", inputs, parameters)

    def jacobian_inputs(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return derivatives of the forces by the inputs, shape (n, n_forces, n_inputs)."""
        return self._matrices("jacobian_inputs", inputs, parameters)

    def jacobian_parameters(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return derivatives of the forces, shape (n, n_forces, n_coefficients)."""
        return self._matrices("jacobian_parameters", inputs, parameters)

    def jacobian_entries(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return the derivatives of `entries`, shape (n_entries, n)."""
        force, coefficient = self.entries
        return self.jacobian_parameters(inputs, parameters)[:, force, coefficient].T

    def jacobian_chunks(
        self, inputs: FloatArray, parameters: FloatArray, size: int
    ) -> Iterator[tuple[slice, FloatArray]]:
        """Go through the rows, `size` at a time: which they are and the derivatives of `entries`, until the next."""
        for rows in slices(inputs.shape[1], size):
            yield rows, self.jacobian_entries(inputs[:, rows], parameters)

    @abstractmethod
    def _table(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return the results of a routine, shape (n_results, n); those of a matrix row by row."""

    def _matrices(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return the matrices of a routine, shape (n, n_forces, n_columns)."""
        table = self._table(routine, inputs, parameters)
        return np.ascontiguousarray(table.T).reshape(table.shape[1], len(self._module.FORCES), -1)


def plain_rows(model: Model, inputs: FloatArray, parameters: FloatArray) -> npt.NDArray[np.bool_]:
    """Return the rows in which no effect on demand acts and every option that matters has its first value.

    `inputs`, shape (n_inputs, n). `parameters`, shape (n_parameters,). Returns shape (n,).
    """
    options, requesting = _deciding(model)
    if parameters[options].any():
        return np.zeros(inputs.shape[1], dtype=np.bool_)
    if not requesting:
        return np.ones(inputs.shape[1], dtype=np.bool_)
    return np.asarray((inputs[requesting] == 0).all(axis=0), dtype=np.bool_)


def all_plain(model: Model, inputs: FloatArray, parameters: FloatArray) -> bool:
    """Return whether all rows are plain (`plain_rows`), faster than `plain_rows` itself."""
    options, requesting = _deciding(model)
    # For a hundred rows, any() takes several times as long as count_nonzero().
    return not np.count_nonzero(parameters[options]) and not any(np.count_nonzero(inputs[i]) for i in requesting)


@lru_cache(maxsize=64)
def _deciding(model: Model) -> tuple[npt.NDArray[np.intp], list[int]]:
    """Return the indices of the parameters and of the inputs that must be 0 in plain rows."""
    module = numpy_module(model)  # has the names without a pass over the lines
    parameters, inputs = list(module.PARAMETERS), [quantity.name for quantity in model.inputs]
    options = np.array([parameters.index(name) for name in module.PLAIN_OPTIONS], dtype=np.intp)
    return options, [inputs.index(name) for _, name in model.on_demand]


def slices(n: int, size: int) -> list[slice]:
    """Return the slices that divide n rows into chunks of `size`."""
    return [slice(start, min(start + size, n)) for start in range(0, n, size)]
