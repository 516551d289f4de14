"""The code of a model: what lies in generated/, or, with effects beyond the book, printed once and kept by content.

A model with added effects has the same routines under the same names as its base.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from functools import lru_cache
from importlib import import_module
from importlib.resources import files
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from tirefmu.symbolic.added import effect_text
from tirefmu.symbolic.errors import TirefmuError
from tirefmu.symbolic.model import Model

from .compiler import cache_folder


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
    spec = spec_from_file_location(f"tirefmu_printed_{folder.name}_{language}", folder / language / f"{book.name}.py")
    if spec is None or spec.loader is None:
        raise TirefmuError(f"{folder}: the printed code of {book.name} cannot be loaded")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
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
        With numpy/, casadi/ and c/ below it, as generated/ has them.

    Raises
    ------
    TirefmuError
        If the cache cannot be written.
    """
    manifest = (files("tirefmu.generated") / "MANIFEST.json").read_bytes()
    told = "\0".join(effect_text(effect) for effect in book.added)
    digest = hashlib.sha256(manifest + told.encode()).hexdigest()[:24]
    folder = cache_folder() / f"{book.name}-{digest}"
    if folder.is_dir():
        return folder
    try:
        cache_folder().mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=cache_folder()) as scratch:
            made = Path(scratch) / folder.name
            for name, text in _render()(book).items():
                path = made / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding="ascii", newline="\n")
            try:
                os.rename(made, folder)
            except OSError:  # another process printed the same meanwhile
                if not folder.is_dir():
                    raise
    except OSError as error:
        raise TirefmuError(f"{cache_folder()}: cannot be written ({error.strerror or error})") from error
    return folder


def _render() -> Callable[[Model], dict[str, str]]:
    from tirefmu.symbolic.printers.generate import render_model  # SymPy's printers take their time to load

    return render_model
