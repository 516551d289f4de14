"""Diagnosis: residuals of a fitted tire by operating condition, and the effect that the model lacks."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .diagnose import diagnose
from .verdict.result import Diagnosis

if TYPE_CHECKING:
    from .reporting.fmu_comparison import export_and_simulate
    from .reporting.report import write_report
    from .reporting.residual_map import Bin, ResidualMap, draw_residual_maps, residual_map

__all__ = ["Bin", "Diagnosis", "ResidualMap", "diagnose", "draw_residual_maps", "export_and_simulate", "residual_map",
           "write_report"]  # fmt: skip

#: Loaded at their first use: figures and the simulation of FMUs take as long to load as a short recording to diagnose.
_LATER = {
    "export_and_simulate": "fmu_comparison", "write_report": "report", "Bin": "residual_map",
    "ResidualMap": "residual_map", "draw_residual_maps": "residual_map", "residual_map": "residual_map",
}  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.reporting.{_LATER[name]}"), name)
