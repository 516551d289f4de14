"""The C code of a model, compiled once on this machine."""

from __future__ import annotations

import ctypes
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from ...symbolic.model import Model
from .buffer_pool import RESULTS
from .compiler import CompilerError, instruction_set, loaded_library, processor
from .interface import Code, slices
from .printed import code_file

FloatArray = npt.NDArray[np.float64]
#: Rows that are transposed at a time: their inputs and forces fit into the second cache of a processor.
ROWS_IN_CACHE = 4096
#: For the Jacobians row by row: half the time of -O2 to compile, 7 % slower; the second fuses multiplications (GCC).
QUICKLY = ("-O1", "-fexpensive-optimizations")


@lru_cache(maxsize=64)
def c_code(model: Model) -> Code:
    """Return the C code of a model, one object for each."""
    return _CCode(model)


def compiled_model(model: Model, *, jacobians: bool = False) -> ctypes.CDLL:
    """Return the compiled code of a model: all routines except its Jacobians, or the Jacobians.

    `jacobians`: Jacobians are most of the code. They are a separate library, compiled at first use. Raises
    `CompilerError` if it cannot be compiled.
    """
    name = f"{model.name}_jacobians" if jacobians else model.name
    source = code_file(model, f"c/{name}.c")
    headers = [source.with_name(f"{model.name}.h")]
    flags = ["-fvisibility=default", "-ffp-contract=fast", *(QUICKLY if jacobians else [])]
    fast = [*flags, f"-march={instruction_set()}"]
    try:
        return loaded_library(name, [source], headers=headers, flags=fast, machine=processor())
    except CompilerError:  # not every compiler supports its own machine
        return loaded_library(name, [source], headers=headers, flags=flags)


class _CCode(Code):
    """The C source, compiled once on this machine."""

    def __init__(self, model: Model) -> None:
        super().__init__(model)
        self._library, metadata = compiled_model(model), self._module
        self._sizes = {
            "forces": (len(metadata.FORCES),),
            "quantities": (len(metadata.QUANTITIES),),
            "state_lines": (len(model.state_lines),),
            "relaxation": (2,),
            "jacobian_inputs": (len(metadata.FORCES), len(metadata.INPUTS)),
            "jacobian_parameters": (len(metadata.FORCES), len(metadata.COEFFICIENTS)),
        }

    @cached_property
    def _jacobians(self) -> ctypes.CDLL:
        return compiled_model(self._model, jacobians=True)

    def _table(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        return self._matrices(routine, inputs, parameters).T

    def _matrices(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        parameters = np.ascontiguousarray(parameters)
        n, size = inputs.shape[1], self._sizes[routine]
        results = RESULTS.empty((n, *size))
        library = self._jacobians if routine.startswith("jacobian_") else self._library
        apply = getattr(self._library, f"{self._model.name}_rows")
        function = ctypes.cast(getattr(library, f"{self._model.name}_{routine}"), ctypes.c_void_p)
        taken = np.empty((min(n, ROWS_IN_CACHE), len(inputs)))
        columns = [array.ctypes.data_as(ctypes.c_void_p) for array in (taken, parameters)]
        for rows in slices(n, ROWS_IN_CACHE):
            part, results_of_rows = inputs[:, rows], results[rows]
            taken[: part.shape[1]] = part.T
            apply(
                function, ctypes.c_size_t(part.shape[1]), ctypes.c_size_t(int(np.prod(size))), *columns,
                results_of_rows.ctypes.data_as(ctypes.c_void_p),
            )  # fmt: skip
        return results
