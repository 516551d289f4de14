"""Excel workbooks, with columns as in CSV tables: the first sheet, its first row has the headers."""

from __future__ import annotations

from pathlib import Path

from ...boundary.errors import DataError
from ..interpretation import Interpretation
from ..recording import Recording
from . import native_reader
from .table_recording import table_recording

EXTRA = "Excel needs openpyxl, which the extra 'excel' installs: pip install 'tirefmu[excel]'"


def read_excel_table(path: Path, signs: str, interpretation: Interpretation) -> Recording:
    """Read the first sheet of a workbook.

    `signs`: the convention of the table. Raises `DataError` if openpyxl is not installed, the file is not a workbook,
    or a channel cannot be used. The message counts rows of the sheet.
    """
    try:
        table = native_reader.load("excel", path)
    except native_reader.MissingPackage:
        raise DataError(f"{path}: {EXTRA}") from None
    return table_recording(path, table, signs, interpretation, lambda row: f"row {row + 2}")
