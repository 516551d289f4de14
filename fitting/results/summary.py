"""Summary of a fit in a few lines, for ``repr`` and notebooks."""

from __future__ import annotations

from ...boundary.escaping import excerpt, visible
from ...tires.notebook import html_details, html_summary, html_table
from .fitted import Fitted
from .verdict import Verdict

#: Longest name of a recording, in characters, and largest number of channels that are listed.
LONGEST_NAME, MAX_CHANNELS = 40, 12


def fit_text(result: Fitted, verdict: Verdict) -> str:
    """Return status and goodness of fit in a few lines."""
    effects = len(result.tire.has)
    name = f" {excerpt(result.tire.name, LONGEST_NAME)!r}" if result.tire.name else ""
    recipe = visible(result.run.recipe)
    lines = [
        f"FitResult{name}: {result.tire.model} with {effects} effects, recipe {recipe}: {visible(result.status)}",
        f"  {verdict.word}{''.join(f'; {visible(reason)}' for reason in verdict.reasons[:1])}",
        f"  {len(result.coefficients)} coefficients fitted, in {result.signs} signs; {result.run.seconds:.1f} s",
    ]
    for c in result.channels[:MAX_CHANNELS]:
        source = excerpt(c.recording, LONGEST_NAME)
        lines.append(f"  {source} {c.channel}: RMSE {c.rmse:.4g} {c.unit}, R2 {c.r2:.4f}, {c.rows} rows")
    if len(result.channels) > MAX_CHANNELS:
        lines.append(f"  and {len(result.channels) - MAX_CHANNELS} more channels")
    for title, names in (
        ("at a bound", [c.name for c in result.coefficients if c.at_bound]),
        ("without influence on the data", [c.name for c in result.coefficients if not c.determined]),
    ):
        if names:
            lines.append(f"  {title}: {', '.join(names[:8])}{' ...' if len(names) > 8 else ''}")
    return "\n".join(lines)


def fit_html(result: Fitted, verdict: Verdict) -> str:
    """Return the same as HTML, with the coefficients."""
    header = ["coefficient", "value", "+- (95 %)", "lower", "upper", "unit", "stage"]
    rows = [(c.name, c.value, c.interval, c.lower, c.upper, c.unit, c.stage) for c in result.coefficients]
    table = html_details(f"Coefficients ({result.signs} signs)", html_table(header, rows))
    return html_summary(fit_text(result, verdict), table)
