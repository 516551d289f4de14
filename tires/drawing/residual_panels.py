"""Residuals over each input: points and the mean with its scatter, which is flat for an adequate tire."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from .own_matplotlib import Axes, Figure, own_settings
from .style import LETTER, drawn_unit, letter, per_si, some_of, write_footnote

FloatArray = npt.NDArray[np.float64]

#: Inputs in the order of the columns of panels.
INPUTS = ("alpha", "kappa", "Fz", "gamma", "p", "V", "T")
#: Smallest range of an input as a share of its magnitude: the noise of a held load or pressure gives no panel.
LEAST_RANGE = 0.02
#: Bins of a panel with equal numbers of rows, and the smallest number of rows of a bin.
BINS, LEAST_ROWS = 16, 5


@own_settings()
def residuals_over_inputs(
    table: pd.DataFrame, residuals: Mapping[str, FloatArray], signs: str, *notes: str
) -> Figure | None:
    """Draw residuals over every input that varies: a row of panels per channel, a column per input.

    A panel is omitted if the input does not vary in the rows in which the channel is measured, or is unknown there.

    Parameters
    ----------
    table : pandas.DataFrame
        Inputs.
    residuals : mapping of str to ndarray, shape (n,)
        Measured minus computed per channel; NaN if not measured.
    signs : str
        Convention of table and residuals.
    *notes : str
        Further sentences of the footnote.

    Returns
    -------
    Figure or None
        None if no input varies or nothing was measured.

    Examples
    --------
    >>> table = pd.DataFrame({"alpha": np.linspace(-0.1, 0.1, 50), "Fz": 900.0})
    >>> figure = residuals_over_inputs(table, {"Fy": np.sin(40.0 * table["alpha"].to_numpy())}, "iso")
    >>> len(figure.axes)
    1
    """
    shown = {
        channel: [name for name in INPUTS if name in table and _varies(table[name][np.isfinite(values)])]
        for channel, values in residuals.items()
    }
    shown = {channel: names for channel, names in shown.items() if names}
    inputs = [name for name in INPUTS if any(name in names for names in shown.values())]
    if not inputs:
        return None
    figure = Figure(figsize=(2.7 * len(inputs) + 1.0, 1.0 + 2.1 * len(shown)), layout="constrained")
    figure.suptitle("Residuals over the inputs: data minus tire", fontweight="bold")
    grid = figure.subplots(len(shown), len(inputs), squeeze=False, sharey="row", sharex="col")
    for axes, (channel, names) in zip(grid, shown.items(), strict=True):
        values = residuals[channel]
        limit = 1.15 * float(np.nanquantile(np.abs(values), 0.995)) or 1.0
        first = axes[inputs.index(names[0])]
        first.set(ylabel=f"{LETTER[channel]} ({drawn_unit(channel)})", ylim=(-limit, limit))
        first.tick_params(labelleft=True)
        for ax, name in zip(axes, inputs, strict=True):
            if name in names:
                _draw(ax, table[name].to_numpy(dtype=np.float64) * per_si(name), values)
            else:
                ax.remove()
    for column, name in zip(grid.T, inputs, strict=True):
        last = [ax for ax, names in zip(column, shown.values(), strict=True) if name in names][-1]
        last.set_xlabel(f"{letter(signs, name)} ({drawn_unit(name)})")
        last.tick_params(labelbottom=True)
    note = "line: mean of rows with similar input; bars: their standard deviation; the axes contain 99.5 % of the rows"
    write_footnote(figure, signs, note, *notes)
    return figure


def _varies(column: pd.Series) -> bool:
    known = column.dropna().to_numpy(dtype=np.float64)
    return bool(len(known) and np.ptp(known) > LEAST_RANGE * np.abs(known).max())


def _draw(ax: Axes, x: FloatArray, residual: FloatArray) -> None:
    known = np.isfinite(residual) & np.isfinite(x)
    few = some_of(pd.DataFrame({"x": x[known], "y": residual[known]}))
    ax.plot(few["x"], few["y"], ".", ms=1.5, mew=0.0, color="0.6")
    parts = [(x[rows], residual[rows]) for rows in _bins(x, known)]
    if parts:
        center, mean, spread = np.transpose([(np.median(a), b.mean(), b.std()) for a, b in parts])
        ax.errorbar(center, mean, spread, color="C0", lw=1.4, elinewidth=0.8, marker="o", ms=3, zorder=3)
    ax.axhline(0.0, color="k", lw=0.8)
    ax.grid(alpha=0.3)


def _bins(x: FloatArray, known: npt.NDArray[np.bool_]) -> Sequence[npt.NDArray[np.intp]]:
    """Return the rows of bins with about equal numbers of rows; rows with equal input share one."""
    edges = np.unique(np.quantile(x[known], np.linspace(0.0, 1.0, BINS + 1)))
    # The largest value begins a bin too: otherwise the two highest levels of a held input would share one.
    number = np.searchsorted(edges, x, side="right")
    found = [np.flatnonzero(known & (number == i)) for i in range(1, len(edges) + 1)]
    return [rows for rows in found if len(rows) >= LEAST_ROWS]
