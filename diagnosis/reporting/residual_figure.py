"""Figure of a channel's residuals: maps over pairs of inputs with sample counts, before and after, and over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...drawing.figure import Cells, Figure, Panel, Series
from ...drawing.labels import axis_label, per_si
from ...drawing.style import BLUE, DASHED, RED, SOLID
from ...numerics.arrays import FloatArray
from ..verdict.residual_location import MIN_ROWS_OF_CELL
from ..verdict.result import Diagnosis

#: Mean residual at the ends of the color scale, in noise standard deviations.
FULL = 3.0
MEAN = "mean residual in noise standard deviations"
#: Distance of two lines, as a share of the range of their panel, that is seen. A line is 0.7 % wide. Convention.
VISIBLE = 0.02


def coincide(first: FloatArray, second: FloatArray, *drawn: FloatArray) -> bool:
    """Return whether two lines are one in a panel with them and other points; they may have NaN in the same rows.

    >>> x = np.linspace(0.0, 100.0, 50)
    >>> coincide(x, x + 1.0), coincide(x, x + 5.0), coincide(x, x + 5.0, 10.0 * x)
    (True, False, True)
    """
    shown = np.concatenate([first, second, *drawn])
    both = np.isfinite(first) & np.isfinite(second)
    if not both.any():
        return True
    return bool(np.abs(first - second)[both].max() <= VISIBLE * (np.nanmax(shown) - np.nanmin(shown)))


def residual_location_figure(diagnosis: Diagnosis, channel: str) -> Figure:
    """Return the maps of one channel for the baseline model and the improved model, and its misfit over time.

    Where the misfit of both models over time is the same, both are drawn once.
    """
    course = diagnosis.time_course[channel]
    before, after = (
        [shown for shown in maps if shown["channel"] == channel] for maps in (diagnosis.where, diagnosis.where_after)
    )
    misfits = [np.asarray(course[name], dtype=np.float64) for name in ("before", "after")]
    models = [("baseline model", before, "before", RED, DASHED), ("improved model", after, "after", BLUE, SOLID)]
    if coincide(*misfits, np.zeros(1)):
        models = [("baseline model", before, "misfit", RED, SOLID)]
    maps = [tuple(_map_panel(title, shown) for shown in maps_of_model) for title, maps_of_model, *_ in models]
    t = np.asarray(course["t"], dtype=np.float64)
    lines = [
        Series("line", np.repeat(t, 2)[1:], np.repeat(values, 2)[:-1], color, label, dashes)
        for (*_, label, color, dashes), values in zip(models, misfits, strict=False)
    ]
    over_time = Panel("t (s)", "RMS over noise", tuple(lines), across=(1.0,), y_limits=(0.0, None), height=1.8)
    note = f"numbers: rows in the cell; blue below 0, red above, darkest at {FULL:g} noise standard deviations"
    return Figure(f"residuals_{channel}", f"Residuals of {channel}", (*maps, (over_time,)), note)


def _map_panel(title: str, shown: Mapping[str, Any]) -> Panel:
    x, y = (np.asarray(edges) * per_si(name) for name, edges in zip(shown["over"], shown["edges"], strict=True))
    means = np.array([[np.nan if cell is None else cell for cell in row] for row in shown["mean"]], dtype=np.float64)
    counts = np.asarray(shown["count"])
    means = np.where(counts >= MIN_ROWS_OF_CELL, means, np.nan)
    first, second = map(axis_label, shown["over"])
    return Panel(
        first, second, title=f"{title}: largest mean {shown['worst']['mean']:+.1f}",
        x_limits=(x[0], x[-1]), y_limits=(y[0], y[-1]), cells=Cells(x, y, means, counts, True, FULL, MEAN),
        width=4.2, height=3.0,
    )  # fmt: skip
