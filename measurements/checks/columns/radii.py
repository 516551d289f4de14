"""Radii of the tire that a recording shows: loaded radius, speed over wheel speed, designation of the size."""

from __future__ import annotations

import re

import numpy as np

from ....numerics.arrays import FloatArray
from ...recording import Recording
from ...units import FOOT

#: m. A radius outside is not one of a tire: channels of a bench are unusable in many runs.
SMALLEST_RADIUS, LARGEST_RADIUS = 0.03, 1.5
_INCHES = re.compile(r"(?<![\d.])(?P<diameter>\d{1,2}(?:\.\d{1,2})?) ?[xX] ?\d{1,2}(?:\.\d{1,2})? ?- ?\d{1,2}(?!\d)")
_METRIC = re.compile(r"(?<!\d)(?P<width>\d{3})/(?P<aspect>\d{2}) ?Z?R ?(?P<rim>\d{2})(?!\d)")


def radii(recording: Recording) -> dict[str, float]:
    """Return the radii that a recording shows, m, by what shows them; empty if nothing does.

    `recording`: ``about`` has the medians of the loaded radius and of speed over wheel speed of a bench file, and the
    name of the tire.

    >>> import pandas as pd
    >>> about = {"tireid": "Maker 205/55R16", "loaded radius": "0.301"}
    >>> {name: round(radius, 3) for name, radius in radii(Recording(pd.DataFrame(), "iso", "a", about)).items()}
    {'loaded radius': 0.301, 'size of its tire': 0.316}
    """
    radii = {name: float(recording.about[name]) for name in ("loaded radius", "wheel speed") if name in recording.about}
    title = recording.about.get("tireid", "")
    inch = FOOT / 12.0
    if (size := _INCHES.search(title)) is not None:
        radii["size of its tire"] = 0.5 * inch * float(size["diameter"])
    elif (size := _METRIC.search(title)) is not None:
        sidewall = 1e-3 * float(size["width"]) * float(size["aspect"]) / 100.0
        radii["size of its tire"] = 0.5 * inch * float(size["rim"]) + sidewall
    return {name: radius for name, radius in radii.items() if SMALLEST_RADIUS < radius < LARGEST_RADIUS}


def median_radius(radius: FloatArray) -> str | None:
    """Return the median of a radius in m as metadata of a recording; None if it is not one of a tire."""
    finite = radius[np.isfinite(radius)]
    median = float(np.median(finite)) if len(finite) else 0.0
    return f"{median:.6g}" if SMALLEST_RADIUS < median < LARGEST_RADIUS else None
