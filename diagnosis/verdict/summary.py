"""Summary of a diagnosis in a few lines, for ``repr`` and notebooks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...boundary.escaping import visible
from ...tires.notebook import html_details, html_summary, html_table
from ..explanations.answer import percent
from .findings import FoundEffect


def diagnosis_text(
    verdict: str, findings: Sequence[FoundEffect], holdout: Mapping[str, Mapping[str, float]], n_rows: int, signs: str
) -> str:
    """Return the verdict, the findings with their evidence, and the hold-out error before and after.

    `holdout`: by channel: root mean square on the hold-out ``before`` and ``after``, N and N m. `signs`: sign
    convention of the coefficients.
    """
    lines = [f"Diagnosis: {verdict}"]
    for finding in findings:
        values = ", ".join(f"{name} {interval.value:.4g}" for name, interval in finding.coefficients.items())
        sure = percent(finding.probability)
        channels = ", ".join(finding.channels)
        lines.append(f"  {finding.effect} in {channels}: probability {sure}{'; ' * bool(values)}{values}")
    for channel, error in holdout.items():
        lines.append(f"  {channel} on the hold-out set: RMSE {error['before']:.4g} before, {error['after']:.4g} after")
    lines.append(f"  {n_rows} rows; coefficients in {signs} signs")
    return "\n".join(visible(line) for line in lines)


def diagnosis_html(
    verdict: str, findings: Sequence[FoundEffect], holdout: Mapping[str, Mapping[str, float]], n_rows: int, signs: str
) -> str:
    """Return the summary as HTML, with the coefficients of the findings."""
    rows = [
        (finding.effect, name, interval.value, interval.lower, interval.upper)
        for finding in findings
        for name, interval in finding.coefficients.items()
    ]
    header = ["effect", "coefficient", "value", "lower (95 %)", "upper (95 %)"]
    table = html_details(f"Coefficients ({signs} signs)", html_table(header, rows))
    return html_summary(diagnosis_text(verdict, findings, holdout, n_rows, signs), table if rows else "")
