"""The solution of a stage with all that is required to solve it again near that solution."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..constraints.verification import ConstraintPoints
from ..problem.weighted_residuals import Problem
from .checkpoint import Ended

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SolvedStage:
    """A stage with all of its rows, and its solution, in adapted SAE.

    - `x`, `lower`, `upper`, shape (n_free,): scaled free values of the solution, and their bounds.
    - `constraints`, shape (n_inputs, n_points): the physical constraints, each with the points at which it was imposed.
    - `ridge`: strength of the regularization.
    - `rows`, shape (n,): number of each row of the problem, counted over all rows of all recordings.
    - `determined`: the coefficients that no later stage frees.
    """

    name: str
    problem: Problem
    x: FloatArray
    lower: FloatArray
    upper: FloatArray
    constraints: tuple[ConstraintPoints, ...]
    ridge: float
    rows: npt.NDArray[np.int64]
    determined: frozenset[str]

    @classmethod
    def of(
        cls, name: str, end: Ended, problem: Problem, constraints: Sequence[ConstraintPoints], ridge: float,
        rows: npt.ArrayLike, determined: Set[str],
    ) -> SolvedStage:  # fmt: skip
        """Return the record of a stage that has ended."""
        lower = np.array([each.lower for each in end.free.values()]) / problem.scale
        upper = np.array([each.upper for each in end.free.values()]) / problem.scale
        x = np.clip(end.x, lower, upper)
        numbers = np.asarray(rows, dtype=np.int64)
        return cls(name, problem, x, lower, upper, tuple(constraints), ridge, numbers, frozenset(determined))
