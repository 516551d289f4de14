"""Tires as FMUs and STI libraries: native export for FMI 2.0 and 3.0, simulation, and comparison with data.

The names are loaded on first access: an export needs neither pandas nor fmpy.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .comparison.check import check
    from .comparison.result import Channel, CheckResult, WorstPoint
    from .packaging.export import export
    from .packaging.sti import export_sti
    from .packaging.system import export_parameters, export_system

#: The module of each name.
_ON_DEMAND = {
    "Channel": "comparison.result",
    "CheckResult": "comparison.result",
    "WorstPoint": "comparison.result",
    "check": "comparison.check",
    "export": "packaging.export",
    "export_parameters": "packaging.system",
    "export_sti": "packaging.sti",
    "export_system": "packaging.system",
}

__all__ = [
    "Channel", "CheckResult", "WorstPoint", "check", "export", "export_parameters", "export_sti", "export_system",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_ON_DEMAND[name]}", __name__), name)


def __dir__() -> list[str]:
    return list(__all__)
