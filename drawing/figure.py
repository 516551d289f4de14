"""A figure as data: panels with lines, points and bands, which a page draws as charts and matplotlib as a picture."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
import pandas as pd

from ..numerics.ties import graded
from .labels import per_si
from .style import BLUE, DOTTED, SOLID, some_of

FloatArray = npt.NDArray[np.float64]
Limits = tuple[float | None, float | None]

#: Share of the values of an axis that is left free at each end.
MARGIN = 0.05
#: Height of a line of a name beside the axes, inches.
LINE = 0.2
#: Height of an x axis below its panel in a page, inches.
AXIS = 0.5


@dataclass(frozen=True, eq=False)
class Series:
    """A series with one style.

    - `kind`, one of "line", "points", "area", "band": an area is a filled polygon, and a band one that is drawn on
      request only.
    - `x`, `y`, shape (n,): in the units of the axes; NaN interrupts a line.
    - `color`: ``#rrggbb``.
    - `label`: a name, beside the axes at the height where its line ends; series with the same name are hidden together.
    - `dashes`: of a line: dashes and gaps in widths of the line.
    - `marker`, one of "", "o", "ring": of points, and of a line with points.
    - `size`: width of a line, or size of a marker, in points.
    - `opacity`: from 0 to 1.
    """

    kind: Literal["line", "points", "area", "band"]
    x: npt.ArrayLike
    y: npt.ArrayLike
    color: str = BLUE
    label: str = ""
    dashes: tuple[float, ...] = SOLID
    marker: str = ""
    size: float = 1.5
    opacity: float = 1.0

    @property
    def points(self) -> FloatArray:
        """X and y, shape (2, n)."""
        return np.array([self.x, self.y], dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Cells:
    """A map of a mean over two axes: blue below 0, red above.

    - `x`, `y`: edges of the cells, ascending.
    - `means`, shape (n, m): NaN: no color.
    - `counts`, shape (n, m): rows of a cell.
    - `numbered`: whether the counts are written in the cells.
    - `limit`: the mean with the darkest color.
    - `label`: what the mean is, with its unit.
    """

    x: FloatArray
    y: FloatArray
    means: FloatArray
    counts: npt.NDArray[np.int64]
    numbered: bool
    limit: float
    label: str


@dataclass(frozen=True, eq=False)
class Panel:
    """Axes with what is drawn in them.

    - `x`, `y`: labels of the axes, with units.
    - `series`: in the order in which they are drawn.
    - `title`: above the axes.
    - `across`, `upright`: horizontal and vertical gray lines, at values of y and of x.
    - `x_limits`, `y_limits`: of the axes; None: of the values, with a margin.
    - `x_axis`, `y_axis`: panels of a figure with the same name of an axis have the same limits, and are zoomed together
      along x.
    - `cells`: below the series.
    - `width`, `height`: of a picture, inches; a page takes their ratios.
    - `equal`: in a picture, whether both axes have one scale.
    """

    x: str
    y: str
    series: tuple[Series, ...] = ()
    title: str = ""
    across: tuple[float, ...] = ()
    upright: tuple[float, ...] = ()
    x_limits: Limits = (None, None)
    y_limits: Limits = (None, None)
    x_axis: str = ""
    y_axis: str = ""
    cells: Cells | None = None
    width: float = 6.0
    height: float = 3.9
    equal: bool = False


@dataclass(frozen=True, eq=False)
class Figure:
    """A figure.

    - `name`: of its file.
    - `rows`: the panels from top to bottom; a single panel of a row has its full width, None is an empty position.
    - `note`: below the panels.
    - `bands`: whether bands are drawn from the beginning; otherwise a page has a button for them.
    """

    name: str
    title: str
    rows: tuple[tuple[Panel | None, ...], ...]
    note: str = ""
    bands: bool = False

    @property
    def panels(self) -> list[Panel]:
        """The panels, row by row."""
        return [panel for row in self.rows for panel in row if panel]

    def limits(self, panel: Panel) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the limits of the axes of a panel, x and y."""
        along = [other for other in self.panels if other is panel or (panel.x_axis and other.x_axis == panel.x_axis)]
        upward = [other for other in self.panels if other is panel or (panel.y_axis and other.y_axis == panel.y_axis)]
        return (
            _limits(panel.x_limits, [values for other in along for values in _values(other, 0)]),
            _limits(panel.y_limits, [values for other in upward for values in _values(other, 1)]),
        )

    def names(self, panel: Panel) -> list[tuple[str, str, float]]:
        """Return each name with its color and its height beside the axes, from 0 to 1: near the end of its line.

        >>> lines = (Series("line", [0, 1], [0, y], label=str(y)) for y in (5, 5, -5))
        >>> panel = Panel("x", "y", tuple(lines), height=1.0)
        >>> [(label, round(height, 2)) for label, _, height in Figure("f", "f", ((panel,),)).names(panel)]
        [('5', 0.95), ('-5', 0.05)]
        """
        low, high = self.limits(panel)[1]
        ends: dict[str, tuple[str, float]] = {}
        for series in sorted(panel.series, key=lambda series: series.kind == "line"):
            y = series.points[1][np.isfinite(series.points[1])]
            if series.label and len(y):
                ends[series.label] = series.color, min(max((float(y[-1]) - low) / (high - low), 0.0), 1.0)
        named = sorted(ends, key=lambda label: -graded(ends[label][1]))
        room = max(panel.height - AXIS, LINE)
        sizes = np.array([LINE * (label.count("\n") + 1) / room for label in named])
        gaps = 0.5 * (sizes[1:] + sizes[:-1])  # between the middles of names
        heights = np.array([ends[label][1] for label in named])
        for i in range(1, len(heights)):
            heights[i] = min(heights[i], heights[i - 1] - gaps[i - 1])
        if len(heights):
            heights[-1] = max(heights[-1], min(0.0, 1.0 - gaps.sum()))
        for i in reversed(range(len(heights) - 1)):
            heights[i] = max(heights[i], heights[i + 1] + gaps[i])
        return [(label, ends[label][0], float(height)) for label, height in zip(named, heights, strict=True)]


