"""The data of a figure for the script of a page, which draws charts of them."""

from __future__ import annotations

import json
from base64 import b64encode
from math import isfinite
from typing import Any

import numpy as np
import numpy.typing as npt

from ..boundary.escaping import script_json
from .figure import Cells, Figure, Panel, Series

#: Largest number of points of a series; of more points, every k-th point is used.
MAX_POINTS = 8_000
#: The integer of a value that is no number.
MISSING = 65_535


def chart_data(figure: Figure) -> str:
    r"""Return the rows of panels of a figure as JSON text for a script element.

    Numbers of series are base64 text of 16-bit integers from a lowest value on, which is finer than a screen.
    ``step`` shows which points are omitted.

    >>> panel = Panel("α (deg)", "Fy (N)", title="<b>")
    >>> chart_data(Figure("force", "Side force", ((panel,),)))[:20]
    '[[{"x":"\\u03b1 (deg)'
    """
    rows = [[_panel(figure, panel) if panel else None for panel in row] for row in figure.rows]
    return script_json(json.dumps(rows, allow_nan=False, separators=(",", ":")))


def _panel(figure: Figure, panel: Panel) -> dict[str, Any]:
    names = ("x", "y", "title", "across", "upright", "x_axis", "width", "height")
    return {name: getattr(panel, name) for name in names} | {
        "limits": figure.limits(panel), "names": figure.names(panel), "bands": figure.bands,
        "series": [_series(drawn) for drawn in panel.series], "cells": _cells(panel.cells) if panel.cells else None,
    }  # fmt: skip


def _series(series: Series) -> dict[str, Any]:
    points = series.points
    step = 1 if series.kind in ("area", "band") else max(1, -(-points.shape[1] // MAX_POINTS))
    gap = np.isnan(points[0] + points[1])  # where a line is interrupted
    x, y = points[:, gap | (np.arange(points.shape[1]) % step == 0)]
    return {**vars(series), "step": step, "x": _encoded(x), "y": _encoded(y)}


def _cells(cells: Cells) -> dict[str, Any]:
    means = [[value if isfinite(value) else None for value in column] for column in cells.means.tolist()]
    edges = {"x": cells.x.tolist(), "y": cells.y.tolist()}
    return {**vars(cells), **edges, "means": means, "counts": cells.counts.tolist()}


def _encoded(values: npt.NDArray[np.float64]) -> dict[str, Any]:
    """Return the lowest value, the unit of the integers, and the integers; the largest integer is no number."""
    finite = values[np.isfinite(values)]
    low = float(finite.min()) if len(finite) else 0.0
    unit = float(np.ptp(finite)) / (MISSING - 1) if len(finite) else 0.0
    steps = np.nan_to_num((values - low) / (unit or 1.0), nan=MISSING, posinf=MISSING, neginf=MISSING)
    return {"low": low, "unit": unit, "steps": b64encode(np.rint(steps).astype("<u2").tobytes()).decode("ascii")}
