"""Diagnosis: residuals of a fitted tire by operating condition, and the effect that the model lacks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..boundary.on_demand import on_demand
from .diagnose import diagnose
from .verdict.result import Diagnosis

if TYPE_CHECKING:
    from .least_squares import LeastSquares, Projected
    from .reporting.fmu_comparison import export_and_simulate
    from .reporting.report import write_report

__all__ = ["Diagnosis", "diagnose", "export_and_simulate", "write_report"]

__getattr__, __dir__ = on_demand(__name__)
