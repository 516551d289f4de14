"""Repeated solutions near the solution of a fit: bootstrap, bounds moved outward, second solutions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .bootstrap import MIN_SWEEPS, bootstrap_of, check_replicates, replicate_tasks, replicates_of, sweeps_of
    from .leverage import corrections, corrections_of

__getattr__, __dir__ = on_demand(__name__)
