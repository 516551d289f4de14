"""The inspection of recordings as one HTML page."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from tirefmu.symbolic.errors import DataError, path_from
from tirefmu.tires.drawing.page import inlined, page_text, write_page

from ..findings.finding import Finding
from .figures import draw_inspection
from .inspection import Inspection
from .tables import TEXTS, all_tables, title


def write_inspection(inspections: Sequence[Inspection], findings: Sequence[Finding], path: str | Path) -> None:
    """Write the page of an inspection: findings, and figures and tables of each recording.

    Parameters
    ----------
    inspections : sequence of Inspection
    findings : sequence of Finding
    path : str or Path

    Raises
    ------
    DataError
        If the file cannot be written.
    """
    path = path_from(path)
    drawn = []
    for each in inspections:
        with tempfile.TemporaryDirectory() as folder:
            drawn.append((each, inlined(draw_inspection(each, Path(folder)))))
    page = page_text(
        "tirefmu.measurements.inspection", {"title_of": title, "tables_of": all_tables},
        inspections=inspections, findings=findings, drawn=drawn, texts=TEXTS,
    )  # fmt: skip
    try:
        write_page(page, path)
    except OSError as error:
        raise DataError(f"{path}: cannot be written ({error.strerror or error})") from None
