"""Texts and table cells of a fit that the terminal and the HTML report have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, isinf

from ..checks.consistency import Disagreement
from ..checks.residuals import condition_text
from ..checks.ripple import Ripple
from ..constraints.physical import REACH
from ..constraints.verification import Margin
from ..results.fitted import Fitted
from ..results.records import Bootstrap

#: Number of standard deviations above which a difference within the data is reported.
SIGNIFICANT = 4.0
#: How the table of constraints has its signs: those of the constraints, whatever the convention of the other tables.
CONSTRAINT_SIGNS = "Slip stiffness is positive here, as in the constraints; all else has one sign in all conventions."


@dataclass(frozen=True)
class ConstraintRow:
    """A constraint with its margin in the operating range and in the extrapolated range."""

    constraint: str
    inside: Margin
    beyond: Margin | None


def interval_text(half: float) -> str:
    """Return half an interval: "not identifiable" if it is infinite, empty if there is none.

    >>> interval_text(0.01234), interval_text(float("inf")), interval_text(float("nan"))
    ('0.0123', 'not identifiable', '')
    """
    return "not identifiable" if isinf(half) else f"{half:.3g}" if isfinite(half) else ""


def bootstrap_text(result: Fitted, name: str) -> str:
    """Return the percentile interval of a coefficient; empty if it has none."""
    interval = result.bootstrap.interval(name) if result.bootstrap else None
    return f"{interval.lower:.5g} to {interval.upper:.5g}" if interval and isfinite(interval.lower) else ""


def bootstrap_summary(bootstrap: Bootstrap) -> str:
    """Return how the percentile intervals were computed, in one sentence."""
    failed = f"; {bootstrap.failed} more did not converge" if bootstrap.failed else ""
    return (
        f"bootstrap: percentiles 2.5 and 97.5 of {bootstrap.replicates} fits with random weights of "
        f"{bootstrap.sweeps} sweeps, expanded for sweeps that the fit follows, seed {bootstrap.seed}{failed}"
    )


def worst_text(result: Fitted, recording: str, channel: str) -> str:
    """Return the largest error of a channel and its operating condition; empty for a single operating condition."""
    worst = result.findings.worst(recording, channel)
    unit = next((c.unit for c in result.channels if (c.recording, c.channel) == (recording, channel)), "")
    return f"{worst.rmse:.3g} {unit} at {condition_text(worst.at)}" if worst else ""


def constraint_rows(margins: Sequence[Margin]) -> list[ConstraintRow]:
    """Return each constraint with its margins in the range of the data and beyond it."""
    beyond = {margin.name.partition(":")[2]: margin for margin in margins if margin.name.startswith("extrapolation:")}
    lines = []
    for margin in margins:
        kind, _, quantity = margin.name.partition(":")
        if kind in ("signs", "curvature"):
            lines.append(ConstraintRow(margin.constraint, margin, beyond.pop(quantity, None)))
        elif kind != "extrapolation":
            lines.append(ConstraintRow(margin.constraint, margin, None))
    return lines + [ConstraintRow(margin.constraint, margin, None) for margin in beyond.values()]


def extrapolation_text(result: Fitted) -> str:
    """Return the extrapolated range in which constraints are enforced, or that there is none."""
    far = [margin.at for margin in result.margins if margin.name.startswith("extrapolation:")]
    if not far:
        return "constraints are not enforced outside the measured range (--constraint extrapolation)"
    loads = f"loads from 1/{REACH:g} to {REACH:g} times the measured range"
    return f"extrapolated range: slips up to {REACH:g} times, {loads}"


def significant_differences(result: Fitted) -> list[Disagreement]:
    """Return the significant differences within the data: between files, then sweeps, then segments."""
    findings = result.findings
    return [
        difference
        for difference in (*findings.files, *findings.sweeps, *findings.segments)
        if abs(difference.sigmas) >= SIGNIFICANT
    ]


def ripple_texts(ripples: Sequence[Ripple]) -> list[str]:
    """Return a sentence on significant ripple for each recording."""
    lines = []
    for recording in dict.fromkeys(ripple.recording for ripple in ripples):
        distinct = [ripple for ripple in ripples if ripple.recording == recording and ripple.stands_out]
        if distinct:
            channels = ", ".join(
                f"{ripple.channel} {ripple.amplitude:.3g} {ripple.unit} ({ripple.share:.0%})" for ripple in distinct
            )
            wheel = f"{distinct[0].frequency:.1f} Hz, radius {distinct[0].radius:.3f} m"
            lines.append(f"{recording}: once per revolution ({wheel}): {channels}")
    return lines
