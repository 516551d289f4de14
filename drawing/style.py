"""Colors of levels and series, and how many points of a group are drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

RGB = tuple[float, float, float]

#: Dashes and gaps in widths of a line. The line of a tire within its data is solid.
SOLID: tuple[float, ...] = ()
DASHED, DOTTED = (4.0, 2.0), (1.0, 1.6)
#: Colors of series that are not levels.
BLUE, RED, GREEN, ORANGE, GRAY, LIGHT_GRAY, BLACK = (
    "#1f77b4", "#d62728", "#2a8a2a", "#c65f00", "#808080", "#b0b0b0", "#000000",
)  # fmt: skip
#: Ends and even steps of two color maps, dark to light: one for loads, one for angles.
_LOADS = ("#440154", "#3b528b", "#21918c", "#5ec962", "#fde725")
_ANGLES = ("#0d0887", "#7e03a8", "#cc4778", "#f89540", "#f0f921")
#: Smallest contrast of a level's color with the white page: its name is text (WCAG 2.2, criterion 1.4.3).
CONTRAST = 4.5
SHOWN = 300  # points of a group; more would only cover each other


def level_colors(count: int, by: str) -> list[str]:
    """Return colors ordered like the levels: one color map for loads, another for angles.

    >>> len(set(level_colors(5, "Fz")))
    5
    """
    steps = np.array([_parts(color) for color in (_LOADS if by == "Fz" else _ANGLES)])
    places = np.linspace(0.0, 0.85, max(count, 2))[:count]
    mixed = [[float(np.interp(place, np.linspace(0.0, 1.0, len(steps)), part)) for part in steps.T] for place in places]
    return [_hex(_readable((red, green, blue))) for red, green, blue in mixed]


def _readable(color: RGB) -> RGB:
    """Return a color, darkened until it has the smallest contrast with white."""
    red, green, blue = color
    while contrast(_hex((red, green, blue))) < CONTRAST:
        red, green, blue = 0.98 * red, 0.98 * green, 0.98 * blue
    return red, green, blue


def contrast(color: str) -> float:
    """Return the contrast ratio of a color with white (WCAG 2.2).

    >>> round(contrast("#000000"), 6), contrast("#ffffff")
    (21.0, 1.0)
    """
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in _parts(color)]
    return 1.05 / (0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2] + 0.05)


def _parts(color: str) -> RGB:
    red, green, blue = (int(color[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return red, green, blue


def _hex(color: Sequence[float]) -> str:
    return "#" + "".join(f"{round(255.0 * part):02x}" for part in color)


def some_of(rows: pd.DataFrame, most: int = SHOWN) -> pd.DataFrame:
    """Return a number of random rows, the same each time; every n-th row would alias with the sweeps."""
    return rows.sample(most, random_state=0) if len(rows) > most else rows
