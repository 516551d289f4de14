"""The Python modules of a model, imported from the package or loaded from the cache of printed code."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from importlib import import_module
from importlib.machinery import SourcelessFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType
from typing import Any

from ...boundary.errors import TirefmuError
from ...symbolic.model import Model
from .printed import packaged_file, printed_folder

#: The laws of the states, equal for all models.
state_laws: Any = import_module("tirefmu.generated.numpy.state_laws")
#: The functions of wheel kinematics, equal for all models.
wheel_kinematics: Any = import_module("tirefmu.generated.numpy.wheel_kinematics")
#: The functions of the two-track vehicle.
two_track: Any = import_module("tirefmu.generated.numpy.two_track")


def numpy_module(model: Model) -> ModuleType:
    """Return the Python module of a model: tables of names, and every routine but its Jacobians.

    Raises `TirefmuError` if the code in the package was printed from other equations.
    """
    module = _module(model, model.name)
    if model.parameters != module.PARAMETERS or tuple(q.name for q in model.inputs) != module.INPUTS:
        raise TirefmuError(f'the generated code of {model.name} is stale: run "tirefmu generate"')
    return module


def numpy_routine(model: Model, routine: str, *, plain: bool = False) -> Callable[..., Any]:
    """Return a printed function of a model; its Jacobians are in a separate module.

    `routine`: "forces", "quantities", "state_lines", "relaxation", "jacobian_inputs" or "jacobian_parameters".
    `plain`: the faster variant for rows without effects on demand, under default options, where there is one. The
    function takes inputs, parameters and the library of arrays, NumPy by default. Raises `AttributeError` if the model
    lacks the routine.
    """
    is_jacobian = routine.startswith("jacobian_")
    module = _module(model, f"{model.name}_jacobians") if is_jacobian else numpy_module(model)
    general: Callable[..., Any] = getattr(module, routine)
    return getattr(module, f"{routine}_plain", general) if plain else general


@lru_cache(maxsize=128)
def _module(model: Model, file: str) -> ModuleType:
    packaged = packaged_file(model, f"numpy/{file}.py")
    if packaged:
        return import_module(f"tirefmu.generated.{packaged.removesuffix('.py').replace('/', '.')}")
    return _loaded(printed_folder(model, jacobians=file.endswith("_jacobians")), file)


@lru_cache(maxsize=128)
def _loaded(folder: Path, file: str) -> ModuleType:
    """Return a module of a printed model."""
    name = f"tirefmu_printed_{folder.name}_{file}".replace("-", "_")
    # The compiled file was checked with the rest of the entry. Python would search for its own file elsewhere.
    loader = SourcelessFileLoader(name, str(folder / "numpy" / f"{file}.pyc"))
    spec = spec_from_loader(name, loader)
    if spec is None:
        raise TirefmuError(f"{folder}: the printed code of {file} cannot be loaded")
    module = module_from_spec(spec)
    loader.exec_module(module)
    return module
