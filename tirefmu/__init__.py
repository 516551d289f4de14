"""From tire bench data to a fitted Magic Formula tire, exported as an FMU and checked against the data.

The names are loaded on first access: SymPy, pandas, CasADi and Matplotlib take seconds.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from tirefmu.tires.table_argument import read_tables_with

if TYPE_CHECKING:
    from tirefmu.batch.diagnose_many import diagnose_many
    from tirefmu.batch.fit_many import fit_many
    from tirefmu.batch.intervals import bootstrap, profile
    from tirefmu.batch.study import study
    from tirefmu.boundary.errors import TirefmuError
    from tirefmu.diagnosis import Diagnosis, diagnose
    from tirefmu.driving.drive import drive
    from tirefmu.driving.result import Drive
    from tirefmu.fitting import FitResult, fit
    from tirefmu.fmu import CheckResult, ProofResult, add_proof, check, export, repeat_proof
    from tirefmu.measurements import Recording, VirtualBench, read_recording
    from tirefmu.tires import Tire, published
    from tirefmu.tires import read_tir as load
    from tirefmu.tires.drawing.files import draw

    from .evaluation import evaluate

    __version__: str

#: The package or module of each name, and its name there if it is another one.
_ON_DEMAND = {
    "CheckResult": "fmu",
    "Diagnosis": "diagnosis",
    "Drive": "driving.result",
    "FitResult": "fitting",
    "ProofResult": "fmu",
    "Recording": "measurements",
    "Tire": "tires",
    "TirefmuError": "boundary.errors",
    "VirtualBench": "measurements",
    "add_proof": "fmu",
    "bootstrap": "batch.intervals",
    "check": "fmu",
    "diagnose": "diagnosis",
    "diagnose_many": "batch.diagnose_many",
    "drive": "driving.drive",
    "draw": "tires.drawing.files",
    "evaluate": "evaluation",
    "export": "fmu",
    "fit": "fitting",
    "fit_many": "batch.fit_many",
    "load": "tires:read_tir",
    "profile": "batch.intervals",
    "published": "tires",
    "read_recording": "measurements",
    "repeat_proof": "fmu",
    "study": "batch.study",
}

__all__ = [
    "CheckResult",
    "Diagnosis",
    "Drive",
    "FitResult",
    "ProofResult",
    "Recording",
    "Tire",
    "TirefmuError",
    "VirtualBench",
    "add_proof",
    "bootstrap",
    "check",
    "diagnose",
    "diagnose_many",
    "draw",
    "drive",
    "evaluate",
    "export",
    "fit",
    "fit_many",
    "load",
    "profile",
    "published",
    "read_recording",
    "repeat_proof",
    "study",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("tirefmu")
    if name not in _ON_DEMAND:
        raise AttributeError(f"module 'tirefmu' has no attribute {name!r}")
    module, _, renamed = _ON_DEMAND[name].partition(":")
    return getattr(import_module(f"tirefmu.{module}"), renamed or name)


def __dir__() -> list[str]:
    return list(__all__)


def _recording(table: Any, signs: str | None) -> Recording:
    from tirefmu.measurements import recording_from

    return recording_from(table, signs=signs)


read_tables_with(_recording)
