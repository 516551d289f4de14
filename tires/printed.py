"""The code of a model: what lies in generated/, or, with effects beyond the book, printed once and stored by content.

A model with added effects has the same routines under the same names as its base.
"""

from __future__ import annotations

import hashlib
import py_compile
from collections.abc import Callable
from functools import lru_cache
from importlib import import_module
from importlib.machinery import SourcelessFileLoader
from importlib.resources import files
from importlib.util import MAGIC_NUMBER, module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType

from tirefmu.symbolic.added import effect_text
from tirefmu.symbolic.errors import TirefmuError
from tirefmu.symbolic.model import Model

from .library_cache import cached


def numpy_module(book: Model) -> ModuleType:
    """Return the NumPy module of a model."""
    return _module(book, "numpy")


def casadi_module(book: Model) -> ModuleType:
    """Return the CasADi module of a model."""
    return _module(book, "casadi")


def c_folder(book: Model) -> Path:
    """Return the folder that holds the C files of a model."""
    return (printed_folder(book) if book.added else Path(str(files("tirefmu.generated")))) / "c"


@lru_cache(maxsize=64)
def _module(book: Model, language: str) -> ModuleType:
    if not book.added:
        return import_module(f"tirefmu.generated.{language}.{book.name}")
    folder = printed_folder(book)
    name = f"tirefmu_printed_{folder.name}_{language}".replace("-", "_")
    # The compiled file has been checked with the rest of the entry. Python would look for one of its own elsewhere.
    loader = SourcelessFileLoader(name, str(folder / language / f"{book.name}.pyc"))
    spec = spec_from_loader(name, loader)
    if spec is None:
        raise TirefmuError(f"{folder}: the printed code of {book.name} cannot be loaded")
    module = module_from_spec(spec)
    loader.exec_module(module)
    return module


@lru_cache(maxsize=64)
def printed_folder(book: Model) -> Path:
    """Return the folder of a printed model, printing it where it is not there yet.

    Parameters
    ----------
    book : Model
        With added effects.

    Returns
    -------
    Path
        With numpy/, casadi/ and c/ below it, as generated/ has them, and the Python files compiled.

    Raises
    ------
    TirefmuError
        If it can be written nowhere.
    """
    manifest = (files("tirefmu.generated") / "MANIFEST.json").read_bytes()
    effects = "\0".join(effect_text(effect) for effect in book.added)
    digest = hashlib.sha256(manifest + MAGIC_NUMBER + effects.encode()).hexdigest()[:24]

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
