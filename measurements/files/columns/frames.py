"""Columns of DataFrames and of sheets of cells, such as those of Excel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ....boundary.errors import DataError
from ...units import find_unit
from .cells import has_decimal_commas, has_point, with_comma_and_point, with_point
from .content import DECIMAL_COMMAS, Column, Content, is_unit
from .layout import SAMPLED, groups_of, layout


def sheet_content(rows: Sequence[tuple[int, Sequence[Any]]], source: str, ignored: Sequence[str] = ()) -> Content:
    """Return the content of a sheet: titles above the names, a row of units below them, and decimal commas in texts.

    `rows`: number and cells of those that are not blank. `ignored`: as of `Content`. Raises `DataError` if a text has a
    point beside decimal commas.
    """
    written, texts = rows, ([cell for cell in cells if isinstance(cell, str)] for _, cells in rows[:SAMPLED])
    if commas := has_decimal_commas(texts):
        rows = [(number, list(map(_with_point, cells))) for number, cells in rows]
    use = layout([cells for _, cells in rows])
    if commas:
        _refuse_points(written[use.first :], rows[use.names][1], source)
    units = [] if use.units is None else rows[use.units][1]
    body, names = rows[use.first :], rows[use.names][1]
    groups = groups_of(names, [cells for _, cells in rows], use)
    columns = []
    for i, header in enumerate(names):
        cells = [cells[i] for _, cells in body]
        if header is not None or any(cell is not None for cell in cells):
            unit = str(units[i]).strip(" []()") if units and units[i] is not None else ""
            text = "" if header is None else str(header).strip()
            filled = pd.Series([np.nan if cell is None else cell for cell in cells])
            columns.append(Column(text, filled, unit, group=groups[i]))
    about = DECIMAL_COMMAS if commas else {}
    return Content(tuple(columns), lambda row: f"row {body[row][0]}", about=about, ignored=tuple(ignored))


def frame_content(table: pd.DataFrame, source: str, units: Mapping[str, str] | None = None) -> Content:
    """Return the content of a DataFrame; one of texts only is a sheet, which may have units and decimal commas.

    `units`: by name. Raises `DataError`: as of `sheet_content`.

    >>> content = frame_content(pd.DataFrame({"alpha": ["deg", "1,5", "2,5"], "Fz": ["kN", "1,0", "1,1"]}), "table")
    >>> [(column.header, column.unit, list(column.cells)) for column in content.columns]
    [('alpha', 'deg', ['1.5', '2.5']), ('Fz', 'kN', ['1.0', '1.1'])]
    """
    texts = not units and len(table) and table.columns.nlevels == 1 and table.index.names == [None]
    if texts and all(pd.api.types.infer_dtype(table[name], skipna=True) == "string" for name in table):
        rows = table.astype(object).where(table.notna(), None).to_numpy().tolist()
        return sheet_content([(0, list(map(str, table.columns))), *enumerate(rows, start=1)], source)
    return Content(tuple(frame_columns(table, units)))


def frame_columns(table: pd.DataFrame, units: Mapping[str, str] | None = None) -> Iterator[Column]:
    """Yield the columns of a DataFrame and its named index, where Parquet files and MATLAB timetables have their times.

    `units`: by name. An index of dates or durations is the time unless a column is named t.
    """
    units = units or {}
    for level in range(table.index.nlevels):
        values = table.index.get_level_values(level)
        clock = values.dtype.kind in "Mm" and "t" not in table.columns
        if values.name is not None or clock:
            header = "Time" if values.name is None else str(values.name)
            yield Column(header, pd.Series(values), units.get(header, ""), "t" if clock else "")
    for number, (name, unit, group) in enumerate(_labels(table.columns)):
        yield Column(name, table.iloc[:, number].reset_index(drop=True), unit or units.get(name, ""), group=group)


def _labels(columns: pd.Index[Any]) -> Iterator[tuple[str, str, str]]:
    """Yield name, unit and group of the columns of a DataFrame; a row of units is the last of several rows of names."""
    rows = [[str(part).strip() for part in label] if isinstance(label, tuple) else [str(label)] for label in columns]
    last = [row[-1] for row in rows]
    units = columns.nlevels > 1 and any(map(is_unit, last)) and all(find_unit(unit) is not None for unit in last)
    for row in rows:
        names = [part for part in (row[:-1] if units else row) if part and not part.startswith("Unnamed: ")]
        yield names[-1] if names else "", row[-1] if units else "", "/".join(names[:-1])


def _with_point(cell: Any) -> Any:
    return with_point(cell) if isinstance(cell, str) else cell


def _refuse_points(rows: Sequence[tuple[int, Sequence[Any]]], names: Sequence[Any], source: str) -> None:
    """Refuse texts of numbers with a point, which may separate thousands."""
    for number, cells in rows:
        for name, cell in zip(names, cells, strict=False):
            if isinstance(cell, str) and has_point(cell):
                raise DataError(f"{source}: row {number}: {with_comma_and_point(str(name), cell)}")
