"""The check of an FMU as one HTML page: verdict, goodness of fit, error over time and over the inputs, provenance."""

from __future__ import annotations

from pathlib import Path

from ...boundary.errors import FmuError, path_from, writing
from ...drawing.labels import drawn_unit, per_si
from ...drawing.page import page_text, write_page
from ...drawing.residual_panels import residuals_over_inputs
from ...measurements import Recording
from ...measurements.provenance import provenance
from .compared import EVALUATION_TOLERANCE, Compared
from .figures import check_figures


def write_check(result: Compared, path: str | Path, *, command: str = "") -> None:
    """Write the page of a check.

    `command`: the command line, for the provenance. Raises `FmuError` if the file cannot be written.

    >>> import pandas as pd
    >>> from tirefmu.fmu import check, export
    >>> from tirefmu.tires import published
    >>> table = pd.DataFrame({"alpha": [-0.1, 0.0, 0.1], "Fz": 900.0, "Fy": [2100.0, 10.0, -2000.0]})
    >>> result = check(export(published("trento_hoosier"), "tire.fmu"), table)
    >>> write_check(result, "check.html")
    >>> "The FMU computes its tire" in Path("check.html").read_text(encoding="utf-8")
    True
    """
    path = path_from(path)
    with writing(path, FmuError):
        write_page(check_page(result, command), path)


def check_page(result: Compared, command: str = "") -> str:
    """Return the text of the page, figures included."""
    errors = {
        c.name: result.recording[c.name].to_numpy() - result.simulated[c.name].to_numpy() for c in result.channels
    }
    return page_text(
        "tirefmu.fmu.comparison", {"number": lambda value: f"{value:.4g}", "unit": drawn_unit, "per_si": per_si},
        result=result, figures=check_figures(result),
        reasons=_reasons(result), limit=EVALUATION_TOLERANCE, inputs=list(result.channels[0].worst.condition),
        residuals=residuals_over_inputs(result.recording, errors, "iso"),
        origin=provenance([Recording(result.recording, "iso", result.source)], command),
    )  # fmt: skip


def _reasons(result: Compared) -> list[str]:
    """Return why a check failed."""
    reasons = [f"The FMU is invalid: {problem}" for problem in result.problems]
    difference = result.evaluation_difference
    if difference is not None and not difference <= EVALUATION_TOLERANCE:
        reasons.append(f"The FMU differs from direct evaluation of its tire by {difference:.1e}.")
    for channel in result.beyond_tolerance:
        share = f"{channel.relative_rmse:.2%} of its largest value, more than {result.tolerance:.2%}"
        reasons.append(f"The error of {channel.name} is {share}.")
    return reasons
