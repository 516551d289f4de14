"""The stages of a fit: what each one found, with all that is required to solve it again near its solution."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np

from ...numerics.arrays import FloatArray, IntArray
from ..constraints.verification import ConstraintPoints
from ..problem.weighted_residuals import Problem


@dataclass(frozen=True, eq=False)
class StageResult:
    """The result of a stage, in adapted SAE.

    - `rows`, `free`: number of rows and of free coefficients.
    - `converged`: by the criterion of `tirefmu.fitting.solvers.convergence`; without an optimum, if no coefficient
      differs from it by more than a standard error.
    - `reason`: why it is an optimum or not, as a text for the user.
    - `cost`: half the weighted sum of squares.
    - `r2_uncentred`: of its rows and channels.
    - `detail`: return status of the solver.
    - `x`, shape (n_free,): scaled free values of the solution.
    - `bounds`, shape (2, n_free): their bounds.
    - `ridge`: strength of the regularization.
    - `numbers`, shape (rows,): number of each row, counted over all rows of all recordings; empty if the stage used a
      random sample of its rows, which has no correlation in time.
    - `constraints`, shape (n_inputs, n_points): the physical constraints, each with the points at which it is imposed.
    """

    JSON_KEYS: ClassVar = (
        "name", "rows", "free", "iterations", "converged", "reason", "cost", "r2_uncentred", "detail",
    )  # fmt: skip

    name: str
    rows: int
    free: int
    iterations: int
    converged: bool
    reason: str
    cost: float
    r2_uncentred: float
    detail: str
    problem: Problem = field(repr=False)
    x: FloatArray = field(repr=False)
    bounds: FloatArray = field(repr=False)
    ridge: float = field(repr=False)
    numbers: IntArray = field(repr=False)
    constraints: tuple[ConstraintPoints, ...] = field(default=(), repr=False)

    @property
    def lower(self) -> FloatArray:
        """The lower bounds of the scaled free values, shape (n_free,)."""
        return np.asarray(self.bounds[0])

    @property
    def upper(self) -> FloatArray:
        """The upper bounds of the scaled free values, shape (n_free,)."""
        return np.asarray(self.bounds[1])


@dataclass(frozen=True)
class FitRecord:
    """How a fit ran.

    - `stages`: in order.
    - `recipe`, `method`: names of the recipe and of the method that solved the stages.
    - `seconds`: wall time, s.
    """

    stages: tuple[StageResult, ...]
    recipe: str
    method: str
    seconds: float
    interrupted: Annotated[str, "where the fit was stopped; empty if it is complete"]
