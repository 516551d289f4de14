"""One thread for linear algebra: matrices of a hundred columns are too small for more."""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import lru_cache

import scipy.linalg  # noqa: F401  (loads SciPy's BLAS, which the list of libraries has to contain)
from threadpoolctl import ThreadpoolController


def one_blas_thread() -> AbstractContextManager[object]:
    """Return a context in which the BLAS libraries of NumPy and SciPy use one thread.

    CasADi brings a BLAS of its own, which the list of libraries does not contain: its threads are those that the
    environment variable OMP_NUM_THREADS sets before it is loaded.

    >>> with one_blas_thread():
    ...     print("one thread")
    one thread
    """
    limited: AbstractContextManager[object] = _libraries().limit(limits=1, user_api="blas")
    return limited


@lru_cache(maxsize=1)
def _libraries() -> ThreadpoolController:
    """Return the loaded libraries. To list them takes fifty times as long as to limit their threads."""
    return ThreadpoolController()
