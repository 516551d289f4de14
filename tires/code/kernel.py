"""The batch kernels of a model, built for this machine's vector registers on first use."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import numpy.typing as npt

from ...symbolic.model import Model
from .buffer_pool import RESULTS
from .compiler import CompilerError, instruction_set, loaded_library, processor
from .printed import code_file

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

#: Fused multiplications round once instead of twice; the order of operations and NaN are unchanged.
FUSED = ("-ffp-contract=fast", "-fno-trapping-math")
#: Flags of GCC only, on x86. Constants are loaded where they are used: loaded before the loop, they would exceed the
#: registers (2 to 8 % slower).
WIDE = ("-mprefer-vector-width=512", "-fschedule-insns", "-fsched-pressure", "-fno-gcse")


def flags(machine: str) -> tuple[tuple[str, ...], ...]:
    """Return the flags to try in turn; those of the plain machine last, unless another machine is named."""
    chosen = (*FUSED, f"-march={machine}")
    return ((*chosen, *WIDE), chosen, *([FUSED] if machine == "native" else []))


#: For the instruction set that is used.
FLAGS = flags(instruction_set())


class Kernel:
    """One routine of a model for whole tables: rows without turn slip, under default options.

    `routine`: "forces", "jacobian_inputs" or "jacobian_parameters". `n_results`: number of results for a row. Raises
    `CompilerError` if there is no compiler, or it accepts none of the flags.
    """

    def __init__(self, model: Model, routine: str, n_results: int) -> None:
        self.n_results = n_results
        self._call = getattr(loaded_kernel(model, routine), f"{model.name}_batch_{routine}")
        self._call.restype = None
        self._call.argtypes = [ctypes.c_size_t, ctypes.c_size_t, *[ctypes.c_void_p] * 4]

    def __call__(
        self, inputs: FloatArray, parameters: FloatArray, into: FloatArray | None = None
    ) -> tuple[FloatArray, BoolArray]:
        """Return results and which rows have none.

        `inputs`, shape (n_inputs, n). `parameters`, shape (n_parameters,). `into`, shape (n_results, n): array for the
        results; a new array if None. Returns `results`, shape (n_results, n). Returns `undone`, shape (n,): rows in
        which a result is not finite, because of the inputs or because they exceed the range of a kernel's functions.
        """
        columns = np.ascontiguousarray(inputs, dtype=np.float64)
        values = np.ascontiguousarray(parameters, dtype=np.float64)
        n = columns.shape[1]
        results = RESULTS.empty((self.n_results, n)) if into is None else into
        undone = np.empty(n, dtype=np.bool_)
        given, out, marks, coefficients = _address(columns), _address(results), _address(undone), _address(values)
        if n:
            self._call(n, n, given, coefficients, out, marks)
        return results, undone

    def each(self, inputs: FloatArray, population: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return results and which rows have none for each of many parameter vectors.

        `inputs`, shape (n_inputs, n). `population`, shape (n_vectors, n_parameters). Returns `results`, shape
        (n_vectors, n_results, n). Returns `undone`, shape (n_vectors, n).
        """
        columns = np.ascontiguousarray(inputs, dtype=np.float64)
        values = np.ascontiguousarray(population, dtype=np.float64)
        n, vectors = columns.shape[1], len(values)
        results, undone = np.empty((vectors, self.n_results, n)), np.empty((vectors, n), dtype=np.bool_)
        if not n:
            return results, undone
        into, given, out, marks = (array.ctypes.data for array in (columns, values, results, undone))
        for i in range(vectors):
            self._call(
                n, n, into, given + i * values.strides[0], out + i * results.strides[0], marks + i * undone.strides[0]
            )
        return results, undone


def _address(array: npt.NDArray[Any]) -> int:
    """Return the address of an array. With a hundred rows the time of every created object matters.

    The buffer of an array takes a fifth of the time of `__array_interface__`, but must be writable and not empty.
    """
    try:
        return ctypes.addressof(ctypes.c_char.from_buffer(array.data))
    except (TypeError, ValueError, BufferError):
        return int(array.__array_interface__["data"][0])


class ChosenDerivatives:
    """Some entries of the Jacobian by coefficients; the others are not stored.

    Raises `CompilerError` if it cannot be compiled.
    """

    def __init__(self, model: Model) -> None:
        self._call = getattr(loaded_kernel(model, "jacobian_parameters"), f"{model.name}_batch_chosen_derivatives")
        self._call.restype = None
        self._call.argtypes = [ctypes.c_size_t, ctypes.c_size_t, *[ctypes.c_void_p] * 2, ctypes.c_size_t,
                               *[ctypes.c_void_p] * 3]  # fmt: skip

    def __call__(
        self, inputs: FloatArray, parameters: FloatArray, entries: npt.NDArray[np.intp]
    ) -> tuple[FloatArray, BoolArray]:
        """Return the entries, shape (n_chosen, n), and which rows have none."""
        columns = np.ascontiguousarray(inputs, dtype=np.float64)
        values = np.ascontiguousarray(parameters, dtype=np.float64)
        chosen, n = np.ascontiguousarray(entries, dtype=np.uintp), columns.shape[1]
        results, undone = np.empty((len(chosen), n)), np.empty(n, dtype=np.bool_)
        into, given, which, out, marks = (array.ctypes.data for array in (columns, values, chosen, results, undone))
        self._call(n, n, into, given, len(chosen), which, out, marks)
        return results, undone


def loaded_kernel(model: Model, routine: str) -> ctypes.CDLL:
    """Return the library of a routine's kernel, built with the first flags that the compiler accepts.

    Raises `CompilerError` if there is no compiler, or none of the flags suits it.
    """
    name = f"{model.name}_batch_{routine}"
    source = code_file(model, f"c/{name}.c")
    refused = CompilerError(f"{name}: no compiler")
    for chosen in FLAGS:
        try:
            return loaded_library(
                name, [source], headers=[source.with_name(f"{model.name}.h")],
                flags=["-fvisibility=default", *chosen], machine=processor(),
            )  # fmt: skip
        except CompilerError as error:
            refused = error
    raise refused
