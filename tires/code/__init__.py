"""The generated code of a model behind one face, whatever the language."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from functools import cached_property, lru_cache
from types import ModuleType
from typing import Protocol

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic import model as model_of
from tirefmu.symbolic.errors import UnknownName
from tirefmu.symbolic.model import Model

from .compiler import CompilerError, compiled_model
from .kernel import Kernel
from .modules import c_folder, casadi_module, numpy_module

FloatArray = npt.NDArray[np.float64]
LANGUAGES = ("numpy", "c", "casadi", "batch")

#: Rows that NumPy takes at a time: what it makes on the way stays in the processor's cache.
CHUNK = 8192
#: From here on the kernels' blocks and threads pay.
MANY_ROWS = 2000


class Code(Protocol):
    """What a language's code offers: rows of inputs in, rows of results out.

    Attributes
    ----------
    quantities_names : tuple of str
    entries : ndarray of int, shape (2, n_entries)
        Force and coefficient of each derivative by coefficients that is not 0 everywhere.
    """

    quantities_names: tuple[str, ...]
    entries: npt.NDArray[np.intp]

    def forces(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return forces, shape (n_forces, n), at inputs of shape (n_inputs, n)."""

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return named quantities, shape (n_quantities, n), at inputs of shape (n_inputs, n)."""

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


def code_for(model: str | Model, language: str, threads: int = 1) -> Code:
    """Return the code of a model in a language.

    Parameters
    ----------
    model : str or Model
        Its name, or the model itself where it has added effects.
    language : {"numpy", "c", "casadi", "batch"}
        "batch" is C for whole tables, vectorized for this machine.
    threads : int
        Processors among which "batch" divides the rows.

    Returns
    -------
    Code

    Raises
    ------
    UnknownName
        If the language is none of these.
    CompilerError
        If it has to be compiled and cannot be.

    Examples
    --------
    >>> code_for("mf96", "numpy").quantities_names[-2:]
    ('M_zr', 's')
    """
    return _code_for(model_of(model) if isinstance(model, str) else model, language, threads)


def fastest_code(model: str | Model, n_rows: int = MANY_ROWS, threads: int = 1) -> Code:
    """Return the code that evaluates so many rows soonest, with a compiler or without.

    Parameters
    ----------
    model : str or Model
    n_rows : int
    threads : int

    Returns
    -------
    Code
        NumPy for few rows, which needs no compiler; the batch kernels for many, or NumPy where they cannot be built.
    """
    if n_rows < MANY_ROWS:
        return code_for(model, "numpy")
    try:
        return code_for(model, "batch", threads)
    except CompilerError:
        return code_for(model, "numpy")


def forces_of_each(code: Code, inputs: FloatArray, population: FloatArray) -> FloatArray:
    """Return the forces of many tires of one model at the same rows.

    Parameters
    ----------
    code : Code
    inputs : ndarray, shape (n_inputs, n)
    population : ndarray, shape (n_tires, n_parameters)
        They differ in coefficients, not in options.

    Returns
    -------
    ndarray, shape (n_tires, n_forces, n)
    """
    if isinstance(code, _BatchCode):
        return code.forces_of_each(inputs, population)
    return np.stack([code.forces(inputs, parameters) for parameters in population])


@lru_cache(maxsize=64)
def _code_for(book: Model, language: str, threads: int) -> Code:
    kinds: dict[str, Callable[[Model], Code]] = {"numpy": _NumpyCode, "c": _CCode, "casadi": _CasadiCode}
    if language == "batch":
        return _BatchCode(book, threads)
    if language not in kinds:
        raise UnknownName("language of the generated code", language, LANGUAGES)
    return kinds[language](book)


def straight_rows(book: Model, inputs: FloatArray, parameters: FloatArray) -> npt.NDArray[np.bool_]:
    """Tell in which rows nothing on demand acts and every option that matters there has its first value.

    Parameters
    ----------
    book : Model
    inputs : ndarray, shape (n_inputs, n)
    parameters : ndarray, shape (n_parameters,)

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    module = numpy_module(book)  # it knows without a walk through the lines
    chosen = dict(zip(module.PARAMETERS, parameters, strict=True))
    if any(chosen[name] != 0 for name in module.STRAIGHT_OPTIONS):
        return np.zeros(inputs.shape[1], dtype=np.bool_)
    names = [quantity.name for quantity in book.inputs]
    asked = [names.index(name) for _, name in book.on_demand]
    return np.asarray((inputs[asked] == 0).all(axis=0), dtype=np.bool_)


