"""Tires printed for other programs: a file for each language, `program.py` for what they have in common."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING

from ....boundary.errors import UnknownName
from ....boundary.plugins import loaded, plugins

if TYPE_CHECKING:
    from .program import PrintedProgram

#: The languages of other packages: entry points of the group ``tirefmu.languages``.
_INSTALLED = {entry.name: entry for entry in plugins("languages")}
#: Every language and the function that prints it: module and name.
LANGUAGES = {name: entry.value for name, entry in _INSTALLED.items()} | {
    "numpy": "python_arrays.numpy_files",
    "c": "c99.files",
    "cpp": "cpp.files",
    "matlab": "matlab.files",
    "javascript": "javascript.files",
    "casadi": "casadi.files",
    "rust": "rust.files",
    "modelica": "modelica.files",
    "jax": "python_arrays.jax_files",
    "torch": "python_arrays.torch_files",
    "latex": "latex.files",
}


def printer(language: str) -> Callable[[PrintedProgram], dict[str, str]]:
    """Return the function that prints a program in a language: files by name.

    Raises `UnknownName` if there is none; the message offers the nearest.
    """
    if language not in LANGUAGES:
        raise UnknownName("language", language, LANGUAGES)
    files: Callable[[PrintedProgram], dict[str, str]]
    if ":" in LANGUAGES[language]:
        files = loaded(_INSTALLED[language])
    else:
        module, function = LANGUAGES[language].split(".")
        files = getattr(import_module(f".{module}", __name__), function)
    return files
