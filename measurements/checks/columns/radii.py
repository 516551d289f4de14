"""Radii of the tire that a recording shows: loaded radius, speed over wheel speed, designation of the size."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ....numerics.arrays import FloatArray
from ...recording import Recording
from ...units import FOOT

#: m. A radius outside is not one of a tire: channels of a bench are unusable in many runs.
SMALLEST_RADIUS, LARGEST_RADIUS = 0.03, 1.5
_NUMBER = r"\d{1,2}(?:\.\d{1,2})?"
_INCHES = re.compile(rf"(?<![\d.])(?P<diameter>{_NUMBER}) ?[xX] ?(?P<width>{_NUMBER}) ?- ?(?P<rim>\d{{1,2}})(?!\d)")
_METRIC = re.compile(r"(?<!\d)(?P<width>\d{3})/(?P<aspect>\d{2}) ?Z?R ?(?P<rim>\d{2})(?!\d)")
INCH = FOOT / 12.0
#: What shows a radius: the designation of the size in the title.
SIZE = "size of its tire"
#: Smallest ratio of the largest and the smallest load, and fewest rows, from which a deflection is read; limits of the
#: vertical stiffness of a tire, N/m.
LOAD_RATIO, MIN_ROWS, STIFFNESSES = 1.5, 50, (1e4, 5e6)


@dataclass(frozen=True)
class TireSize:
    """The dimensions in the designation of a size, m."""

    radius: float
    width: float
    rim_radius: float


def tire_size(text: str) -> TireSize | None:
    """Return the dimensions of the first designation of a size in a text; None if there is none.

    Metric: section width in mm, aspect ratio in percent, rim in inches. Otherwise overall diameter, width and rim in
    inches.

    >>> tire_size("205/55R16"), tire_size("Maker 16x7.5-10 LCO") and tire_size("16x7.5-10").radius
    (TireSize(radius=0.31595, width=0.205, rim_radius=0.2032), 0.2032)
    """
    if (size := _INCHES.search(text)) is not None:
        diameter, width, rim = (INCH * float(size[name]) for name in ("diameter", "width", "rim"))
        return TireSize(*(round(value, 5) for value in (0.5 * diameter, width, 0.5 * rim)))
    if (size := _METRIC.search(text)) is not None:
        width, rim = 1e-3 * float(size["width"]), 0.5 * INCH * float(size["rim"])
        radius = rim + width * float(size["aspect"]) / 100.0
        return TireSize(*(round(value, 5) for value in (radius, width, rim)))
    return None


def deflection(load: FloatArray, radius: FloatArray) -> dict[str, str]:
    """Return the radius at zero load, m, and the vertical stiffness, N/m, from loaded radii, as metadata.

    `load`, `radius`, shape (n,): N and m. Empty if the loads do not vary enough, or the radius does not fall.

    >>> load = np.linspace(300.0, 3000.0, 99)
    >>> deflection(load, 0.3 - load / 2e5)
    {'radius at zero load': '0.3', 'vertical stiffness': '200000'}
    """
    load = np.abs(load)
    used = np.isfinite(load) & (radius > SMALLEST_RADIUS) & (radius < LARGEST_RADIUS) & (load > 0.0)
    if used.sum() < MIN_ROWS or np.quantile(load[used], 0.95) < LOAD_RATIO * np.quantile(load[used], 0.05):
        return {}
    slope, free = np.polyfit(load[used], radius[used], 1)
    if not (slope < 0.0 and STIFFNESSES[0] < -1.0 / slope < STIFFNESSES[1] and free < LARGEST_RADIUS):
        return {}
    return {"radius at zero load": f"{free:.6g}", "vertical stiffness": f"{-1.0 / slope:.6g}"}


def radii(recording: Recording) -> dict[str, float]:
    """Return the radii that a recording shows, m, by what shows them; empty if nothing does.

    `recording`: ``about`` has the medians of the loaded radius and of speed over wheel speed of a bench file, and the
    name of the tire.

    >>> import pandas as pd
    >>> about = {"tireid": "Maker 205/55R16", "loaded radius": "0.301"}
    >>> {name: round(radius, 3) for name, radius in radii(Recording(pd.DataFrame(), "iso", "a", about)).items()}
    {'loaded radius': 0.301, 'size of its tire': 0.316}
    """
    names = ("radius at zero load", "loaded radius", "wheel speed")
    radii = {name: float(recording.about[name]) for name in names if name in recording.about}
    if (size := tire_size(recording.about.get("tireid", ""))) is not None:
        radii[SIZE] = size.radius
    return {name: radius for name, radius in radii.items() if SMALLEST_RADIUS < radius < LARGEST_RADIUS}


def median_radius(radius: FloatArray) -> str | None:
    """Return the median of a radius in m as metadata of a recording; None if it is not one of a tire."""
    finite = radius[np.isfinite(radius)]
    median = float(np.median(finite)) if len(finite) else 0.0
    return f"{median:.6g}" if SMALLEST_RADIUS < median < LARGEST_RADIUS else None
