"""Summary of a recording in a few lines, for ``repr`` and notebooks."""

from __future__ import annotations

import pandas as pd

from tirefmu.boundary.escaping import excerpt
from tirefmu.tires.notebook import html_summary, html_table

from .channels import CHANNELS

#: Characters, the longest source that a summary shows; longer ones are shortened.
LONGEST_SOURCE = 80


def recording_text(source: str, signs: str, table: pd.DataFrame) -> str:
    """Return source, rows, signs and the range of each channel, in a few lines.

    >>> print(recording_text("run.csv", "iso", pd.DataFrame({"alpha": [-0.1, 0.1], "Fz": 900.0})))
    Recording 'run.csv': 2 rows, iso signs
      alpha -0.1 to 0.1 rad, Fz 900 to 900 N
    """
    ranges = [f"{name} {low:.4g} to {high:.4g} {unit}".rstrip(" -") for name, low, high, unit in _ranges(table)]
    lines = [_title(source, signs, table), *(f"  {', '.join(ranges[i : i + 4])}" for i in range(0, len(ranges), 4))]
    return "\n".join(lines)


def recording_html(source: str, signs: str, table: pd.DataFrame) -> str:
    """Return the same as HTML."""
    return html_summary(_title(source, signs, table), html_table(["channel", "from", "to", "unit"], _ranges(table)))


def _title(source: str, signs: str, table: pd.DataFrame) -> str:
    return f"Recording {excerpt(source, LONGEST_SOURCE)!r}: {len(table)} rows, {signs} signs"


def _ranges(table: pd.DataFrame) -> list[tuple[str, float, float, str]]:
    """Return name, smallest and largest value and unit of each channel that has numbers."""
    found = []
    for name, channel in CHANNELS.items():
        if name in table:
            values = pd.to_numeric(table[name], errors="coerce")
            if values.notna().any():
                found.append((name, float(values.min()), float(values.max()), channel.unit))
    return found
