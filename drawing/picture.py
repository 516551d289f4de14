"""Figures drawn by matplotlib: files, notebooks, and the picture that a page shows in print and without scripts."""

from __future__ import annotations

import textwrap
import warnings
from base64 import b64encode
from collections.abc import Sequence
from html import escape
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ..boundary.bounded_file import write_whole
from .figure import Cells, Figure, Panel, Series
from .own_matplotlib import (
    Axes,
    FigureCanvasAgg,
    MatplotlibFigure,
    Normal,
    Normalize,
    ScalarMappable,
    Stroke,
    colormaps,
    own_settings,
)

DPI = 120
#: Of the picture of a page.
PAGE_DPI = 90
#: Sizes of texts in points, readable where a page shows a figure of two panels a third smaller than drawn.
NAME_SIZE, TITLE_SIZE, NOTE_SIZE = 10.0, 10.5, 9.0
#: Most parts of an x axis per inch, so that numbers of five digits do not touch.
TICKS = 1.2


@own_settings()
def picture(figure: Figure) -> MatplotlibFigure:
    """Return a figure drawn by matplotlib.

    >>> force = Panel("α (deg)", "Fy (N)", (Series("line", [0.0, 1.0], [0.0, 5.0], label="tire"),))
    >>> [ax.get_ylabel() for ax in picture(Figure("force", "Side force", ((force,),))).axes]
    ['Fy (N)']
    """
    full = [row for row in figure.rows if len(row) == max(map(len, figure.rows))]
    widths = [max(panel.width for panel in column if panel) for column in zip(*full, strict=True)]
    heights = [max(panel.height for panel in row if panel) for row in figure.rows]
    made = MatplotlibFigure(figsize=(sum(widths) + 1.0, sum(heights) + 0.9), layout="constrained")
    made.suptitle(figure.title, fontweight="bold", parse_math=False)
    grid = made.add_gridspec(len(heights), len(widths), width_ratios=widths, height_ratios=heights)
    for i, row in enumerate(figure.rows):
        for j, panel in enumerate(row):
            if panel:
                ax = made.add_subplot(grid[i, :] if len(row) == 1 else grid[i, j])
                _draw(ax, panel, figure)
    write_note(made, figure.note)
    return made


def write_note(figure: MatplotlibFigure, note: str) -> None:
    """Write the note below the axes."""
    lines = textwrap.wrap(note, int(14 * figure.get_figwidth()))
    figure.supxlabel("\n".join(lines), x=0.01, ha="left", fontsize=NOTE_SIZE, color="0.3", parse_math=False)


def png(figure: Figure, dpi: float) -> bytes:
    """Return a figure as PNG."""
    made = picture(figure)
    FigureCanvasAgg(made)
    return rendered(made, "png", dpi)


def html_image(figure: Figure) -> str:
    """Return a figure as an image in HTML, for a notebook."""
    image = b64encode(png(figure, PAGE_DPI)).decode("ascii")
    return f'<img alt="{escape(figure.title)}" src="data:image/png;base64,{image}">'


@own_settings()
def rendered(figure: MatplotlibFigure, suffix: str, dpi: float, **options: Any) -> bytes:
    """Return a drawn figure as a file's bytes; a letter that the font lacks is drawn as a box, without a warning.

    Axes are placed before: to place them, `savefig` would draw the whole figure again.
    """
    buffer = BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font", category=UserWarning)
        if engine := figure.get_layout_engine():
            figure.set_dpi(dpi)
            engine.execute(figure)
            figure.set_layout_engine(None)
        figure.savefig(buffer, format=suffix, dpi=dpi, **options)
    return buffer.getvalue()


def write_figures(figures: Sequence[Figure], folder: Path, prefix: str = "") -> list[Path]:
    """Write figures as PNG files; all are drawn before the first is written.

    `folder`: created if it does not exist. `prefix`: of the file names. Raises `OSError` if a file cannot be written.
    """
    images = [(folder / f"{prefix}{figure.name}.png", png(figure, DPI)) for figure in figures]
    folder.mkdir(parents=True, exist_ok=True)
    return [write_whole(path, image) for path, image in images]


def _draw(ax: Axes, panel: Panel, figure: Figure) -> None:
    if panel.cells:
        _draw_cells(ax, panel.cells)
    rimmed = any(drawn.kind == "points" for drawn in panel.series)
    for series in panel.series:
        if series.kind != "band" or figure.bands:
            _draw_series(ax, series, rimmed)
    for y in panel.across:
        ax.axhline(y, color="0.3", lw=0.8, zorder=1)
    for x in panel.upright:
        ax.axvline(x, color="0.3", lw=0.8, zorder=1)
    if not panel.cells:
        ax.grid(alpha=0.3)
    ax.set_title(panel.title, fontsize=TITLE_SIZE, parse_math=False)
    ax.set_xlabel(panel.x, parse_math=False)
    ax.set_ylabel(panel.y, parse_math=False)
    x_limits, y_limits = figure.limits(panel)
    ax.set(xlim=x_limits, ylim=y_limits)
    ax.locator_params(axis="x", nbins=max(4, int(TICKS * panel.width)))
    if panel.equal:
        ax.set_aspect("equal", adjustable="datalim")
        ax.set_autoscale_on(True)  # a fixed limit would be reported as ignored
    for label, color, height in figure.names(panel):
        at: dict[str, Any] = {
            "xy": (1.0, height),
            "xytext": (4.0, 0.0),
            "xycoords": "axes fraction",
            "textcoords": "offset points",
        }
        ax.annotate(label, **at, va="center", fontsize=NAME_SIZE, color=color, parse_math=False)


def _draw_series(ax: Axes, series: Series, rimmed: bool) -> None:
    x, y = series.points
    if series.kind in ("area", "band"):
        ax.fill(x, y, color=series.color, alpha=series.opacity, lw=0.0)
        return
    hollow = series.marker == "ring"
    look: dict[str, Any] = {
        "color": series.color, "alpha": series.opacity, "marker": "o" if series.marker else "",
        "mew": 1.0 if hollow else 0.0, "mfc": "none" if hollow else series.color,
    }  # fmt: skip
    if series.kind == "points":
        ax.plot(x, y, ls="", ms=series.size, zorder=1.5, **look)
        return
    dashes = (0.0, series.dashes) if series.dashes else "-"
    # A white rim keeps a line readable on points of its own color.
    rim = [Stroke(linewidth=series.size + 0.9, foreground="white"), Normal()] if rimmed else []
    ax.plot(x, y, ls=dashes, lw=series.size, ms=4.0, zorder=3, path_effects=rim, **look)


def _draw_cells(ax: Axes, cells: Cells) -> None:
    """Draw a map, the number of rows in each cell, and its color bar."""
    norm, colors = Normalize(-cells.limit, cells.limit), colormaps["RdBu_r"]
    ax.set_facecolor("0.85")
    ax.pcolormesh(cells.x, cells.y, np.ma.masked_invalid(cells.means.T), cmap=colors, norm=norm, ec="white", lw=0.3)
    for i, j in np.argwhere(cells.counts > 0) if cells.numbered else ():
        dark = abs(cells.means[i, j]) > 0.6 * cells.limit
        middle = 0.5 * (cells.x[i] + cells.x[i + 1]), 0.5 * (cells.y[j] + cells.y[j + 1])
        text = str(cells.counts[i, j])
        ax.text(*middle, text, ha="center", va="center", fontsize=7.0, color="w" if dark else "k")
    bar = ax.figure.colorbar(ScalarMappable(norm, colors), ax=ax, extend="both", pad=0.01)
    bar.set_label(cells.label, parse_math=False)
