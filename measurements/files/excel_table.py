"""Excel workbooks, with columns as in CSV tables: the first visible sheet that has a table."""

from __future__ import annotations

from pathlib import Path

from ...boundary.errors import DataError
from . import native_reader
from .columns.cells import is_missing, is_number
from .columns.content import Content, listed
from .columns.frames import sheet_content

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
    others = [other for other, _, _ in sheets if other != name]
    ignored = (f"sheets {listed(others)}",) if others else ()
    return sheet_content(rows, str(path), ignored)


def _numbers(rows: list[tuple[int, list[object]]]) -> int:
    """Return the number of rows with two numbers at least."""
    return sum(sum(is_number(cell) and not is_missing(cell) for cell in cells) > 1 for _, cells in rows)
