"""Report of a fit as one HTML file: status, goodness of fit, figures, coefficients, constraints, stages."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from tirefmu.measurements import TableLike
from tirefmu.symbolic.errors import FitError, path_from
from tirefmu.tires.drawing.page import inlined, page_text, write_page

from ..evidence.residuals import condition_text
from ..results.fit_result import FitResult
from ..results.intervals import listed_intervals
from .figures import draw_figures
from .report_text import (
    SIGNIFICANT,
    extrapolation_text,
    interval_text,
    ripple_texts,
    significant_differences,
    worst_text,
)


def write_report(
    result: FitResult,
    recordings: TableLike | Iterable[TableLike],
    path: str | Path,
    figures: Sequence[Path] | None = None,
) -> None:
    """Write the report of a fit.

    Parameters
    ----------
    result : FitResult
    recordings : path, DataFrame or Recording, or a sequence of them
        The fitted recordings, for the figures.
    path : str or Path
    figures : sequence of Path, optional
        The files that `draw_figures` has written for them; otherwise they are drawn, which takes seconds.

    Raises
    ------
    FitError
        If the file cannot be written.
    """
    path = path_from(path)
    with tempfile.TemporaryDirectory() as folder:
        images = inlined(draw_figures(result, recordings, Path(folder)) if figures is None else figures)
    try:
        write_page(report_page(result, images), path)
    except OSError as error:
        raise FitError(f"{path}: cannot be written ({error.strerror or error})") from error


def report_page(result: FitResult, images: Sequence[tuple[str, str]]) -> str:
    """Return the page's text.

    Parameters
    ----------
    result : FitResult
    images : sequence of (str, str)
        Name and base64 text of each figure (PNG).

    Returns
    -------
    str
    """
    filters: dict[str, Callable[..., object]] = {
        "number": lambda value: f"{value:.5g}",
        "known": interval_text,
        "condition": condition_text,
        "worst": worst_text,
    }
    return page_text(
        "tirefmu.fitting.reporting", filters, result=result, images=images,
        differences=significant_differences(result), significant=SIGNIFICANT,
        intervals=[each for each in listed_intervals(result) if set(each["at"]) == {"Fz"}],
        ripples=ripple_texts(result.findings.ripples), extrapolation=extrapolation_text(result),
    )  # fmt: skip
