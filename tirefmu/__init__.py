"""From tire bench data to a fitted Magic Formula tire, exported as an FMU and checked against the data."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from tirefmu.symbolic.errors import TirefmuError
from tirefmu.tires import Tire, published
from tirefmu.tires import read_tir as load
from tirefmu.tires.table_argument import read_tables_with

from .evaluation import evaluate

if TYPE_CHECKING:
    from tirefmu.diagnosis import Diagnosis, diagnose
    from tirefmu.fitting import FitResult, fit
    from tirefmu.fmu import CheckResult, check, export
    from tirefmu.measurements import Recording, VirtualBench, read_recording
    from tirefmu.tires.drawing.files import draw

__version__ = version("tirefmu")

#: Names from packages that import large libraries, loaded on first access.
_ON_DEMAND = {
    "diagnose": "diagnosis",
    "Diagnosis": "diagnosis",
    "draw": "tires.drawing.files",
    "fit": "fitting",
    "FitResult": "fitting",
    "export": "fmu",
    "check": "fmu",
    "CheckResult": "fmu",
    "read_recording": "measurements",
    "Recording": "measurements",
    "VirtualBench": "measurements",
}

__all__ = [
    "CheckResult",
    "Diagnosis",
    "FitResult",
    "Recording",
    "Tire",
    "TirefmuError",
    "VirtualBench",
    "check",
    "diagnose",
    "draw",
    "evaluate",
    "export",
    "fit",
    "load",
    "published",
    "read_recording",
]


def __getattr__(name: str) -> Any:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module 'tirefmu' has no attribute {name!r}")
    return getattr(import_module(f"tirefmu.{_ON_DEMAND[name]}"), name)


def __dir__() -> list[str]:
    return list(__all__)


def _recording(table: Any, signs: str | None) -> Recording:
    from tirefmu.measurements import recording_from

    return recording_from(table, signs=signs)


read_tables_with(_recording)
