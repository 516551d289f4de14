"""What the figures are made of: axes, points, lines, legends, footnotes, and the words and units on them."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Mapping, Sequence
from io import BytesIO
from math import ceil
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from .drawn_units import drawn_unit as drawn_unit
from .drawn_units import per_si as per_si
from .own_matplotlib import Axes, Figure, FigureCanvasAgg, Normal, Stroke, colormaps, own_settings

RGB = tuple[float, float, float]

DPI = 120
#: Sizes of texts in points, readable where a page shows a figure of two panels a third smaller than drawn.
LEGEND_SIZE, TITLE_SIZE, NOTE_SIZE = 10.0, 10.5, 9.0
#: Dashes and markers of successive levels: curves and points differ in more than their color.
DASHES = ("-", "--", "-.", ":", (0, (8.0, 1.2, 1.2, 1.2, 1.2, 1.2)))
MARKERS = ("o", "^", "s", "D", "v")
HANDLE = 3.2  # length of a legend's lines: every dash is seen
#: Smallest contrast of a level's color with the white page (WCAG 2.2, criterion 1.4.11).
CONTRAST = 3.0
SHOWN = 3000  # points of a group; more would only cover each other
LETTER = {"kappa": r"$\kappa$", "alpha": r"$\alpha$", "gamma": r"$\gamma$", "Fz": "$F_z$"}
LETTER |= {"t": "$t$", "p": "$p$", "V": "$V$", "T": "$T$", "phit": r"$\varphi_t$"}
LETTER |= {"Fx": "$F_x$", "Fy": "$F_y$", "Mz": "$M_z$", "Mx": "$M_x$", "My": "$M_y$"}
LEVEL = {"Fz": "load", "gamma": "camber", "p": "pressure", "V": "speed"}
LEVEL |= {"alpha": "slip angle", "kappa": "longitudinal slip"}
_CONVENTION = {
    "iso": r"ISO-W signs ($F_z$ > 0; $F_y$ < 0 at $\alpha$ > 0)",
    "adapted-sae": r"adapted SAE signs ($F_z$ > 0; $F_y$ > 0 at $\alpha$ > 0)",
    "sae": r"SAE signs ($F_z$ < 0; $F_y$ < 0 at $\alpha$ > 0)",
}


def stiffness_unit(slip: str) -> str:
    """Return the unit of a force's slope over a slip, as drawn."""
    return "N/deg" if drawn_unit(slip) == "deg" else "N"


def level_text(channel: str, level: float) -> str:
    """Return a level in its drawn unit; loads by magnitude.

    Examples
    --------
    >>> level_text("Fz", -220.4), level_text("gamma", 0.0349), level_text("kappa", -0.2251)
    ('220 N', '2 deg', '-0.225')
    """
    if channel == "Fz":
        return f"{abs(level):.0f} N"
    if drawn_unit(channel) == "-":
        return f"{round(level, 3) + 0.0:g}"
    return f"{round(level * per_si(channel), 1) + 0.0:.3g} {drawn_unit(channel)}"  # + 0.0: no -0


def letter(signs: str, channel: str) -> str:
    """Return a channel's letter, that of a load so that a loaded tire's is positive."""
    return "$-F_z$" if channel == "Fz" and signs == "sae" else LETTER[channel]


def held_text(signs: str, held: Mapping[str, float]) -> str:
    """Return the constant channels and their levels."""
    return ", ".join(f"{letter(signs, name)} = {level_text(name, level)}" for name, level in held.items())


@own_settings()
def panels(count: int, title: str) -> tuple[Figure, list[Axes]]:
    """Return a titled figure with so many axes, two in a row."""
    columns, rows = min(count, 2), ceil(count / 2)
    figure = Figure(figsize=(6.0 * columns if columns > 1 else 7.0, 0.9 + 3.9 * rows), layout="constrained")
    figure.suptitle(title, fontweight="bold")
    axes = list(figure.subplots(rows, columns, squeeze=False).ravel())
    for unused in axes[count:]:
        unused.remove()
    return figure, axes[:count]


class LevelStyle(NamedTuple):
    """How a level is drawn: color, dashes of its curve and marker of its points."""

    color: RGB
    dashes: Any
    marker: str


