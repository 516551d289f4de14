"""The interface of a model's code in every language, and the common parts of the languages."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from types import ModuleType
from typing import Protocol

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.model import Model

from .modules import numpy_module

FloatArray = npt.NDArray[np.float64]


class Code(Protocol):
    """The interface of a language's code: from rows of inputs to rows of results.

    Attributes
    ----------
    quantities_names : tuple of str
        Names of the rows of `quantities`, in the letters of the book.
    entries : ndarray of int, shape (2, n_entries)
        Force and coefficient of each derivative by coefficients that is not 0 everywhere.
    """

    quantities_names: tuple[str, ...]
    entries: npt.NDArray[np.intp]

    def forces(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return forces, shape (n_forces, n), at inputs of shape (n_inputs, n)."""

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return named quantities, shape (n_quantities, n), at inputs of shape (n_inputs, n)."""

    def drives(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return the lines of `Model.drives`, shape (3 n_states, n): target, rate and start of each state."""

    def jacobian_inputs(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return derivatives of the forces by the inputs, shape (n, n_forces, n_inputs)."""

    def jacobian_parameters(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return derivatives of the forces, shape (n, n_forces, n_coefficients)."""

    def jacobian_entries(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return the derivatives of `entries`, shape (n_entries, n)."""

    def jacobian_chunks(
        self, inputs: FloatArray, parameters: FloatArray, size: int
    ) -> Iterator[tuple[slice, FloatArray]]:
        """Go through the rows, `size` at a time: which they are and the derivatives of `entries`, until the next."""


def straight_rows(model: Model, inputs: FloatArray, parameters: FloatArray) -> npt.NDArray[np.bool_]:
    """Return the rows in which no effect on demand acts and every option that matters has its first value.

    `inputs`, shape (n_inputs, n). `parameters`, shape (n_parameters,). Returns shape (n,).
    """
    options, requesting = _deciding(model)
    if parameters[options].any():
        return np.zeros(inputs.shape[1], dtype=np.bool_)
    if not requesting:
        return np.ones(inputs.shape[1], dtype=np.bool_)
    return np.asarray((inputs[requesting] == 0).all(axis=0), dtype=np.bool_)


def all_straight(model: Model, inputs: FloatArray, parameters: FloatArray) -> bool:
    """Return whether all rows are straight (`straight_rows`), faster than `straight_rows` itself."""
    options, requesting = _deciding(model)
    # For a hundred rows, any() takes several times as long as count_nonzero().
    return not np.count_nonzero(parameters[options]) and not any(np.count_nonzero(inputs[i]) for i in requesting)


@lru_cache(maxsize=64)
def _deciding(model: Model) -> tuple[npt.NDArray[np.intp], list[int]]:
    """Return the indices of the parameters and of the inputs that must be 0 in straight rows."""
    module = numpy_module(model)  # has the names without a pass over the lines
    parameters, inputs = list(module.PARAMETERS), [quantity.name for quantity in model.inputs]
    options = np.array([parameters.index(name) for name in module.STRAIGHT_OPTIONS], dtype=np.intp)
    return options, [inputs.index(name) for _, name in model.on_demand]


def jacobian_entries_of(module: ModuleType) -> npt.NDArray[np.intp]:
    """Return force and coefficient of each derivative that is not 0 everywhere, shape (2, n_entries)."""
    column = {name: i for i, name in enumerate(module.COEFFICIENTS)}
    entries = [(force, column[name]) for force, reached in enumerate(module.REACH) for name in reached]
    return np.array(entries, dtype=np.intp).reshape(-1, 2).T


def chunks_of(code: Code, inputs: FloatArray, parameters: FloatArray, size: int) -> Iterator[tuple[slice, FloatArray]]:
    """Yield slices of `size` rows and the Jacobian entries of each; see `Code.jacobian_chunks`."""
    for rows in slices(inputs.shape[1], size):
        yield rows, code.jacobian_entries(inputs[:, rows], parameters)


def slices(n: int, size: int) -> list[slice]:
    """Return the slices that divide n rows into chunks of `size`."""
    return [slice(start, min(start + size, n)) for start in range(0, n, size)]


def as_matrices(table: FloatArray, n_forces: int) -> FloatArray:
    """Turn results by row of a matrix, shape (n_forces * n_columns, n), into matrices by row of the table."""
    return np.ascontiguousarray(table.T).reshape(table.shape[1], n_forces, -1)