def in_rows(panels: Sequence[Panel], columns: int = 2) -> tuple[tuple[Panel | None, ...], ...]:
    """Return panels in rows with a number of columns; a single panel has its own row."""
    columns = min(columns, len(panels))
    padded = [*panels, *[None] * (-len(panels) % columns)]
    return tuple(tuple(padded[i : i + columns]) for i in range(0, len(padded), columns))


def curve(x: npt.ArrayLike, y: npt.ArrayLike, color: str, label: str, *, is_measured: bool = True) -> Series:
    """Return the line of a level: solid; dotted where no data determined it."""
    return Series("line", x, y, color, label, SOLID if is_measured else DOTTED)


def measured(rows: pd.DataFrame, slip: str, channel: str, color: str, label: str = "") -> Series:
    """Return the measured points of a level, in the color of its line."""
    rows = some_of(rows)
    return Series("points", rows[slip] * per_si(slip), rows[channel], color, label, marker="o", size=3.6, opacity=0.3)


def band(x: npt.ArrayLike, lower: npt.ArrayLike, upper: npt.ArrayLike, color: str, label: str = "") -> Series:
    """Return the area between two lines over x."""
    x, lower, upper = (np.asarray(values, dtype=np.float64) for values in (x, lower, upper))
    return Series("band", np.append(x, x[::-1]), np.append(lower, upper[::-1]), color, label, opacity=0.25)


def _values(panel: Panel, axis: int) -> Iterable[FloatArray]:
    if panel.cells:
        yield (panel.cells.x, panel.cells.y)[axis]
    for series in panel.series:
        yield series.points[axis]
    yield np.array((panel.upright, panel.across)[axis], dtype=np.float64)


def _limits(given: Limits, values: Sequence[FloatArray]) -> tuple[float, float]:
    shown = np.concatenate([np.empty(0), *values])
    shown = shown[np.isfinite(shown)]
    low, high = (float(shown.min()), float(shown.max())) if len(shown) else (0.0, 1.0)
    room = MARGIN * (high - low) or MARGIN * abs(high) or 1.0
    return low - room if given[0] is None else given[0], high + room if given[1] is None else given[1]