def level_styles(count: int, by: str) -> list[LevelStyle]:
    """Return styles ordered like the levels: one color map for loads, another for angles.

    Examples
    --------
    >>> first, second = level_styles(2, "Fz")
    >>> first.color != second.color, first.dashes != second.dashes, first.marker != second.marker
    (True, True, True)
    """
    colormap = colormaps["viridis" if by == "Fz" else "plasma"]
    colors = [_readable(colormap(value)) for value in np.linspace(0.0, 0.85, max(count, 2))[:count]]
    return [LevelStyle(c, DASHES[i % len(DASHES)], MARKERS[i % len(MARKERS)]) for i, c in enumerate(colors)]


def _readable(color: Sequence[float]) -> RGB:
    """Return a color, darkened until it has the smallest contrast with white."""
    red, green, blue = (float(part) for part in color[:3])
    while contrast((red, green, blue)) < CONTRAST:
        red, green, blue = 0.98 * red, 0.98 * green, 0.98 * blue
    return red, green, blue


def contrast(color: RGB) -> float:
    """Return the contrast ratio of a color with white (WCAG 2.2).

    Examples
    --------
    >>> round(contrast((0.0, 0.0, 0.0)), 6), contrast((1.0, 1.0, 1.0))
    (21.0, 1.0)
    """
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in color]
    return 1.05 / (0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2] + 0.05)


def some_of(rows: pd.DataFrame, most: int = SHOWN) -> pd.DataFrame:
    """Return so many random rows, the same each time; every n-th one would alias with the sweeps."""
    return rows.sample(most, random_state=0) if len(rows) > most else rows


def draw_points(ax: Axes, rows: pd.DataFrame, slip: str, channel: str, style: LevelStyle) -> None:
    """Draw measured points, lighter than the line of their level."""
    rows = some_of(rows)
    red, green, blue = (0.55 * part + 0.45 for part in style.color)
    size = 1.4 if len(rows) > 1000 else 2.2 if len(rows) > 200 else 3.4
    x = rows[slip] * per_si(slip)
    ax.plot(x, rows[channel], style.marker, color=(red, green, blue), ms=size, mew=0.0, zorder=1)


def draw_line(ax: Axes, x: ArrayLike, y: ArrayLike, style: LevelStyle, label: str) -> None:
    """Draw a curve; a white rim keeps it readable on points of its own color."""
    rim = [Stroke(linewidth=2.4, foreground="white"), Normal()]
    ax.plot(x, y, color=style.color, ls=style.dashes, lw=1.5, label=label, zorder=3, path_effects=rim)


def finish(ax: Axes, slip: str, ylabel: str) -> None:
    """Put labels, grid and zero lines on axes over a slip."""
    ax.set(xlabel=f"{LETTER[slip]} ({drawn_unit(slip)})", ylabel=ylabel)
    ax.grid(alpha=0.3)
    ax.axhline(0.0, color="0.3", lw=0.8)
    ax.axvline(0.0, color="0.3", lw=0.8)


def place_legend(ax: Axes, title: str | None = None) -> None:
    """Put the legend outside the axes, where it covers nothing."""
    corner = (1.0, 1.0)
    ax.legend(
        title=title,
        loc="upper left",
        bbox_to_anchor=corner,
        fontsize=LEGEND_SIZE,
        title_fontsize=LEGEND_SIZE,
        frameon=False,
        handlelength=HANDLE,
    )


def write_footnote(figure: Figure, signs: str, *notes: str) -> None:
    """Write the sign convention and notes below the axes."""
    lines = textwrap.wrap("; ".join([_CONVENTION[signs], *notes]), int(14 * figure.get_figwidth()))
    figure.supxlabel("\n".join(lines), x=0.01, ha="left", fontsize=NOTE_SIZE, color="0.3")


def png(figure: Figure) -> bytes:
    """Return the figure as PNG."""
    FigureCanvasAgg(figure)
    return rendered(figure, "png", DPI)


@own_settings()
def rendered(figure: Figure, suffix: str, dpi: float, **options: Any) -> bytes:
    """Return the figure as a file's bytes; a letter that the font lacks is drawn as a box, without a warning."""
    buffer = BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font", category=UserWarning)
        figure.savefig(buffer, format=suffix, dpi=dpi, **options)
    return buffer.getvalue()


def write_whole(path: Path, content: bytes) -> Path:
    """Write a file so that nothing half-written is ever seen under its name; return its path."""
    part = path.with_name(f".{path.name}.part")
    try:
        part.unlink(missing_ok=True)  # a link would lead elsewhere
        part.write_bytes(content)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
    return path
