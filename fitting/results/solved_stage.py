"""The solution of a stage with all that is required to solve it again near that solution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...numerics.arrays import FloatArray, IntArray
from ..constraints.verification import ConstraintPoints
from ..evidence.residuals import Residuals
from ..problem.recipe import Freed
from ..problem.weighted_residuals import Problem
from ..uncertainty.discrepancy import Discrepancy


@dataclass(frozen=True, eq=False)
class Ended:
    """The end of a stage that used all of its rows.

    - `stage`: its index in the recipe.
    - `free`: guess and bounds of the free coefficients.
    - `x`, shape (n_free,): scaled free values of the solution.
    """

    stage: int
    free: Mapping[str, Freed]
    x: FloatArray


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
    rows: IntArray
    determined: frozenset[str]

    @classmethod
    def of(
        cls, name: str, end: Ended, problem: Problem, constraints: Sequence[ConstraintPoints], ridge: float,
        rows: npt.ArrayLike, determined: Set[str],
    ) -> SolvedStage:  # fmt: skip
        """Return the record of a stage that has ended."""
        lower = np.array([freed.lower for freed in end.free.values()]) / problem.scale
        upper = np.array([freed.upper for freed in end.free.values()]) / problem.scale
        x = np.clip(end.x, lower, upper)
        numbers = np.asarray(rows, dtype=np.int64)
        return cls(name, problem, x, lower, upper, tuple(constraints), ridge, numbers, frozenset(determined))


@dataclass(frozen=True, eq=False)
class FitSolution:
    """What intervals, diagnostics and bootstrap of a fit are computed from.

    - `residuals`: the fitted rows.
    - `covariance`: of the coefficients by name, without NaN: coefficients that are not identifiable have the plausible
      deviation of one size, and those at a bound 0.
    - `stages`: the solutions of the stages with all their rows, always in adapted SAE.
    - `discrepancies`: errors of the form of the model, which are part of the covariance; always in adapted SAE.
    """

    residuals: Residuals | None = None
    covariance: pd.DataFrame = field(default_factory=pd.DataFrame)
    stages: tuple[SolvedStage, ...] = ()
    discrepancies: tuple[Discrepancy, ...] = ()

    def in_signs(self, signs: str, flips: FloatArray) -> FitSolution:
        """Return the same in another sign convention, with the changes of sign of the covariance, shape (n, n)."""
        residuals = None if self.residuals is None else replace(self.residuals, signs=signs)
        return replace(self, residuals=residuals, covariance=self.covariance * flips)
