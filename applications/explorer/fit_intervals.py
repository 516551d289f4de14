"""Intervals of coefficients from the JSON result of a fit."""

from __future__ import annotations

import json
from pathlib import Path

from ...boundary.bounded_file import read_bounded
from ...boundary.errors import TirefmuError, nearest
from ...tires import TireLike, tire_from

#: Upper limit of the file, bytes.
LARGEST = 50_000_000


def fit_intervals(path: Path, tire: TireLike) -> dict[str, tuple[float, float]]:
    """Return the 95 % intervals of a fit in ISO-W, by coefficient; those without a finite interval are absent.

    `path`: result of ``tirefmu fit --json``. `tire`: the fitted tire. Raises `TirefmuError` if the file is not the
    result of a fit of a tire of this model.
    """
    declared = tire_from(tire).symbolic_model.coefficients
    intervals = {}
    try:
        content = json.loads(read_bounded(path, LARGEST))
        mirrored = content["signs"] != "iso"
        for coefficient in content["coefficients"]:
            name, half = coefficient["name"], coefficient["interval"]
            if half is not None:
                value = float(coefficient["value"]) * (-1.0 if mirrored and declared[name].flips else 1.0)
                intervals[str(name)] = (value - float(half), value + float(half))
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        what = f"unknown or missing entry {error}" if isinstance(error, KeyError) else str(error)
        raise TirefmuError(f"{path}: not the JSON result of a fit of this tire's model ({what})") from error
    if unknown := sorted(intervals.keys() - declared.keys()):
        raise TirefmuError(f"{path}: {unknown[0]} is no coefficient of the tire's model{nearest(unknown[0], declared)}")
    return intervals
