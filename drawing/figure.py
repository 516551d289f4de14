"""A figure as data: panels with lines, points and bands, which a page draws as charts and matplotlib as a picture."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
import pandas as pd

from .labels import per_si
from .style import BLUE, SOLID, LevelStyle, some_of

FloatArray = npt.NDArray[np.float64]
Limits = tuple[float | None, float | None]

#: Share of the values of an axis that is left free at each end.
MARGIN = 0.05


@dataclass(frozen=True, eq=False)
class Series:
    """A series with one style.

    - `kind`, one of "line", "points", "band": a band is a filled polygon.
    - `x`, `y`, shape (n,): in the units of the axes; NaN interrupts a line.
    - `color`: ``#rrggbb``.
    - `label`: series with the same label have one entry in the legend and are hidden together; empty: no entry.
    - `dashes`: of a line: dashes and gaps in widths of the line.
    - `marker`, one of "", ".", "o", "^", "s", "D", "v", "x", "ring": of points, and of a line with points.
    - `size`: width of a line, or size of a marker, in points.
    - `opacity`: from 0 to 1.
    """

    kind: Literal["line", "points", "band"]
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
    - `title`, `legend`: headings of the panel and of its legend.
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
    legend: str = ""
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
    """

    name: str
    title: str
    rows: tuple[tuple[Panel | None, ...], ...]
    note: str = ""

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


def in_rows(panels: Sequence[Panel], columns: int = 2) -> tuple[tuple[Panel | None, ...], ...]:
    """Return panels in rows with a number of columns; a single panel has its own row."""
    columns = min(columns, len(panels))
    padded = [*panels, *[None] * (-len(panels) % columns)]
    return tuple(tuple(padded[i : i + columns]) for i in range(0, len(padded), columns))


def curve(x: npt.ArrayLike, y: npt.ArrayLike, style: LevelStyle, label: str) -> Series:
    """Return the line of a level."""
    return Series("line", x, y, style.color, label, style.dashes)


def measured(rows: pd.DataFrame, slip: str, channel: str, style: LevelStyle, label: str) -> Series:
    """Return the measured points of a level, lighter than its line."""
    rows = some_of(rows)
    size = 1.4 if len(rows) > 1000 else 2.2 if len(rows) > 200 else 3.4
    return Series("points", rows[slip] * per_si(slip), rows[channel], style.pale, label, marker=style.marker, size=size)


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
