"""Diagnosis: residuals of a fitted tire by operating condition, and the effect that the model lacks."""

from .diagnose import diagnose
from .reporting.fmu_comparison import export_and_simulate
from .reporting.report import write_report
from .reporting.residual_map import Bin, ResidualMap, draw_residual_maps, residual_map
from .verdict.result import Diagnosis

__all__ = ["Bin", "Diagnosis", "ResidualMap", "diagnose", "draw_residual_maps", "export_and_simulate", "residual_map",
           "write_report"]  # fmt: skip
