"""A recording in a few lines, as ``repr`` and notebooks show it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from tirefmu.symbolic.escaping import excerpt
from tirefmu.tires.notebook import html_summary, html_table

from .channels import CHANNELS

if TYPE_CHECKING:
    from .recording import Recording

#: The longest source that a summary shows, in characters.
LONGEST_SOURCE = 80


def recording_text(recording: Recording) -> str:
    """Return source, rows, signs and the range of each channel, in a few lines.

    Examples
    --------
    >>> from .recording import Recording
    >>> print(recording_text(Recording(pd.DataFrame({"alpha": [-0.1, 0.1], "Fz": 900.0}), "iso", "run.csv")))
    Recording 'run.csv': 2 rows, iso signs
      alpha -0.1 to 0.1 rad, Fz 900 to 900 N
    """
    ranges = [f"{name} {low:.4g} to {high:.4g} {unit}".rstrip(" -") for name, low, high, unit in _ranges(recording)]
    lines = [_title(recording), *(f"  {', '.join(ranges[i : i + 4])}" for i in range(0, len(ranges), 4))]
    return "\n".join(lines)


def recording_html(recording: Recording) -> str:
    """Return the same as HTML."""
    return html_summary(_title(recording), html_table(["channel", "from", "to", "unit"], _ranges(recording)))


def _title(recording: Recording) -> str:
    source = excerpt(recording.source, LONGEST_SOURCE)
    return f"Recording {source!r}: {len(recording)} rows, {recording.signs} signs"


def _ranges(recording: Recording) -> list[tuple[str, float, float, str]]:
    """Return name, smallest and largest value and unit of each channel that has numbers."""
    found = []
    for name, channel in CHANNELS.items():
        if name in recording.table:
            values = pd.to_numeric(recording.table[name], errors="coerce")
            if values.notna().any():
                found.append((name, float(values.min()), float(values.max()), channel.unit))
    return found
