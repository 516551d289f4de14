"""Entries: each a module with ``answer(case) -> Answer``, which knows the recording and not the truth.

A new entry is a file here and a line in `ENTRIES`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib import import_module

from tirefmu.boundary.errors import TirefmuError

from ..answers import Answer, Case

#: Module and one line for each entry.
ENTRIES = {
    "baseline": "the fitted baseline model: nothing is missing",
    "diagnosis": "tirefmu diagnose; on other systems only the comparison of explanations by their evidence",
    "stepwise": "forward regression with t-tests of independent rows, without further criteria",
    "pysindy": "ensemble of sequentially thresholded regressions (PySINDy)",
    "sparse_bayes": "automatic relevance determination (scikit-learn)",
    "stability": "stability selection over blocks of time with the lasso (scikit-learn)",
    "gaussian_process": "a smooth function of the inputs, without names (scikit-learn)",
}
#: Entries that need the packages of the extra ``regressions``.
NEED_EXTRA = ("pysindy", "sparse_bayes", "stability", "gaussian_process")


def answer_of(entry: str, case: Case) -> Answer:
    """Return the answer of an entry with its CPU time; a method that raises an error has no answer.

    Raises `TirefmuError` if its packages are not installed.
    """
    began, failed = time.process_time(), ""
    try:
        method: Callable[[Case], Answer] = import_module(f"{__name__}.{entry}").answer
        given = method(case)
    except ImportError as error:
        raise TirefmuError(f"entry {entry} needs {error.name}: pip install 'missing-effects[regressions]'") from None
    except Exception as error:  # of a method that is measured
        given, failed = Answer(), f"{type(error).__name__}: {error}"[:2000]
    return Answer(given.found, given.probabilities, given.variables, given.forces, time.process_time() - began, failed)
