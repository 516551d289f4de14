"""The code of a model: committed in generated/, or printed once and stored by content.

Committed are the models of the book, and in generated/with_effects the same with the whole library of effects. Printed
are models with other effects, which have the same routines under the same names as their base, and models of which
generated/ has nothing, such as one that a program has registered by itself.
"""

from __future__ import annotations

import hashlib
import json
import py_compile
from collections.abc import Callable
from functools import lru_cache
from importlib import import_module
from importlib.machinery import SourcelessFileLoader
from importlib.resources import files
from importlib.util import MAGIC_NUMBER, module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType
from typing import Any

from tirefmu.symbolic.added import texts_digest
from tirefmu.symbolic.errors import TirefmuError
from tirefmu.symbolic.model import Model
from tirefmu.symbolic.models import WITH_EFFECTS

from .build_cache import cached

#: The laws of the states, equal for all models.
state_laws: Any = import_module("tirefmu.generated.numpy.state_laws")
#: The functions of wheel kinematics, equal for all models.
wheel_kinematics: Any = import_module("tirefmu.generated.numpy.wheel_kinematics")


def numpy_module(book: Model) -> ModuleType:
    """Return the NumPy module of a model; its Jacobians are loaded when one is first used."""
    return _module(book, "numpy")


def casadi_module(book: Model) -> ModuleType:
    """Return the CasADi module of a model; its Jacobians are loaded when one is first used."""
    return _module(book, "casadi")


def c_folder(book: Model) -> Path:
    """Return the folder that holds the C files of a model."""
    return code_folder(book) / "c"


def code_folder(book: Model) -> Path:
    """Return the folder that holds the code of a model, by language."""
    package = _committed_in(book)
    return Path(str(files(package))) if package else printed_folder(book)


def _committed_in(book: Model) -> str:
    """Return the package of generated/ that holds the code of a model, or ''."""
    if book.stored is None:
        return ""
    return f"tirefmu.generated.{WITH_EFFECTS}" if book.added else "tirefmu.generated"


@lru_cache(maxsize=1)
def _manifest() -> frozenset[str]:
    """Return the names of the models in generated/."""
    return frozenset(json.loads((files("tirefmu.generated") / "MANIFEST.json").read_text(encoding="ascii"))["lines"])


@lru_cache(maxsize=64)
def _module(book: Model, language: str) -> ModuleType:
    if package := _committed_in(book):
        module = import_module(f"{package}.{language}.{book.name}")
        if book.parameters != module.PARAMETERS or tuple(q.name for q in book.inputs) != module.INPUTS:
            raise TirefmuError(f'the generated code of {book.name} is stale: run "tirefmu generate"')
        return module
    folder = printed_folder(book)
    module = _loaded(folder, language, book.name)

    def jacobian(routine: str) -> Any:
        """Replace the module's own ``__getattr__``, which imports from a package: a printed model has none."""
        if not routine.startswith("jacobian_"):
            raise AttributeError(f"module {module.__name__!r} has no attribute {routine!r}")
        checked = printed_folder.__wrapped__(book)  # again: time has passed since the module was loaded
        return getattr(_loaded(checked, language, f"{book.name}_jacobians"), routine)

    module.__dict__["__getattr__"] = jacobian
    return module


@lru_cache(maxsize=64)
def _loaded(folder: Path, language: str, file: str) -> ModuleType:
    """Return a module of a printed model."""
    name = f"tirefmu_printed_{folder.name}_{language}_{file}".replace("-", "_")
    # The compiled file has been checked with the rest of the entry. Python would look for one of its own elsewhere.
    loader = SourcelessFileLoader(name, str(folder / language / f"{file}.pyc"))
    spec = spec_from_loader(name, loader)
    if spec is None:
        raise TirefmuError(f"{folder}: the printed code of {file} cannot be loaded")
    module = module_from_spec(spec)
    loader.exec_module(module)
    return module


@lru_cache(maxsize=64)
def printed_folder(book: Model) -> Path:
    """Return the folder of a printed model, printing it where it is not there yet.

    Parameters
    ----------
    book : Model
        Of which generated/ has no code.

    Returns
    -------
    Path
        With numpy/, casadi/ and c/ below it, as generated/ has them, and the Python files compiled.

    Raises
    ------
    ModelError
        If the model violates its declarations.
    TirefmuError
        If it cannot be written.
    """
    manifest = (files("tirefmu.generated") / "MANIFEST.json").read_bytes()
    content = texts_digest(book.added)
    if book.name not in _manifest():
        content += "\0".join(map(repr, (*book.equations, *book.coefficients.values(), book.roles)))
    digest = hashlib.sha256(manifest + MAGIC_NUMBER + content.encode()).hexdigest()[:24]

    def write(folder: Path) -> None:
        for name, text in _render()(book).items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="ascii", newline="\n")
            if path.suffix == ".py":
                compiled = path.with_suffix(".pyc")
                py_compile.compile(str(path), cfile=str(compiled), dfile=name, doraise=True)

    try:
        return cached(f"{book.name}-{digest}", write)
    except OSError as error:
        raise TirefmuError(f"the code of {book.name} cannot be written ({error.strerror or error})") from error


def _render() -> Callable[[Model], dict[str, str]]:
    from tirefmu.symbolic.printers.generate import render_model  # SymPy's printers take their time to load

    return render_model
