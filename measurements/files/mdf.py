"""MDF logs (``.mf4``, ``.mdf``, ``.dat``): groups of channels, each group with its own times."""

from __future__ import annotations

from pathlib import Path

from ...boundary.errors import DataError
from . import native_reader
from .content import Column, Content, listed, masked


def read_mdf(path: Path) -> Content:
    """Return the content of an MDF file; samples with an invalidation bit are none.

    Raises `DataError` if asammdf is not installed, or the file is not an MDF file.
    """
    try:
        signals, others = native_reader.load("mdf", path)
    except native_reader.MissingPackage:
        raise DataError(f"{path}: MDF needs asammdf: pip install 'tirefmu[mdf]'") from None
    columns = tuple(
        Column(name, samples if invalid is None else masked(samples, invalid), unit, "", group, times, axis)
        for name, unit, group, times, samples, invalid, axis in signals
    )
    return Content(columns, format="mdf", ignored=(f"channels without numbers {listed(others)}",) if others else ())
