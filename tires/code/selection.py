"""Selection of the code that evaluates a model: by the name of a language, or the fastest for a number of rows."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from ...boundary.errors import UnknownName
from ...symbolic.model import Model
from ...symbolic.models import model_named
from .batch_code import batch_code
from .c_code import c_code
from .compiler import CompilerError
from .interface import Code
from .numpy_code import numpy_code

LANGUAGES = ("numpy", "c", "casadi", "batch")

#: Number of rows from which the kernels' blocks are faster.
MANY_ROWS = 2000


def code_for(model: str | Model, language: str) -> Code:
    """Return the code of a model in a language.

    Parameters
    ----------
    model : str or Model
        Its name, or the model itself where it has added effects.
    language : {"numpy", "c", "casadi", "batch"}
        "batch" is C for whole tables, vectorized for this machine.

    Returns
    -------
    Code
        The functions of the model in this language.

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
    return _code_for(model_named(model) if isinstance(model, str) else model, language)


def fastest_code(model: str | Model, n_rows: int = MANY_ROWS) -> Code:
    """Return the fastest code for a number of rows, with or without a compiler.

    Parameters
    ----------
    model : str or Model
        The model, or its name.
    n_rows : int
        Rows to evaluate at a time.

    Returns
    -------
    Code
        NumPy for few rows, which needs no compiler; the batch kernels for many, or NumPy if they cannot be built.
    """
    if n_rows < MANY_ROWS:
        return code_for(model, "numpy")
    try:
        return code_for(model, "batch")
    except CompilerError:
        return code_for(model, "numpy")


@lru_cache(maxsize=64)
def _code_for(model: Model, language: str) -> Code:
    kinds: dict[str, Callable[[Model], Code]] = {
        "numpy": numpy_code, "c": c_code, "casadi": _casadi_code, "batch": batch_code,
    }  # fmt: skip
    if language not in kinds:
        raise UnknownName("language of the generated code", language, LANGUAGES)
    return kinds[language](model)


def _casadi_code(model: Model) -> Code:
    from .casadi_code import casadi_code  # CasADi loads slowly

    return casadi_code(model)
