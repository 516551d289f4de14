"""Tires printed for other programs: a file for each language, `program.py` for what they have in common."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING

from ...errors import UnknownName

if TYPE_CHECKING:
    from .program import Program

#: Every language and its module.
LANGUAGES = {
    "numpy": "numpy",
    "c": "c99",
    "cpp": "cpp",
    "matlab": "matlab",
    "javascript": "javascript",
    "casadi": "casadi",
    "rust": "rust",
    "jax": "jax",
    "torch": "torch",
    "latex": "latex",
}


def printer(language: str) -> Callable[[Program], dict[str, str]]:
    """Return the function that prints a program in a language: files by name.

    Parameters
    ----------
    language : str

    Returns
    -------
    callable

    Raises
    ------
    UnknownName
        If there is none; the message offers the nearest.
    """
    if language not in LANGUAGES:
        raise UnknownName("language", language, LANGUAGES)
    files: Callable[[Program], dict[str, str]] = import_module(f".{LANGUAGES[language]}", __name__).files
    return files
