"""The fit as one HTML page: status, quality, figures, coefficients, constraints, stages; nothing outside the file."""

from __future__ import annotations

import base64
import os
import tempfile
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, StrictUndefined

from tirefmu.measurements import Recording
from tirefmu.symbolic.errors import FitError

from .figures import draw_figures
from .residuals import condition_text
from .result import FitResult
from .telling import SIGNIFICANT, told_differences, told_extrapolation, told_interval, told_ripple, told_worst


def write_report(result: FitResult, recordings: Sequence[Recording], path: str | Path) -> None:
    """Write the report of a fit.

    Parameters
    ----------
    result : FitResult
    recordings : sequence of Recording
        What was fitted, for the figures.
    path : str or Path

    Raises
    ------
    FitError
        If the file cannot be written.
    """
    path = Path(path)
    with tempfile.TemporaryDirectory() as folder:
        drawn = draw_figures(result.tire, recordings, Path(folder))
        images = [(image.stem, base64.b64encode(image.read_bytes()).decode("ascii")) for image in drawn]
    page = report_page(result, images)
    scratch = path.with_name(f".{path.name}.part")
    try:
        scratch.write_text(page, encoding="utf-8")
        os.replace(scratch, path)
    except OSError as error:
        scratch.unlink(missing_ok=True)
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
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["number"] = lambda value: f"{value:.5g}"
    environment.filters |= {"known": told_interval, "condition": condition_text, "worst": told_worst}
    template = environment.from_string((files("tirefmu.fitting") / "report.html").read_text(encoding="utf-8"))
    return template.render(
        result=result, images=images, differences=told_differences(result), significant=SIGNIFICANT,
        ripples=told_ripple(result.findings.ripples), extrapolation=told_extrapolation(result),
    )  # fmt: skip
