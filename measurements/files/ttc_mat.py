"""FSAE Tire Test Consortium (Calspan) files in MATLAB format, and MATLAB tables of the same channels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.errors import DataError
from ...numerics.arrays import FloatArray
from ..channels import CHANNELS
from ..interpretation import Interpretation
from ..recording import Recording
from . import native_reader
from .columns import channels_in_si, parse_header
from .ttc_channels import bench_recording, has_bench_names

EXTRA = "mat-io, which the extra 'matlab' installs: pip install 'tirefmu[matlab]'"


def read_ttc_mat(path: Path, signs: str, interpretation: Interpretation) -> Recording:
    """Read a ``.mat`` file of the FSAE TTC, or a MATLAB table.

    The channels are variables of the file, or fields of a struct or a table. Units are those of the ``channel`` struct
    or of the table. Older files have none. Their units are SI, or USCS if the file name (``A1464run30``) or the
    pressure indicates it, and ``about`` has the reason. Fields that are known to be unreliable (RUN of the wrong
    length, an empty tireid) are not used. A table with column names of the contract is read like a CSV table.

    `signs`: the convention of the file; Calspan writes sae. Raises `DataError` if the file is not a MATLAB file,
    or if mat-io is not installed and the file has a table or version 7.3. Also raises what `bench_recording` raises.
    """
    fields = _load(path)
    for value in fields.values():
        if isinstance(value, pd.DataFrame) and not has_bench_names([str(name) for name in value]):
            return _contract_table(path, value, signs, interpretation)
    units = dict(_declared(fields))
    members = _members(fields)
    vectors = {name: values for name, value in members.items() if (values := _vector(value)) is not None}
    about = {("credit" if key == "source" else key): _text(members.get(key)) for key in ("tireid", "testid", "source")}
    return bench_recording(path, vectors, units, signs, about, lambda row: f"row {row + 1}", interpretation)


def matlab_vectors(path: Path) -> dict[str, FloatArray]:
    """Return the vectors of numbers of a MATLAB file: its variables, and the fields of its structs and tables.

    Raises `DataError` if the file is not a MATLAB file, or mat-io is not installed and the file needs it.
    """
    fields = _load(path)
    members = dict(fields)
    for value in fields.values():
        members |= _struct(value)
    return {name: values for name, value in members.items() if (values := _vector(value)) is not None}


def _load(path: Path) -> Mapping[str, Any]:
    try:
        loaded = native_reader.load("matlab", path)
    except native_reader.MissingPackage as content:
        raise DataError(f"{path}: {content} need {EXTRA}") from None
    return {name: value for name, value in loaded.items() if not name.startswith("__")}


def _contract_table(path: Path, table: pd.DataFrame, signs: str, interpretation: Interpretation) -> Recording:
    """Read a table with columns such as alpha and Fz. Its units are treated like those of a CSV header."""
    source = str(path)
    units = dict(_table_units(table))
    possible = {*CHANNELS, *interpretation.renamed}
    headers = [f"{name} [{units[name]}]" if units.get(name) and name in possible else name for name in map(str, table)]
    columns = parse_header(headers, source, interpretation)
    in_si, about = channels_in_si(table, columns, source, lambda row: f"row {row + 1}")
    # The default convention of the contract's names is that of the contract, not that of the bench.
    return Recording(in_si, signs, path.name, {**about, "signs": "iso"})


def _members(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return the variables, and the fields of a struct or a table of channels."""
    members = dict(fields)
    for value in fields.values():
        inside = _struct(value)
        if has_bench_names(list(inside)):
            members |= inside
    return members


def _struct(value: Any) -> dict[str, Any]:
    """Return the fields of a table or of a struct of one element; none for other values."""
    if isinstance(value, pd.DataFrame):
        return {str(name): value[name].to_numpy() for name in value}
    cell = value.flat[0] if isinstance(value, np.ndarray) and value.size == 1 else value
    names = getattr(cell, "_fieldnames", None) or getattr(getattr(cell, "dtype", None), "names", None) or ()
    return {name: getattr(cell, name) if hasattr(cell, "_fieldnames") else cell[name] for name in names}


def _vector(value: Any) -> FloatArray | None:
    """Return the numbers of a variable that is a row or column vector, otherwise None."""
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiu":
        return None
    return np.ravel(value).astype(np.float64) if value.size == max(value.shape, default=1) else None


def _declared(fields: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield name and unit of each channel with a declared unit."""
    for value in fields.values():
        if isinstance(value, pd.DataFrame):
            yield from _table_units(value)
    channel = _struct(fields.get("channel"))
    names, spelled = (np.ravel(channel.get(part, np.empty(0))) for part in ("name", "units"))
    for name, unit in zip(names, spelled, strict=False):
        yield _text(name), _text(unit)


def _table_units(table: pd.DataFrame) -> Iterator[tuple[str, str]]:
    units = np.ravel(np.asarray(table.attrs.get("VariableUnits", ()), dtype=object))
    for name, unit in zip(table, units, strict=False):
        if _text(unit):
            yield str(name), _text(unit)


def _text(value: Any) -> str:
    """Return the text in nested MATLAB cells and structs; empty if there is none."""
    while isinstance(value, np.ndarray) and value.dtype.names is None:
        if not value.size:
            return ""
        value = value.flat[0]
    inside = _struct(value)
    if inside:
        return ", ".join(text for text in map(_text, inside.values()) if text)
    return "" if value is None else str(value)
