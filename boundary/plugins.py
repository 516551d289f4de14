"""What other installed packages add to this one, by entry points of the groups ``tirefmu.KIND``."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from .errors import TirefmuError

#: The kinds of additions; docs/plugins.md explains each.
KINDS = ("effects", "models", "readers", "languages")


def plugins(kind: str) -> Iterator[EntryPoint]:
    """Yield the entry points of a kind, one of `KINDS`, in the order of their names; no package is imported.

    >>> [entry.name for entry in plugins("effects")]
    []
    """
    yield from sorted(entry_points(group=f"tirefmu.{kind}"), key=lambda entry: (entry.name, entry.value))


def loaded(entry: EntryPoint) -> Any:
    """Import what an entry point names. This runs code of its package.

    Raises `TirefmuError` if that fails.
    """
    try:
        return entry.load()
    except Exception as error:  # code of another package
        raise TirefmuError(f"{described(entry)} cannot be loaded ({type(error).__name__}: {error})") from error


def described(entry: EntryPoint) -> str:
    """Return an entry point and its package in words, for messages."""
    package = entry.dist.name if entry.dist else "unknown"
    return f"package {package}: entry point {entry.name} of {entry.group}"
