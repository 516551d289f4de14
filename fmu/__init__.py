"""Tires as FMUs: native export for FMI 2.0 and 3.0, simulation, and comparison with data.

The names are loaded on first access: an export needs neither pandas nor fmpy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .comparison.check import check
    from .comparison.compared import CheckedChannel, WorstPoint
    from .comparison.result import CheckResult
    from .packaging.export import export
    from .packaging.system import export_parameters, export_system
    from .proof.repetition import ProofResult, repeat_proof
    from .proof.writing import add_proof

__all__ = [
    "CheckResult",
    "CheckedChannel",
    "ProofResult",
    "WorstPoint",
    "add_proof",
    "check",
    "export",
    "export_parameters",
    "export_system",
    "repeat_proof",
]  # fmt: skip

__getattr__, __dir__ = on_demand(__name__)
