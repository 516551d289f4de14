"""From tire bench data to a fitted Magic Formula tire, exported as an FMU and checked against the data.

The names are loaded on first access: SymPy, pandas, CasADi and Matplotlib take seconds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .applications.batch.diagnose_many import diagnose_many
    from .applications.batch.fit_many import fit_many
    from .applications.batch.intervals import bootstrap
    from .applications.batch.study import study
    from .applications.comparison.comparison import compare
    from .applications.driving.drive import drive
    from .applications.driving.result import Drive
    from .applications.explorer.explore import explore
    from .applications.exports.convert import convert
    from .applications.exports.lint import lint
    from .applications.planning.plan import plan
    from .boundary.errors import TirefmuError
    from .diagnosis import Diagnosis, diagnose
    from .fitting import FitResult, fit
    from .fmu import CheckResult, ProofResult, add_proof, check, export, repeat_proof
    from .measurements import Recording, VirtualBench, read_recording
    from .measurements.evaluation import evaluate
    from .measurements.inspection.inspection import inspect
    from .tires import Tire, published
    from .tires import read_tir as load
    from .tires.drawing.files import draw

    __version__: str

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
    "compare",
    "convert",
    "diagnose",
    "diagnose_many",
    "draw",
    "drive",
    "evaluate",
    "explore",
    "export",
    "fit",
    "fit_many",
    "inspect",
    "lint",
    "load",
    "plan",
    "published",
    "read_recording",
    "repeat_proof",
    "study",
]

_get, _ = on_demand(__name__)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version  # takes as long as the rest of the import

        return version("tirefmu")
    return _get(name)


def __dir__() -> list[str]:
    return list(__all__)
