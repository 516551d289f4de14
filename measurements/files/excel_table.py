"""Excel workbooks, with columns as in CSV tables: the first visible sheet that has a table."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.errors import DataError
from . import native_reader
from .columns.cells import has_decimal_commas, is_missing, is_number, with_point
from .columns.content import DECIMAL_COMMAS, Column, Content, listed
from .columns.layout import SAMPLED, groups_of, layout

EXTRA = "Excel needs openpyxl, which the extra 'excel' installs: pip install 'tirefmu[excel]'"


def read_excel(path: Path) -> Content:
    """Return the content of a workbook; other sheets are ignored.

    Raises `DataError` if openpyxl is not installed, or the file is not a workbook. Messages count rows of the sheet.
    """
    try:
        sheets = native_reader.load("excel", path)
    except native_reader.MissingPackage:
        raise DataError(f"{path}: {EXTRA}") from None
    visible = [(name, rows) for name, shown, rows in sheets if shown] or [(name, rows) for name, _, rows in sheets]
    name, rows = next(((name, rows) for name, rows in visible if _numbers(rows) > 1), visible[0])
    if not rows:
        raise DataError(f"{path}: no rows")
    texts = ([cell for cell in cells if isinstance(cell, str)] for _, cells in rows[:SAMPLED])
    if commas := has_decimal_commas(texts):
        rows = [(number, list(map(_with_point, cells))) for number, cells in rows]
    rows_by_use = layout([cells for _, cells in rows])
    units = [] if rows_by_use.units is None else rows[rows_by_use.units][1]
    body = rows[rows_by_use.first :]
    names = rows[rows_by_use.names][1]
    groups = groups_of(names, [cells for _, cells in rows], rows_by_use)
    columns = []
    for i, header in enumerate(names):
        cells = [cells[i] for _, cells in body]
        if header is not None or any(cell is not None for cell in cells):
            unit = str(units[i]).strip(" []()") if units and units[i] is not None else ""
            text = "" if header is None else str(header).strip()
            columns.append(
                Column(text, pd.Series([np.nan if cell is None else cell for cell in cells]), unit, "", groups[i])
            )
    about = DECIMAL_COMMAS if commas else {}
    others = [other for other, _, _ in sheets if other != name]
    ignored = (f"sheets {listed(others)}",) if others else ()
    return Content(tuple(columns), lambda row: f"row {body[row][0]}", about=about, ignored=ignored)


def _with_point(cell: Any) -> Any:
    return with_point(cell) if isinstance(cell, str) else cell


def _numbers(rows: list[tuple[int, list[object]]]) -> int:
    """Return the number of rows with two numbers at least."""
    return sum(sum(is_number(cell) and not is_missing(cell) for cell in cells) > 1 for _, cells in rows)