def _entries(module: ModuleType) -> npt.NDArray[np.intp]:
    column = {name: i for i, name in enumerate(module.COEFFICIENTS)}
    places = [(force, column[name]) for force, reached in enumerate(module.REACH) for name in reached]
    return np.array(places, dtype=np.intp).reshape(-1, 2).T


class _NumpyCode:
    """The NumPy module, some thousand rows at a time."""

    def __init__(self, book: Model) -> None:
        self._book, self._module = book, numpy_module(book)
        self.quantities_names: tuple[str, ...] = self._module.QUANTITIES
        self.entries = _entries(self._module)

    def forces(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._rows("forces", inputs, parameters)

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._rows("quantities", inputs, parameters)

    def jacobian_inputs(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return _as_matrices(self._rows("jacobian_inputs", inputs, parameters), len(self._module.FORCES))

    def jacobian_parameters(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return _as_matrices(self._rows("jacobian_parameters", inputs, parameters), len(self._module.FORCES))

    def jacobian_entries(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        force, coefficient = self.entries
        table = self._rows("jacobian_parameters", inputs, parameters)
        chosen: FloatArray = table[force * len(self._module.COEFFICIENTS) + coefficient]
        return chosen

    def jacobian_chunks(
        self, inputs: FloatArray, parameters: FloatArray, size: int
    ) -> Iterator[tuple[slice, FloatArray]]:
        return _chunks(self, inputs, parameters, size)

    def _rows(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Results, row by row of a matrix, shape (n_results, n)."""
        straight = f"{routine}_straight"
        if hasattr(self._module, straight) and straight_rows(self._book, inputs, parameters).all():
            routine = straight
        starts = range(0, inputs.shape[1], CHUNK) or range(1)
        return np.concatenate([self._chunk(routine, inputs[:, i : i + CHUNK], parameters) for i in starts], axis=1)

    def _chunk(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        # Far outside a tire's range a line may divide by zero; the NaN or infinity in its row says so.
        with np.errstate(all="ignore"):
            results = getattr(self._module, routine)(inputs, parameters)
        values = [value for row in results for value in row] if isinstance(results[0], tuple) else results
        table = np.empty((len(values), inputs.shape[1]))
        for row, value in zip(table, values, strict=True):
            row[:] = value
        return table


def _chunks(code: Code, inputs: FloatArray, parameters: FloatArray, size: int) -> Iterator[tuple[slice, FloatArray]]:
    for rows in _slices(inputs.shape[1], size):
        yield rows, code.jacobian_entries(inputs[:, rows], parameters)


def _slices(n: int, size: int) -> list[slice]:
    return [slice(start, min(start + size, n)) for start in range(0, n, size)]


def _as_matrices(table: FloatArray, n_forces: int) -> FloatArray:
    """Turn results by row of a matrix, shape (n_forces * n_columns, n), into matrices by row of the table."""
    return np.ascontiguousarray(table.T).reshape(table.shape[1], n_forces, -1)


class _CCode:
    """The C source, compiled once on this machine."""

    def __init__(self, book: Model) -> None:
        self._model, self._folder = book.name, c_folder(book)
        self._library = compiled_model(self._model, self._folder)
        metadata = numpy_module(book)
        self.quantities_names: tuple[str, ...] = metadata.QUANTITIES
        self._sizes = {
            "forces": (len(metadata.FORCES),),
            "quantities": (len(metadata.QUANTITIES),),
            "jacobian_inputs": (len(metadata.FORCES), len(metadata.INPUTS)),
            "jacobian_parameters": (len(metadata.FORCES), len(metadata.COEFFICIENTS)),
        }
        self.entries = _entries(metadata)

    def forces(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._rows("forces", inputs, parameters).T

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._rows("quantities", inputs, parameters).T

    def jacobian_inputs(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._rows("jacobian_inputs", inputs, parameters)

    def jacobian_parameters(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._rows("jacobian_parameters", inputs, parameters)

    def jacobian_entries(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        force, coefficient = self.entries
        return self.jacobian_parameters(inputs, parameters)[:, force, coefficient].T

    def jacobian_chunks(
        self, inputs: FloatArray, parameters: FloatArray, size: int
    ) -> Iterator[tuple[slice, FloatArray]]:
        return _chunks(self, inputs, parameters, size)

    @cached_property
    def _jacobians(self) -> ctypes.CDLL:
        return compiled_model(self._model, self._folder, jacobians=True)

    def _rows(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        rows = np.ascontiguousarray(inputs.T)
        parameters = np.ascontiguousarray(parameters)
        size = self._sizes[routine]
        results = np.empty((len(rows), *size))
        library = self._jacobians if routine.startswith("jacobian_") else self._library
        getattr(self._library, f"{self._model}_rows")(
            ctypes.cast(getattr(library, f"{self._model}_{routine}"), ctypes.c_void_p),
            ctypes.c_size_t(len(rows)),
            ctypes.c_size_t(int(np.prod(size))),
            *(array.ctypes.data_as(ctypes.c_void_p) for array in (rows, parameters, results)),
        )
        return results


class _CasadiCode:
    """The CasADi module, a casadi.Function over columns."""

    def __init__(self, book: Model) -> None:
        self._module: ModuleType = casadi_module(book)
        self.quantities_names: tuple[str, ...] = self._module.QUANTITIES
        self.entries = _entries(self._module)

    def forces(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._columns("forces", inputs, parameters)

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._columns("quantities", inputs, parameters)

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
        return _chunks(self, inputs, parameters, size)

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


class _BatchCode:
    """Kernels for whole tables; what they do not cover is computed row by row in C."""

    def __init__(self, book: Model, threads: int) -> None:
        self._book, self._threads = book, threads
        self._module = numpy_module(book)
        self.quantities_names: tuple[str, ...] = self._module.QUANTITIES
        self.entries = _entries(self._module)
        self._kernels: dict[str, Kernel] = {}
        self._kernel("forces")  # where it cannot be built, nothing here can

    def forces(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._table("forces", inputs, parameters)

    def forces_of_each(self, inputs: FloatArray, population: FloatArray) -> FloatArray:
        straight = straight_rows(self._book, inputs, population[0])
        results, undone = self._kernel("forces").each(inputs, population)
        undone |= ~straight
        for i in np.flatnonzero(undone.any(axis=1)):
            results[i][:, undone[i]] = self._single.forces(inputs[:, undone[i]], population[i])
        return results

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._single.quantities(inputs, parameters)

    def jacobian_inputs(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return _as_matrices(self._table("jacobian_inputs", inputs, parameters), len(self._module.FORCES))

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
        if not straight_rows(self._book, inputs, parameters).all():
            yield from _chunks(self, inputs, parameters, size)
            return
        kernel, room = self._kernel("jacobian_parameters"), np.empty(self.entries.shape[1] * size)
        for rows in _slices(inputs.shape[1], size):
            columns = inputs[:, rows]
            # One room for all of them: what a processor has in its cache, it need not ask the system for.
            results = room[: len(self.entries[0]) * columns.shape[1]].reshape(-1, columns.shape[1])
            _, undone = kernel(columns, parameters, into=results)
            if undone.any():
                results[:, undone] = self._row_by_row("jacobian_parameters", columns[:, undone], parameters)
            yield rows, results

    @property
    def _single(self) -> Code:
        return _code_for(self._book, "c", 1)

    def _kernel(self, routine: str) -> Kernel:
        if routine not in self._kernels:
            forces, inputs = len(self._module.FORCES), len(self._module.INPUTS)
            sizes = {
                "forces": forces,
                "jacobian_inputs": forces * inputs,
                "jacobian_parameters": self.entries.shape[1],
            }
            self._kernels[routine] = Kernel(self._book, routine, sizes[routine])
        return self._kernels[routine]

    def _table(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        straight = straight_rows(self._book, inputs, parameters)
        if not straight.any():
            return self._row_by_row(routine, inputs, parameters)
        results, undone = self._kernel(routine)(inputs, parameters, self._threads)
        undone |= ~straight
        if undone.any():
            results[:, undone] = self._row_by_row(routine, inputs[:, undone], parameters)
        return results

    def _row_by_row(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        if routine == "forces":
            return self._single.forces(inputs, parameters)
        if routine == "jacobian_inputs":
            return self._single.jacobian_inputs(inputs, parameters).reshape(inputs.shape[1], -1).T
        return self._single.jacobian_entries(inputs, parameters)
