"""The selected rows of a recording, by an expression or by a file that contains one."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from ...boundary.errors import DataError
from ...numerics.arrays import BoolArray, FloatArray
from ...symbolic.channels import CHANNELS
from ..operating_conditions.phases import phases
from ..recording import Recording
from .expression import LONGEST_EXPRESSION, parse_selection, quoted

#: Extensions of files with an expression.
SUFFIXES = (".where", ".txt")


def selected(recording: Recording, where: str) -> Recording:
    """Return the rows of a recording that satisfy an expression.

    Parameters
    ----------
    recording : Recording
        In any signs; names and units in the expression are those of the contract.
    where : str
        See `parse_selection`; or the path of a file (``.where``, ``.txt``) with an expression, in which ``#`` begins a
        comment.

    Returns
    -------
    Recording
        ``about["selected"]`` has the numbers of rows.

    Raises
    ------
    DataError
        If the expression is invalid, a channel is missing, or no row satisfies it.

    Examples
    --------
    >>> import pandas as pd
    >>> bench = Recording(pd.DataFrame({"t": [0.0, 1.0, 2.0], "p": [70e3, 83e3, 97e3]}), "iso", "run.csv")
    >>> selected(bench, "t > 0.5 and p in 80..90 kPa").table["p"].tolist()
    [83000.0]
    """
    chosen = matching(recording, where)
    if not chosen.any():
        expression = expression_of(where)
        names = sorted(parse_selection(expression).names - {"file"})
        ranges = "; ".join(_range(recording, name) for name in names)
        raise DataError(
            f"where {quoted(expression)} selects none of {len(recording)} rows of {recording.source}"
            f"{f': {ranges}' if ranges else ''}"
        )
    count = f"{int(chosen.sum())} of {len(recording)} rows selected"
    table = recording.table[chosen].reset_index(drop=True)
    return replace(recording, table=table, about={**recording.about, "selected": count})


def matching(recording: Recording, where: str) -> BoolArray:
    """Return for each row of a recording whether it satisfies an expression, shape (n,).

    `where`: as for `selected`. Raises `DataError` if the expression is invalid or a channel is missing.
    """
    expression = expression_of(where)
    condition = parse_selection(expression)
    for name in condition.names:
        if name in CHANNELS and name not in recording.table:
            present = ", ".join(channel for channel in CHANNELS if channel in recording.table)
            raise DataError(f"where {quoted(expression)}: {recording.source} has no channel {name}; it has {present}")
    return condition.matches(cache(lambda name: _numbers(recording, name)), recording.source)


def expression_of(where: str) -> str:
    """Return the expression, from a file if the text is the path of one.

    Raises `DataError` if the file cannot be read.
    """
    if not where.strip().endswith(SUFFIXES):
        return where
    path = Path(where.strip())
    try:
        with path.open("rb") as file:
            # The parser refuses longer texts.
            return file.read(4 * LONGEST_EXPRESSION).decode("utf-8")
    except OSError as error:
        raise DataError(f"where: {path}: cannot be read ({error.strerror or error})") from None
    except UnicodeDecodeError:
        raise DataError(f"where: {path}: not a text file (UTF-8)") from None
    except ValueError as error:  # a zero in the path
        raise DataError(f"where: {quoted(where)}: cannot be read ({error})") from None


def _numbers(recording: Recording, name: str) -> FloatArray:
    """Return the numbers of a channel, of the load for Fz, or of a counter from 1."""
    if name == "sample":
        return np.arange(1.0, len(recording) + 1.0)
    if name == "segment":
        return recording.segment_numbers().astype(np.float64) + 1.0
    if name == "sweep":
        numbers = np.zeros(len(recording))  # 0 outside of sweeps
        for number, sweep in enumerate((phase for phase in phases(recording) if phase.kind == "sweep"), start=1):
            numbers[sweep.rows] = number
        return numbers
    values = recording.table[name].to_numpy(dtype=np.float64)
    return -values if name == "Fz" and recording.signs == "sae" else values


def _range(recording: Recording, name: str) -> str:
    """Return the range of a name in a recording, with its SI unit."""
    values = _numbers(recording, name)
    if np.isnan(values).all():
        return f"{name} has no number"
    unit = CHANNELS[name].after if name in CHANNELS else ""
    return f"{name} is {np.nanmin(values):.6g} to {np.nanmax(values):.6g}{unit}"
