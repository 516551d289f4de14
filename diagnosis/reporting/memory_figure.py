"""Figure of the memory of a tire: force and residual for growing and falling slip, before and after, and its states."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ...drawing.figure import Figure, Panel, Series
from ...drawing.labels import axis_label, drawn_unit, per_si
from ...drawing.style import BLACK, BLUE, DASHED, RED, SOLID
from ...numerics.arrays import BoolArray, FloatArray
from ...numerics.ties import graded
from ...symbolic.quantities import ALPHA, KAPPA
from ...tires.evaluation import Conventions, evaluate
from ...tires.tire import Tire
from ..verdict.residual_location import MIN_ROWS_OF_CELL
from ..verdict.result import Diagnosis
from .residual_figure import coincide

#: Intervals of slip whose means are drawn, and the minimum number of rows of an interval of a force.
INTERVALS, MIN_ROWS_OF_FORCE = 24, 2
#: Distance from the most frequent load of the rows whose force is drawn, as a share of the nominal load.
LOAD_BAND = 0.08
#: Directions of slip: label, sign of the growth, color, marker and dashes.
DIRECTIONS = (("size of slip grows", 1.0, RED, SOLID), ("falls", -1.0, BLUE, DASHED))
#: Seconds over which the direction of slip is determined.
SMOOTHED = 0.1


def memory_figure(diagnosis: Diagnosis, channel: str) -> Figure:
    """Return force and mean residual over the slip that varies most, by its direction, and states of the improved tire.

    The force is that at the most frequent load, measured and of both tires; the residual is that of all rows.

    `diagnosis`: of a recording with time, whose improved tire has states.
    """
    slip = widest_slip(diagnosis.rows)
    tires = ((diagnosis.base_tire, "baseline tire"), (diagnosis.tire, "improved tire"))
    forces, residuals = [], []
    for tire, title in tires:
        values = evaluated(diagnosis, tire)[channel].to_numpy(dtype=np.float64)
        forces.append(_force_panel(diagnosis, values, channel, slip, title))
        residuals.append(_residual_panel(diagnosis, values, channel, slip, title))
    computed, t = evaluated(diagnosis, diagnosis.tire), diagnosis.rows["t"]
    states = [
        Panel("t (s)", f"{name} ({_unit(diagnosis.tire, name)})", (Series("line", t, computed[name], size=0.9),),
              x_axis="time", height=1.5)
        for name in diagnosis.tire.states if np.ptp(computed[name]) > 0.0
    ]  # fmt: skip
    rows = (tuple(forces), tuple(residuals), *((panel,) for panel in states))
    return Figure(f"memory_{channel}", f"{channel} by direction of slip, and states over time", rows)


def _unit(tire: Tire, state: str) -> str:
    unit = tire.symbolic_model.states[state].unit
    return "-" if unit == "1" else unit


def widest_slip(rows: pd.DataFrame) -> str:
    """Return the slip that varies most in the rows of a recording."""
    return max((name for name in (ALPHA.name, KAPPA.name) if name in rows), key=lambda name: graded(np.ptp(rows[name])))


def evaluated(diagnosis: Diagnosis, tire: Tire) -> pd.DataFrame:
    """Return what a tire computes in the rows of a recording, in its signs."""
    inputs = [name for name in diagnosis.rows if name == "t" or name in tire.inputs]
    return evaluate(tire, diagnosis.rows[inputs], Conventions(diagnosis.recording_signs))


def _force_panel(diagnosis: Diagnosis, computed: FloatArray, channel: str, slip: str, title: str) -> Panel:
    """Return the mean force over slip at the most frequent load by direction, measured and of a tire."""
    rows = diagnosis.rows
    load = np.abs(rows["Fz"].to_numpy(dtype=np.float64))
    width = LOAD_BAND * diagnosis.tire.values["FNOMIN"]
    count, edges = np.histogram(load, np.arange(load.min(), load.max() + 2.0 * width, width))
    frequent = float(edges[count.argmax()]) + width / 2.0
    near = np.abs(load - frequent) <= width
    measured = rows[channel].to_numpy(dtype=np.float64)
    values = np.where(np.isfinite(measured), computed, np.nan)
    points, lines, shown = [], [], []
    for label, direction, color, dashes in DIRECTIONS:
        x, mean = _means(diagnosis, measured, slip, direction, near, MIN_ROWS_OF_FORCE)
        points.append(Series("points", x, mean, color, f"measured, {label}", marker="o", size=4.0))
        shown.append(mean)
        mean = _means(diagnosis, values, slip, direction, near, MIN_ROWS_OF_FORCE)[1]
        lines.append(Series("line", x, mean, color, f"tire, {label}", dashes, size=1.3))
    first, second = (line.points[1] for line in lines)
    if coincide(first, second, *shown):
        mean = np.where(np.isfinite(first), first, second)
        lines = [Series("line", x, mean, BLACK, "tire, both directions", size=1.3)]
    return Panel(
        axis_label(slip), axis_label(channel), (*points, *lines), f"{title}, Fz near {frequent:.0f} N", y_axis="force",
        height=2.8,
    )  # fmt: skip


def _residual_panel(diagnosis: Diagnosis, computed: FloatArray, channel: str, slip: str, title: str) -> Panel:
    """Return the mean residual over slip, separately for rising and for falling slip."""
    residual = diagnosis.rows[channel].to_numpy(dtype=np.float64) - computed
    series = []
    for label, direction, color, dashes in DIRECTIONS:
        x, mean = _means(diagnosis, residual, slip, direction, np.ones(len(residual), dtype=bool), MIN_ROWS_OF_CELL)
        series.append(Series("line", x, mean, color, label, dashes, size=1.2))
    y = f"mean residual of {channel} ({drawn_unit(channel)})"
    return Panel(axis_label(slip), y, tuple(series), title, across=(0.0,), y_axis="residual", height=2.4)


def _means(
    diagnosis: Diagnosis,
    values: FloatArray,
    slip: str,
    direction: float,
    chosen: BoolArray,
    least: int,
) -> tuple[FloatArray, FloatArray]:
    """Return intervals of slip, in the drawn unit, and the mean value of the chosen rows of a direction in each."""
    rows = diagnosis.rows
    at = rows[slip].to_numpy(dtype=np.float64)
    growing = _growth(rows["t"].to_numpy(dtype=np.float64), at)
    edges = np.linspace(at.min(), at.max(), INTERVALS + 1)
    place = np.clip(np.digitize(at, edges) - 1, 0, INTERVALS - 1)
    averaged = chosen & (direction * growing > 0.0) & np.isfinite(values)
    count = np.bincount(place[averaged], minlength=INTERVALS)
    total = np.bincount(place[averaged], values[averaged], INTERVALS)
    mean = np.where(count >= least, total / np.maximum(count, 1), np.nan)
    return 0.5 * (edges[1:] + edges[:-1]) * per_si(slip), mean


def _growth(t: FloatArray, slip: FloatArray) -> FloatArray:
    """Return the change of the size of a slip over a short time."""
    later, earlier = (np.interp(t + sign * SMOOTHED / 2.0, t, np.abs(slip)) for sign in (1.0, -1.0))
    return np.asarray(later - earlier)
