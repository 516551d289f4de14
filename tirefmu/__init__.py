"""From tire bench data to a fitted Magic Formula tire, packed as an FMU and checked against the data."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tirefmu.symbolic.errors import TirefmuError
from tirefmu.tires import Tire, published, read_tir

if TYPE_CHECKING:
    from tirefmu.fitting import FitResult, fit
    from tirefmu.fmu import CheckResult, check, export
    from tirefmu.measurements import Recording, VirtualBench, read_recording

__version__ = version("tirefmu")

#: Names of rooms that bring large libraries along: imported when first asked for.
_ON_DEMAND = {
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
    "FitResult",
    "Recording",
    "Tire",
    "TirefmuError",
    "VirtualBench",
    "check",
    "export",
    "fit",
    "load",
    "published",
    "read_recording",
]


def load(path: str | Path) -> Tire:
    """Return the tire in a .tir file.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Tire
        In ISO-W.

    Raises
    ------
    TirError
        If the file is missing or broken; file, line and key stand in the message.
    """
    return read_tir(path)


def __getattr__(name: str) -> Any:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module 'tirefmu' has no attribute {name!r}")
    return getattr(import_module(f"tirefmu.{_ON_DEMAND[name]}"), name)
