"""CasADi functions that are called often: their arguments and results are arrays that stay in place.

A call takes 2 us where the conversion of arguments and results to CasADi's matrices takes 50 us.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...numerics.arrays import FloatArray


class BufferedFunction:
    """A CasADi function with dense arguments and results, evaluated into arrays of its own.

    - `arguments`, `results`, shape (size,): their numbers by columns. Whoever calls the object writes the arguments
      first; the next call writes the results again.

    >>> import casadi as ca
    >>> x = ca.SX.sym("x", 2)
    >>> double = BufferedFunction(ca.Function("double", [x], [2.0 * x]))
    >>> double.arguments[0][:] = 1.0, 3.0
    >>> double()[0].tolist()
    [2.0, 6.0]
    """

    def __init__(self, function: Any) -> None:
        self.arguments = tuple(np.zeros(function.nnz_in(i)) for i in range(function.n_in()))
        self.results = tuple(np.zeros(function.nnz_out(i)) for i in range(function.n_out()))
        self._buffer, self._evaluate = function.buffer()  # the buffer lives as long as the arrays
        for i, array in enumerate(self.arguments):
            self._buffer.set_arg(i, array.data)
        for i, array in enumerate(self.results):
            self._buffer.set_res(i, array.data)

    def __call__(self) -> tuple[FloatArray, ...]:
        """Return the results for the present arguments."""
        self._evaluate()
        return self.results
