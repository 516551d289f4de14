"""A diagnosis in a few lines, as ``repr`` and notebooks show it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tirefmu.symbolic.escaping import visible
from tirefmu.tires.notebook import html_details, html_summary, html_table

if TYPE_CHECKING:
    from .result import Diagnosis


def diagnosis_text(diagnosis: Diagnosis) -> str:
    """Return the verdict, findings with their evidence, and how the gap shrank, in a few lines."""
    lines = [f"Diagnosis: {diagnosis.verdict}"]
    for one in diagnosis.found:
        values = ", ".join(f"{name} {interval.value:.4g}" for name, interval in one.coefficients.items())
        lines.append(f"  {one.effect} in {', '.join(one.channels)}: p {one.p:.2g}{'; ' * bool(values)}{values}")
    for channel, gap in diagnosis.gap["holdout"].items():
        lines.append(f"  {channel} on the hold-out: RMSE {gap['before']:.4g} before, {gap['after']:.4g} after")
    lines.append(f"  {len(diagnosis.rows)} rows; coefficients in {diagnosis.signs} signs")
    return "\n".join(visible(line) for line in lines)


def diagnosis_html(diagnosis: Diagnosis) -> str:
    """Return the same as HTML, with the coefficients of the findings."""
    rows = [
        (one.effect, name, interval.value, interval.lower, interval.upper)
        for one in diagnosis.found
        for name, interval in one.coefficients.items()
    ]
    header = ["effect", "coefficient", "value", "lower (95 %)", "upper (95 %)"]
    table = html_details(f"Coefficients ({diagnosis.signs} signs)", html_table(header, rows))
    return html_summary(diagnosis_text(diagnosis), table if rows else "")
