"""Conversion of table arguments to recordings: a path, a DataFrame or a Recording, and its sign convention."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from ..boundary.errors import DataError, WrongType
from ..symbolic.channels import CHANNELS
from .checks.columns.limits import check_plausible
from .checks.rows.incomplete_rows import without_incomplete_rows
from .column_names import check_names
from .files.columns.frames import frame_content
from .files.reading import read_recording
from .files.table_recording import check_finite, recording_of
from .interpretation import Interpretation
from .recording import Recording

#: Types that the functions of the public interface accept as a table.
TableLike = Recording | pd.DataFrame | str | os.PathLike[str]
ACCEPTED = "the path of a file, a DataFrame or a Recording"


def recording_from(
    table: TableLike,
    *,
    signs: str | None = None,
    where: str | None = None,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    parameter: str = "table",
) -> Recording:
    """Return the recording for a path, a DataFrame or a recording.

    Parameters
    ----------
    table : Recording, pandas.DataFrame, str or path-like
        A DataFrame has the columns of the public tables in SI units.
    signs : str, optional
        The convention of the table. Default: that of the format of a file (`read_recording`), ISO for a DataFrame, and
        that of a recording.
    where : str, optional
        Rows to select: an expression such as ``t > 120 and p in 70..90 kPa``, or a file with one
        (`tirefmu.measurements.selected`). Default: all.
    columns, units : mapping of str to str, optional
        Columns and units that replace those of a file or a DataFrame (`read_recording`).
    parameter : str
        Name of the caller's parameter, for the message.

    Returns
    -------
    Recording
        It has at least one row, finite inputs (rows without an input are excluded and counted), outputs that are
        finite or NaN (not measured), and plausible units.

    Raises
    ------
    DataError
        If a file cannot be read, there is no row, a column resembles an input that the table lacks, a channel is
        infinite, too many rows lack an input, units or signs are implausible, ``signs`` contradicts that of a
        recording, or ``where`` is invalid or selects no row.
    UnknownName
        If the signs are not one of the three conventions.
    WrongType
        If the argument is of another type.

    Examples
    --------
    >>> recording_from(pd.DataFrame({"alpha": [0.1], "Fz": [900.0], "Fy": [-800]})).signs
    'iso'
    >>> recording_from(None)
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.WrongType: table is None: it has to be the path of a file, a DataFrame or a Recording
    """
    reading = {"columns": columns or {}, "units": units or {}}
    if isinstance(table, Recording):
        if columns or units:
            raise DataError(f"{table.source}: columns and units are those of a file or a DataFrame, not of a recording")
        if table.checked and where is None and signs in (None, table.signs):
            return table
        if signs is not None and signs != table.signs:
            raise DataError(
                f"{table.source}: the recording is in {table.signs} signs, not {signs} (with_signs converts it)"
            )
        recording = table
    elif isinstance(table, pd.DataFrame):
        content = frame_content(table, "table")
        recording = recording_of(content, "table", "table", signs, Interpretation(**reading))
    elif isinstance(table, (str, os.PathLike)):
        recording = read_recording(table, signs=signs, **reading)
    else:
        raise WrongType(parameter, table, ACCEPTED)
    check_names(map(str, recording.table.columns), recording.source)
    _check_numbers(recording)
    recording = without_incomplete_rows(recording)
    if where is not None:
        from .row_selection.selected import selected  # loaded here: most tables are used whole

        recording = selected(recording, where)
    check_plausible(recording)
    object.__setattr__(recording, "checked", True)  # the only change; no caller has the recording yet
    return recording


def recordings_from(
    tables: TableLike | Iterable[TableLike],
    *,
    signs: str | None = None,
    where: str | None = None,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> list[Recording]:
    """Return the recordings of one or several tables.

    Parameters
    ----------
    tables : table, or iterable of them
        Each as for `recording_from`.
    signs : str, optional
        The convention of all tables.
    where : str, optional
        Rows to select in each table; an expression may distinguish them by ``file``.
    columns, units : mapping of str to str, optional
        Of each table, as for `recording_from`.

    Returns
    -------
    list of Recording
        In the order of the tables.

    Raises
    ------
    DataError, UnknownName, WrongType
        As for `recording_from`.

    Examples
    --------
    >>> rows = pd.DataFrame({"alpha": [0.1], "Fz": [900.0], "Fy": [-800.0]})
    >>> len(recordings_from(rows)), len(recordings_from([rows, rows]))
    (1, 2)
    """
    how: dict[str, Any] = {"signs": signs, "where": where, "columns": columns, "units": units}
    if isinstance(tables, (Recording, pd.DataFrame, str, os.PathLike)):
        return [recording_from(tables, **how, parameter="tables")]
    if not hasattr(tables, "__iter__") or isinstance(tables, (bytes, Mapping, np.ndarray)):
        raise WrongType("tables", tables, f"{ACCEPTED}, or a sequence of them")
    return [recording_from(table, **how, parameter=f"tables[{i}]") for i, table in enumerate(tables)]


def _check_numbers(recording: Recording) -> None:
    """Check the numbers of a table in memory. Those of a file were checked when it was read."""
    if not len(recording):
        raise DataError(f"{recording.source}: no rows")
    for name in CHANNELS:
        if name in recording.table:
            values = recording.table[name].to_numpy(dtype=np.float64)
            check_finite(values, name, recording.source, lambda row: f"row {row + 1}")
