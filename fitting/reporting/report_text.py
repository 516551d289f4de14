"""A fit in words: short sentences and cells that the terminal and the HTML report share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, isinf

from ..constraints.physical import REACH
from ..constraints.verification import Margin
from ..evidence.consistency import Disagreement
from ..evidence.residuals import condition_text
from ..evidence.ripple import Ripple
from ..results.fit_result import FitResult

#: A difference within the data is told where it is this many standard deviations.
SIGNIFICANT = 4.0


@dataclass(frozen=True)
class ConstraintRow:
    """A constraint in words, in the operating range and beyond it."""

    constraint: str
    inside: Margin
    beyond: Margin | None


def interval_text(half: float) -> str:
    """Return half an interval: "open" where the data hold nothing, empty where there is none.

    Examples
    --------
    >>> interval_text(0.01234), interval_text(float("inf")), interval_text(float("nan"))
    ('0.0123', 'open', '')
    """
    return "open" if isinf(half) else f"{half:.3g}" if isfinite(half) else ""


def worst_text(result: FitResult, recording: str, channel: str) -> str:
    """Return where a channel of a recording is missed most, and by how much; empty without several conditions."""
    worst = result.findings.worst(recording, channel)
    return f"{worst.rmse:.3g} at {condition_text(worst.at)}" if worst else ""


def constraint_rows(margins: Sequence[Margin]) -> list[ConstraintRow]:
    """Put what holds inside the range of the data and what holds beyond it side by side."""
    beyond = {margin.name.partition(":")[2]: margin for margin in margins if margin.name.startswith("extrapolation:")}
    lines = []
    for margin in margins:
        kind, _, quantity = margin.name.partition(":")
        if kind in ("signs", "curvature"):
            lines.append(ConstraintRow(margin.constraint, margin, beyond.pop(quantity, None)))
        elif kind != "extrapolation":
            lines.append(ConstraintRow(margin.constraint, margin, None))
    return lines + [ConstraintRow(margin.constraint, margin, None) for margin in beyond.values()]


def extrapolation_text(result: FitResult) -> str:
    """Say how far the extrapolation goes; or that nothing is kept there."""
    far = [margin.at for margin in result.margins if margin.name.startswith("extrapolation:")]
    if not far:
        return "nothing is kept beyond the data (--constraint extrapolation)"
    return f"beyond: slips {REACH:g} times as far as the data, loads {REACH:g} times as high and as low"


def significant_differences(result: FitResult) -> list[Disagreement]:
    """Return the differences within the data that are more than noise: files, then sweeps, then segments."""
    found = result.findings
    return [each for each in (*found.files, *found.sweeps, *found.segments) if abs(each.sigmas) >= SIGNIFICANT]


def ripple_texts(ripples: Sequence[Ripple]) -> list[str]:
    """Say what repeats with the wheel, one sentence for each recording."""
    lines = []
    for recording in dict.fromkeys(each.recording for each in ripples):
        distinct = [each for each in ripples if each.recording == recording and each.stands_out]
        if distinct:
            what = ", ".join(f"{each.channel} {each.amplitude:.3g} {each.unit} ({each.share:.0%})" for each in distinct)
            wheel = f"{distinct[0].frequency:.1f} Hz, radius {distinct[0].radius:.3f} m"
            lines.append(f"{recording}: once per revolution ({wheel}): {what}")
    return lines
