"""Figure of a channel's residuals: maps over pairs of inputs with sample counts, before and after, and over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tirefmu.tires.drawing.own_matplotlib import Axes, Figure, Normalize, ScalarMappable, colormaps, own_settings
from tirefmu.tires.drawing.style import LEGEND_SIZE, LETTER, TITLE_SIZE, drawn_unit, per_si, png, write_whole

from ..thresholds import MIN_ROWS_OF_CELL
from .curves_figure import coincide

#: Mean residual at the ends of the color scale, in noise standard deviations.
FULL = 3.0


@own_settings()
def draw_residual_location(
    before: Sequence[Mapping[str, Any]], after: Sequence[Mapping[str, Any]], course: Mapping[str, Any], path: str | Path
) -> Path:
    """Draw the maps of one channel for the baseline model and the improved model, and its misfit over time.

    Where the misfit of both models over time is the same, both are drawn once.

    Parameters
    ----------
    before, after : sequence of mapping
        Results of `residual_location.residual_maps` for one channel, over the same pairs.
    course : mapping
        Result of `residual_location.time_course` for the channel.
    path : str or Path
        PNG file; written completely or not at all.

    Returns
    -------
    Path
    """
    norm, colors = Normalize(-FULL, FULL), colormaps["RdBu_r"]
    misfits = [np.asarray(course[name], dtype=np.float64) for name in ("before", "after")]
    rows = [("baseline model", before, "before", "C3", "--"), ("improved model", after, "after", "C0", "-")]
    if coincide(*misfits, np.zeros(1)):
        rows = [("both models", before, "before and after", "C3", "--")]
    figure = Figure(figsize=(3.6 * max(len(before), 2), 2.2 + 3.0 * len(rows)), layout="constrained")
    grid = figure.add_gridspec(len(rows) + 1, len(before), height_ratios=(*(1.0 for _ in rows), 0.6))
    axes = [[figure.add_subplot(grid[i, j]) for j in range(len(before))] for i in range(len(rows))]
    for row, (title, maps, *_) in zip(axes, rows, strict=True):
        for ax, shown in zip(row, maps, strict=True):
            _draw_map(ax, shown, norm)
            ax.set_title(f"{title}: largest mean {shown['worst']['mean']:+.1f}", fontsize=TITLE_SIZE)
    flat = [ax for row in axes for ax in row]
    label = "mean residual in noise standard deviations"
    figure.colorbar(ScalarMappable(norm, colors), ax=flat, label=label, extend="both", pad=0.01)
    ax = figure.add_subplot(grid[-1, :])
    for (*_, name, color, dashes), values in zip(rows, misfits, strict=False):
        ax.step(course["t"], values, color=color, ls=dashes, where="post", label=name)
    ax.axhline(1.0, color="0.6", lw=0.8)
    ax.set(xlabel="t (s)", ylabel="RMS over noise", ylim=(0.0, None))
    ax.legend(fontsize=LEGEND_SIZE)
    return write_whole(Path(path), png(figure))


def _draw_map(ax: Axes, shown: Mapping[str, Any], norm: Normalize) -> None:
    x, y = (np.asarray(edges) * _scale(name) for name, edges in zip(shown["over"], shown["edges"], strict=True))
    mean = np.array([[np.nan if cell is None else cell for cell in row] for row in shown["mean"]], dtype=np.float64)
    count = np.asarray(shown["count"])
    ax.set_facecolor("0.85")
    shaded = np.ma.masked_invalid(np.where(count >= MIN_ROWS_OF_CELL, mean, np.nan).T)
    ax.pcolormesh(x, y, shaded, cmap=colormaps["RdBu_r"], norm=norm, ec="white", lw=0.3)
    for i, j in np.argwhere(count > 0):
        dark = count[i, j] >= MIN_ROWS_OF_CELL and abs(mean[i, j]) > 0.6 * FULL
        middle = 0.5 * (x[i] + x[i + 1]), 0.5 * (y[j] + y[j + 1])
        ax.text(*middle, str(count[i, j]), ha="center", va="center", fontsize=7.5, color="w" if dark else "k")
    ax.set(**{f"{side}label": _label(name) for side, name in zip("xy", shown["over"], strict=True)})
    ax.ticklabel_format(useOffset=False)
    ax.tick_params(labelsize=9)


def _scale(name: str) -> float:
    return 1.0 if name == "distance" else per_si(name)


def _label(name: str) -> str:
    return "distance (m)" if name == "distance" else f"{LETTER.get(name, name)} ({drawn_unit(name)})"
