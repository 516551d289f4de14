"""What the footnotes of figures of a fit have in common: bands, recordings, pressures."""

from __future__ import annotations

import pandas as pd

from tirefmu.measurements import levels
from tirefmu.symbolic.escaping import figure_text

from ..evidence.curves import Comparison

#: Recordings listed below a figure.
MOST_SOURCES = 30
BANDS = "; bands: 95 % confidence intervals under noise that is correlated in time"


def data_text(comparison: Comparison, rows: pd.DataFrame) -> str:
    """Return the recordings of the rows and their inflation pressures as a text."""
    numbers = sorted(set(rows["recording"].tolist()))
    sources = [figure_text(name) for name in dict.fromkeys(comparison.sources[number] for number in numbers)]
    text = f"data: {', '.join(sources[:MOST_SOURCES])}"
    if len(sources) > MOST_SOURCES:
        text += f" and {len(sources) - MOST_SOURCES} more"
    if "p" not in rows or rows["p"].isna().all():
        return text
    held = [f"{level / 1000.0:.0f}" for level in levels(rows["p"])]
    span = " to ".join(f"{value / 1000.0:.0f}" for value in (rows["p"].min(), rows["p"].max()))
    return f"{text}; inflation pressure {', '.join(held) or span} kPa"
