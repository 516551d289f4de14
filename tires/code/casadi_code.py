"""The code of a model in CasADi: the NumPy module, computed with CasADi's functions."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from ...symbolic.model import Model
from .compiler import CompilerError, loaded_library
from .interface import Code
from .modules import numpy_routine

FloatArray = npt.NDArray[np.float64]

#: Functions that NumPy and CasADi share, by NumPy's names.
SHARED = ("acos", "atan", "cos", "exp", "expm1", "log", "logical_and", "logical_or", "sign", "sin", "sqrt", "tan")
#: CasADi's functions under NumPy's names: the argument `xp` of a printed function.
ARRAYS = SimpleNamespace(
    **{name: getattr(ca, name.replace("logical_", "logic_")) for name in SHARED},
    abs=ca.fabs,
    where=ca.if_else,
    pi=ca.pi,
)


def casadi_code(model: Model) -> Code:
    """Return the CasADi code of a model."""
    return _CasadiCode(model)


def casadi_expression(model: Model, routine: str, inputs: Any, parameters: Any, *, plain: bool = False) -> Any:
    """Return the results of a routine as an expression, which CasADi can differentiate.

    `routine`: "forces", "quantities", ... `inputs`, `parameters`: columns. `plain`: as for `numpy_routine`. Returns:
    a column; of a Jacobian a matrix with one row a force.

    >>> from tirefmu.symbolic.models import model_named
    >>> x, p = ca.SX.sym("x", 4), ca.SX.sym("p", len(model_named("mf96").parameters))
    >>> casadi_expression(model_named("mf96"), "forces", x, p).shape
    (3, 1)
    """
    function = numpy_routine(model, routine, plain=plain)
    results = function(ca.vertsplit(inputs), ca.vertsplit(parameters), ARRAYS)
    if routine.startswith("jacobian_"):
        return ca.vertcat(*(ca.horzcat(*row) for row in results))
    return ca.vertcat(*results)


@lru_cache(maxsize=64)
def casadi_function(model: Model, routine: str) -> Any:
    """Return a routine as a casadi.Function of the columns `inputs` and `parameters`."""
    inputs, parameters = ca.SX.sym("inputs", len(model.inputs)), ca.SX.sym("parameters", len(model.parameters))
    results = casadi_expression(model, routine, inputs, parameters)
    return ca.Function(routine, [inputs, parameters], [results], ["inputs", "parameters"], ["results"])


def compiled(function: Any, flags: tuple[str, ...]) -> Any:
    """Return a casadi.Function compiled with flags, or as it is where there is no compiler.

    >>> x = ca.SX.sym("x")
    >>> float(compiled(ca.Function("square", [x], [x**2]), ("-O0",))(3.0))
    9.0
    """
    name = function.name()
    code = ca.CodeGenerator(name)
    code.add(function)
    with TemporaryDirectory(prefix="tirefmu-") as folder:
        source = Path(folder) / f"{name}.c"
        source.write_text(code.dump(), encoding="utf-8")
        try:
            library = loaded_library(name, [source], flags=("-fvisibility=default", *flags))
        except CompilerError:
            return function
    return ca.external(name, library._name)


class _CasadiCode(Code):
    """Every routine as a casadi.Function over columns."""

    def _matrices(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        function = casadi_function(self._model, routine)
        results = [np.array(function(column, parameters)) for column in inputs.T]
        return np.array(results).reshape(-1, *function.size_out(0))

    def _table(self, routine: str, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        function = casadi_function(self._model, routine)
        n = inputs.shape[1]
        if n == 0:  # CasADi maps over at least one column
            return np.empty((function.size1_out(0), 0))
        return np.array(function.map(n)(inputs, np.repeat(parameters[:, None], n, axis=1)))
