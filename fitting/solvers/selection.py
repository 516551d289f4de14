"""Selection of the solver by the name of its method."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Protocol

from ...boundary.errors import FitError, UnknownName
from ...numerics.arrays import FloatArray
from ..constraints.physical import Constraint
from ..problem.weighted_residuals import Problem
from .evolution import ITERATIONS, Evolution
from .ipopt import Progress, SolverResult, solve

#: IPOPT with exact derivatives, and the derivative-free evolutionary algorithm of the UNICAMP paper.
METHODS = ("ipopt", "ioa")


class Solver(Protocol):
    """A solver of one stage."""

    def __call__(
        self,
        problem: Problem,
        start: FloatArray,
        lower: FloatArray,
        upper: FloatArray,
        constraints: list[tuple[Constraint, FloatArray]],
        *,
        ridge: float = ...,
        stage_type: str = ...,
        refine: bool = ...,
        local: bool = ...,
        progress: Progress | None = ...,
        stop: Callable[[], bool] = ...,
    ) -> SolverResult:
        """Minimize the cost within bounds and constraints."""


def solver_for(method: str, iterations: int | None = None, seed: int = 0) -> Solver:
    """Return the solver of a method.

    `method`, one of "ipopt", "ioa". `iterations`: upper limit for each stage; by default the limit of the method.
    `seed`: seed of a random method. Raises `UnknownName` if there is no such method. Raises `FitError` if the limit is
    less than one, or the seed is negative.

    >>> solver_for("ioa", seed=3).seed
    3
    """
    if method not in METHODS:
        raise UnknownName("method", method, METHODS)
    if iterations is not None and iterations < 1:
        raise FitError(f"iterations = {iterations}: at least one is required")
    if seed < 0:
        raise FitError(f"seed = {seed}: must not be negative")
    if method == "ioa":
        return Evolution(ITERATIONS if iterations is None else iterations, seed)
    return solve if iterations is None else partial(solve, max_iterations=iterations)
