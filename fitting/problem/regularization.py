"""The cost that a stage minimizes: the cost of its problem and a weak regularization towards the initial values."""

from __future__ import annotations

import numpy as np

from ...numerics.arrays import FloatArray
from .weighted_residuals import Problem


class Ridge:
    """A problem with ridge regularization towards the initial values, for directions that are not identifiable.

    `start`, shape (n_free,). `strength`: twice the cost of one unit of distance from the start.
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
