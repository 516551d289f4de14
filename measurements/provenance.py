"""Provenance of a result: the command, the data with their digests, the versions of the software."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version

import numpy as np
import pandas as pd

from .recording import Recording

#: Packages whose version can change digits of a result.
PACKAGES = ("tirefmu", "numpy", "scipy", "casadi", "sympy", "fmpy")


def table_digest(table: pd.DataFrame) -> str:
    """Return the SHA-256 of the names and values of a table of numbers, independent of the order of its columns."""
    digest = hashlib.sha256()
    for name in sorted(map(str, table.columns)):
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(table[name].to_numpy(dtype=np.float64)).tobytes())
    return digest.hexdigest()


def provenance(recordings: Iterable[Recording], command: str = "") -> list[tuple[str, str]]:
    """Return the provenance of a result, as names and texts.

    `command`: the command line; empty if a program computed the result.
    """
    rows = [("command", command)] if command else []
    for recording in recordings:
        numbers = recording.table.select_dtypes("number")
        digest = f"SHA-256 of the values in SI units: {table_digest(numbers)}"
        rows.append((recording.source, f"{len(numbers)} rows, {recording.signs} signs, {digest}"))
    versions = [f"{name} {number}" for name in PACKAGES if (number := _version(name))]
    return [*rows, ("versions", ", ".join([*versions, f"Python {platform.python_version()}"]))]


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
