"""A comparison as figures and one HTML page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...boundary.errors import path_from, writing
from ...drawing.page import page_text, write_page
from ...drawing.picture import write_figures
from ...measurements import Recording
from .comparison import Comparison
from .figures import comparison_figures


def write_comparison(
    comparison: Comparison, recordings: Sequence[Recording], folder: str | Path, *, signs: str = "iso"
) -> list[Path]:
    """Write the figures of a comparison and the page ``report.html``, which contains them.

    `folder`: created if it does not exist. `signs`, one of "iso", "adapted-sae", "sae": convention in which the figures
    are drawn. Returns: the page first. Raises `TirefmuError` if a file cannot be written.
    """
    folder = path_from(folder, "folder")
    figures = comparison_figures(comparison, recordings, signs)
    page = page_text("tirefmu.applications.comparison", {"short": short}, comparison=comparison, figures=figures)
    with writing(folder):
        drawn = write_figures(figures, folder)
        write_page(page, folder / "report.html")
    return [folder / "report.html", *drawn]


def short(value: float | None) -> str:
    """Return a number with five digits, or a dash where there is none."""
    return "-" if value is None else f"{value:.5g}"
