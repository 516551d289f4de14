"""Solvers of a stage, convergence criterion, restarts, and interruption."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .convergence import GaussNewton, noise_of
    from .evolution import GOAL, NO_GAIN, Evolution
    from .interruption import Interruption
    from .ipopt import INTERRUPTED, LIMIT, SolverResult, solve
    from .restarts import best_end
    from .selection import METHODS, solver_for

__getattr__, __dir__ = on_demand(__name__)
