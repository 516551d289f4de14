"""Residuals over each input: points and the mean with its scatter, which is flat for an adequate tire."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from .figure import Figure, Panel, Series
from .labels import axis_label, note, per_si
from .style import BLUE, LIGHT_GRAY, some_of

FloatArray = npt.NDArray[np.float64]

#: Inputs in the order of the columns of panels.
INPUTS = ("alpha", "kappa", "Fz", "gamma", "p", "V", "T")
#: Smallest range of an input as a share of its magnitude: the noise of a held load or pressure gives no panel.
MIN_RANGE = 0.02
#: Bins of a panel with equal numbers of rows, and the smallest number of rows of a bin.
BINS, MIN_ROWS = 16, 5
#: Points of a panel.
POINTS = 400


def residuals_over_inputs(
    table: pd.DataFrame, residuals: Mapping[str, FloatArray], signs: str, *notes: str
) -> Figure | None:
    """Return residuals over every input that varies: a row of panels per channel, a column per input.

    A panel is omitted if the input does not vary in the rows in which the channel is measured, or is unknown there.

    `table`: inputs. `residuals`, shape (n,): measured minus computed per channel; NaN if not measured. `signs`:
    convention of table and residuals. `*notes`: further parts of the note. Returns: none if no input varies or nothing
    was measured.

    >>> table = pd.DataFrame({"alpha": np.linspace(-0.1, 0.1, 50), "Fz": 900.0})
    >>> figure = residuals_over_inputs(table, {"Fy": np.sin(40.0 * table["alpha"].to_numpy())}, "iso")
    >>> [panel.x for panel in figure.panels]
    ['α (deg)']
    """
    shown = {
        channel: [name for name in INPUTS if name in table and _varies(table[name][np.isfinite(values)])]
        for channel, values in residuals.items()
    }
    shown = {channel: names for channel, names in shown.items() if names}
    inputs = [name for name in INPUTS if any(name in names for names in shown.values())]
    if not inputs:
        return None
    rows = tuple(
        tuple(_panel(table[name], residuals[channel], channel, signs) if name in names else None for name in inputs)
        for channel, names in shown.items()
    )
    text = "line: mean of rows with similar input; bars: their standard deviation; the axes contain 99.5 % of the rows"
    return Figure(
        "residuals_over_inputs", "Residuals over the inputs: data minus tire", rows, note(signs, text, *notes)
    )


def _varies(column: pd.Series) -> bool:
    measured = column.dropna().to_numpy(dtype=np.float64)
    return bool(len(measured) and np.ptp(measured) > MIN_RANGE * np.abs(measured).max())


def _panel(column: pd.Series, residual: FloatArray, channel: str, signs: str) -> Panel:
    name = str(column.name)
    x = column.to_numpy(dtype=np.float64) * per_si(name)
    limit = 1.15 * float(np.nanquantile(np.abs(residual), 0.995)) or 1.0
    measured = np.isfinite(residual) & np.isfinite(x)
    few = some_of(pd.DataFrame({"x": x[measured], "y": residual[measured]}), POINTS)
    series = [Series("points", few["x"], few["y"], LIGHT_GRAY, marker="o", size=1.5)]
    parts = [(x[rows], residual[rows]) for rows in bins(x, measured)]
    if parts:
        center, mean, spread = np.transpose([(np.median(a), b.mean(), b.std()) for a, b in parts])
        gap = np.full(len(parts), np.nan)
        bars = np.column_stack([center, center, gap]), np.column_stack([mean - spread, mean + spread, gap])
        series.append(Series("line", bars[0].ravel(), bars[1].ravel(), BLUE, size=0.8))
        series.append(Series("line", center, mean, BLUE, marker="o"))
    return Panel(
        axis_label(name, signs), axis_label(channel), tuple(series), across=(0.0,), y_limits=(-limit, limit),
        x_axis=name, y_axis=channel, width=2.7, height=2.1,
    )  # fmt: skip


def bins(x: FloatArray, measured: npt.NDArray[np.bool_]) -> Sequence[npt.NDArray[np.intp]]:
    """Return the rows of bins with about equal numbers of rows; rows with nearly equal input share one."""
    edges = np.unique(np.quantile(x[measured], np.linspace(0.0, 1.0, BINS + 1)))
    # The largest value also begins a bin: otherwise the two highest levels of a held input would share one.
    number = np.searchsorted(edges, x, side="right")
    parts: list[npt.NDArray[np.intp]] = []
    for rows in (np.flatnonzero(measured & (number == i)) for i in range(1, len(edges) + 1)):
        if len(parts) and len(rows) and np.median(x[rows]) - np.median(x[parts[-1]]) <= MIN_RANGE * np.ptp(edges):
            parts[-1] = np.concatenate([parts[-1], rows])
        elif len(rows):
            parts.append(rows)
    return [rows for rows in parts if len(rows) >= MIN_ROWS]
