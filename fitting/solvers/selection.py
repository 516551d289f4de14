"""The methods that solve a stage, by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Protocol

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.errors import FitError, UnknownName

from ..constraints.physical import Constraint
from ..problem.weighted_residuals import Problem
from .evolution import ITERATIONS, Evolution
from .ipopt import Progress, Solution, solve

FloatArray = npt.NDArray[np.float64]
#: IPOPT with exact derivatives, and the UNICAMP paper's evolutionary algorithm, without any.
METHODS = ("ipopt", "ioa")


class Solver(Protocol):
    """What a stage is solved by."""

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
        progress: Progress | None = ...,
        stop: Callable[[], bool] = ...,
    ) -> Solution:
        """Minimize the cost within bounds and constraints."""


def solver_for(method: str, iterations: int | None = None, seed: int = 0) -> Solver:
    """Return the solver of a method.

    Parameters
    ----------
    method : {"ipopt", "ioa"}
    iterations : int, optional
        The most that a stage may take; the method's own limit where None.
    seed : int
        Of a method that draws at random.

    Returns
    -------
    Solver

    Raises
    ------
    UnknownName
        If there is no such method.
    FitError
        If the limit is less than one, or the seed is negative.

    Examples
    --------
    >>> solver_for("ioa", seed=3).seed
    3
    """
    if method not in METHODS:
        raise UnknownName("method", method, METHODS)
    if iterations is not None and iterations < 1:
        raise FitError(f"iterations = {iterations}: at least one")
    if seed < 0:
        raise FitError(f"seed = {seed}: a whole number from 0 on")
    if method == "ioa":
        return Evolution(ITERATIONS if iterations is None else iterations, seed)
    return solve if iterations is None else partial(solve, max_iterations=iterations)
