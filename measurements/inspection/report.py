"""The inspection of recordings as one HTML page."""

from __future__ import annotations

from pathlib import Path

from ...boundary.errors import DataError, path_from, writing
from ...drawing.page import page_text, write_page
from ..provenance import provenance
from .figures import inspection_figures
from .inspection import InspectionResult
from .tables import TEXTS, all_tables, title


def write_inspection(result: InspectionResult, path: str | Path, *, command: str = "") -> None:
    """Write the page of an inspection: findings, and figures and tables of each recording.

    `command`: the command line, for the provenance. Raises `DataError` if the file cannot be written.
    """
    path = path_from(path)
    page = page_text(
        "tirefmu.measurements.inspection",
        {"title_of": title, "tables_of": all_tables, "figures_of": inspection_figures},
        inspections=result.recordings, findings=result.findings, verdict=result.verdict, serious=not result.ok,
        texts=TEXTS, origin=provenance([inspection.recording for inspection in result.recordings], command),
    )  # fmt: skip
    with writing(path, DataError):
        write_page(page, path)
