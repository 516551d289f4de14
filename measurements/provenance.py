"""Provenance of a result: the command, the data with their digests, the versions of what computed it."""

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
    """Return the SHA-256 of the names and values of a table.

    `table`: with numbers only. Returns: independent of the order of the columns.

    >>> table_digest(pd.DataFrame({"a": [1.0], "b": [2.0]})) == table_digest(pd.DataFrame({"b": [2.0], "a": [1.0]}))
    True
    """
    digest = hashlib.sha256()
    for name in sorted(map(str, table.columns)):
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(table[name].to_numpy(dtype=np.float64)).tobytes())
    return digest.hexdigest()


def provenance(recordings: Iterable[Recording], command: str = "") -> list[tuple[str, str]]:
    """Return what a result was computed from, as names and texts.

    `command`: the command line; empty if a program computed the result.

    >>> run = Recording(pd.DataFrame({"alpha": [0.1], "Fy": [-800.0]}), "iso", "run.csv")
    >>> [name for name, _ in provenance([run], "tirefmu fit run.csv -o my.tir")]
    ['command', 'run.csv', 'versions']
    """
    rows = [("command", command)] if command else []
    for recording in recordings:
        numbers = recording.table.select_dtypes("number")
        text = (
            f"{len(numbers)} rows, {recording.signs} signs, SHA-256 of the values in SI units: {table_digest(numbers)}"
        )
        rows.append((recording.source, text))
    versions = [f"{name} {found}" for name in PACKAGES if (found := _version(name))]
    return [*rows, ("versions", ", ".join([*versions, f"Python {platform.python_version()}"]))]


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
