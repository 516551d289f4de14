"""Summary of a diagnosis in a few lines, for ``repr`` and notebooks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ...boundary.escaping import visible
from ...drawing.labels import drawn_unit
from ...tires.notebook import html_details, html_summary, html_table
from ..explanations.answer import percent

if TYPE_CHECKING:
    from .result import Diagnosis


def before_and_after(channel: str, error: Mapping[str, float]) -> str:
    """Return the error of a channel before and after, with its unit.

    >>> before_and_after("Fy", {"before": 66.17, "after": 30.45})
    'RMSE 66.17 N before, 30.45 N after'
    """
    unit = drawn_unit(channel)
    return f"RMSE {error['before']:.4g} {unit} before, {error['after']:.4g} {unit} after"


def diagnosis_text(diagnosis: Diagnosis) -> str:
    """Return the verdict, the findings with their evidence, and the hold-out error before and after."""
    lines = [f"Diagnosis: {diagnosis.headline}", *(f"  {sentence}" for sentence in diagnosis.sentences)]
    for finding in diagnosis.found:
        values = ", ".join(f"{name} {interval.value:.4g}" for name, interval in finding.coefficients.items())
        sure = percent(finding.probability)
        channels = ", ".join(finding.channels)
        lines.append(f"  {finding.effect} in {channels}: probability {sure}{'; ' * bool(values)}{values}")
    for channel, error in diagnosis.gap["holdout"].items():
        lines.append(f"  {channel} on the hold-out set: {before_and_after(channel, error)}")
    lines.append(f"  {len(diagnosis.rows)} rows; coefficients in {diagnosis.signs} signs")
    return "\n".join(visible(line) for line in lines)


def diagnosis_html(diagnosis: Diagnosis) -> str:
    """Return the summary as HTML, with the coefficients of the findings."""
    rows = [
        (finding.effect, name, interval.value, interval.lower, interval.upper)
        for finding in diagnosis.found
        for name, interval in finding.coefficients.items()
    ]
    header = ["effect", "coefficient", "value", "lower (95 %)", "upper (95 %)"]
    table = html_details(f"Coefficients ({diagnosis.signs} signs)", html_table(header, rows))
    return html_summary(diagnosis_text(diagnosis), table if rows else "")
