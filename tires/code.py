"""The generated code of a model behind one face, whatever the language."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache
from types import ModuleType
from typing import Protocol

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic import model as model_of
from tirefmu.symbolic.errors import UnknownName
from tirefmu.symbolic.model import Model

from .compiler import compiled_model
from .printed import c_folder, casadi_module, numpy_module

FloatArray = npt.NDArray[np.float64]
LANGUAGES = ("numpy", "c", "casadi")


class Code(Protocol):
    """What a language's code offers: rows of inputs in, rows of results out."""

    quantities_names: tuple[str, ...]

    def forces(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return forces, shape (n_forces, n), at inputs of shape (n_inputs, n)."""

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return named quantities, shape (n_quantities, n), at inputs of shape (n_inputs, n)."""

    def jacobian_parameters(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return derivatives of the forces, shape (n, n_forces, n_coefficients)."""


def code_for(model: str | Model, language: str) -> Code:
    """Return the code of a model in a language.

    Parameters
    ----------
    model : str or Model
        Its name, or the model itself where it has added effects.
    language : {"numpy", "c", "casadi"}

    Returns
    -------
    Code

    Raises
    ------
    UnknownName
        If the language is none of the three.

    Examples
    --------
    >>> code_for("mf96", "numpy").quantities_names[-2:]
    ('M_zr', 's')
    """
    return _code_for(model_of(model) if isinstance(model, str) else model, language)


@lru_cache(maxsize=64)
def _code_for(book: Model, language: str) -> Code:
    kinds: dict[str, Callable[[Model], Code]] = {"numpy": _NumpyCode, "c": _CCode, "casadi": _CasadiCode}
    if language not in kinds:
        raise UnknownName("language of the generated code", language, LANGUAGES)
    return kinds[language](book)


class _NumpyCode:
    """The NumPy module, whole arrays at a time."""

    def __init__(self, book: Model) -> None:
        self._module: ModuleType = numpy_module(book)
        self.quantities_names: tuple[str, ...] = self._module.QUANTITIES

    def forces(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._stacked("forces", inputs, parameters)

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._stacked("quantities", inputs, parameters)

    def jacobian_parameters(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):
            matrix = self._module.jacobian_parameters(inputs, parameters)
        n = inputs.shape[1]
        return np.stack([np.stack([np.broadcast_to(v, n) for v in row], axis=-1) for row in matrix], axis=1)

    def _stacked(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        # Far outside a tire's range a line may divide by zero; the NaN or infinity in its row says so.
        with np.errstate(all="ignore"):
            results = getattr(self._module, routine)(inputs, parameters)
        return np.stack([np.broadcast_to(result, inputs.shape[1]) for result in results])


class _CCode:
    """The C source, compiled once on this machine."""

    def __init__(self, book: Model) -> None:
        self._model, self._library = book.name, compiled_model(book.name, c_folder(book))
        metadata = numpy_module(book)
        self.quantities_names: tuple[str, ...] = metadata.QUANTITIES
        self._sizes = {
            "forces": (len(metadata.FORCES),),
            "quantities": (len(metadata.QUANTITIES),),
            "jacobian_parameters": (len(metadata.FORCES), len(metadata.COEFFICIENTS)),
        }

    def forces(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._rows("forces", inputs, parameters).T

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._rows("quantities", inputs, parameters).T

    def jacobian_parameters(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._rows("jacobian_parameters", inputs, parameters)

    def _rows(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        rows = np.ascontiguousarray(inputs.T)
        parameters = np.ascontiguousarray(parameters)
        size = self._sizes[routine]
        results = np.empty((len(rows), *size))
        getattr(self._library, f"{self._model}_rows")(
            ctypes.cast(getattr(self._library, f"{self._model}_{routine}"), ctypes.c_void_p),
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

    def forces(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._columns("forces", inputs, parameters)

    def quantities(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._columns("quantities", inputs, parameters)

    def jacobian_parameters(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        function = self._module.function(self._module.jacobian_parameters)
        return np.stack([np.array(function(column, parameters)) for column in inputs.T])

    def _columns(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        function = self._module.function(getattr(self._module, routine))
        n = inputs.shape[1]
        if n == 0:  # CasADi maps over one column at least
            return np.empty((function.size1_out(0), 0))
        return np.array(function.map(n)(inputs, np.repeat(parameters[:, None], n, axis=1)))
