"""The cost that a stage minimizes: that of its problem and a weak pull to where it starts."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .weighted_residuals import Problem

FloatArray = npt.NDArray[np.float64]


class Ridge:
    """A problem with a pull of every scaled value towards its start, against directions that the data leave open.

    Parameters
    ----------
    problem : Problem
    start : ndarray, shape (n_free,)
    strength : float
        The cost of one unit away from the start is half of it.
    """

    def __init__(self, problem: Problem, start: FloatArray, strength: float) -> None:
        self.problem, self._start, self._strength = problem, start.copy(), strength

    def cost(self, x: FloatArray) -> float:
        """Return the cost at scaled free values x, shape (n_free,)."""
        away = x - self._start
        return self.problem.cost(x) + 0.5 * self._strength * float(away @ away)

    def derivatives(self, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return cost, gradient (n_free,) and Gauss-Newton matrix (n_free, n_free)."""
        _, gradient, matrix = self.problem.derivatives(x)
        gradient += self._strength * (x - self._start)
        matrix[np.diag_indices_from(matrix)] += self._strength
        return self.cost(x), gradient, matrix
