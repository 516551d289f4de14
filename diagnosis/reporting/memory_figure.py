"""Figure of the memory of a tire: force and residual for growing and falling slip, before and after, and its states."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.symbolic.quantities import ALPHA, KAPPA
from tirefmu.tires.drawing.own_matplotlib import Axes, Figure, own_settings
from tirefmu.tires.drawing.style import LEGEND_SIZE, LETTER, NOTE_SIZE, drawn_unit, per_si
from tirefmu.tires.tire import Tire

from ..verdict.result import Diagnosis
from .curves_figure import coincide

FloatArray = npt.NDArray[np.float64]

#: Intervals of slip whose means are drawn, and the least number of rows of an interval: of a residual and of a force.
INTERVALS, MIN_ROWS, MIN_ROWS_OF_FORCE = 24, 10, 2
#: Distance from the most frequent load of the rows whose force is drawn, as a share of the nominal load.
LOAD_BAND = 0.08
#: Directions of slip: label, sign of the growth, color, marker and dashes.
DIRECTIONS = (("size of slip grows", 1.0, "C3", "o-"), ("falls", -1.0, "C0", "s--"))
#: Seconds over which the direction of slip is determined.
SMOOTHED = 0.1


@own_settings()
def memory_figure(diagnosis: Diagnosis, channel: str) -> Figure:
    """Draw force and mean residual over the slip that varies most, by its direction, and states of the improved tire.

    The force is that at the most frequent load, measured and of both tires; the residual is that of all rows.

    Parameters
    ----------
    diagnosis : Diagnosis
        Of a recording with time, whose improved tire has states.
    channel : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    computed = _evaluated(diagnosis, diagnosis.tire)
    states = [name for name in diagnosis.tire.states if np.ptp(computed[name]) > 0.0]
    figure = Figure(figsize=(13.0, 7.6 + 1.5 * len(states)), layout="constrained")
    grid = figure.add_gridspec(2 + len(states), 2, height_ratios=(2.8, 2.4, *(1.0 for _ in states)))
    slip = max((n for n in (ALPHA.name, KAPPA.name) if n in diagnosis.rows), key=lambda n: np.ptp(diagnosis.rows[n]))
    tires = ((diagnosis.base_tire, "baseline tire"), (diagnosis.tire, "improved tire"))
    forces, residuals = ([figure.add_subplot(grid[row, i]) for i in range(2)] for row in range(2))
    for axes in (forces, residuals):
        axes[1].sharey(axes[0])
    for force, residual, (tire, title) in zip(forces, residuals, tires, strict=True):
        values = _evaluated(diagnosis, tire)[channel].to_numpy(dtype=np.float64)
        _draw_forces(force, diagnosis, values, channel, slip)
        _draw_residuals(residual, diagnosis, values, channel, slip)
        force.set_title(title)
        residual.set_xlabel(f"{LETTER[slip]} ({drawn_unit(slip)})")
    forces[0].set_ylabel(f"{LETTER[channel]} ({drawn_unit(channel)})")
    residuals[0].set_ylabel(f"mean residual of {LETTER[channel]} ({drawn_unit(channel)})")
    for ax in forces:
        ax.legend(fontsize=LEGEND_SIZE)
    residuals[0].legend(fontsize=LEGEND_SIZE)
    first: Axes | None = None
    for i, name in enumerate(states):
        ax = figure.add_subplot(grid[2 + i, :], sharex=first)
        first = first or ax
        ax.plot(diagnosis.rows["t"], computed[name], color="C0", lw=0.9)
        ax.set_ylabel(f"{name}\n({_unit(diagnosis.tire, name)})", fontsize=NOTE_SIZE)
    if first:
        ax.set_xlabel("t (s)")
    return figure


def _unit(tire: Tire, state: str) -> str:
    unit = tire.book.states[state].unit
    return "-" if unit == "1" else unit


def _evaluated(diagnosis: Diagnosis, tire: Tire) -> pd.DataFrame:
    inputs = [name for name in diagnosis.rows if name == "t" or name in tire.inputs]
    return tire.evaluate(diagnosis.rows[inputs], signs=diagnosis.recording_signs)


def _draw_forces(ax: Axes, diagnosis: Diagnosis, computed: FloatArray, channel: str, slip: str) -> None:
    """Draw the mean force over slip at the most frequent load by direction, measured and of a tire."""
    rows = diagnosis.rows
    load = np.abs(rows["Fz"].to_numpy(dtype=np.float64))
    width = LOAD_BAND * diagnosis.tire.values["FNOMIN"]
    count, edges = np.histogram(load, np.arange(load.min(), load.max() + 2.0 * width, width))
    frequent = float(edges[count.argmax()]) + width / 2.0
    near = np.abs(load - frequent) <= width
    measured = rows[channel].to_numpy(dtype=np.float64)
    values, lines, shown = np.where(np.isfinite(measured), computed, np.nan), [], []
    for label, direction, color, style in DIRECTIONS:
        centers, mean = _means(diagnosis, measured, slip, direction, near, MIN_ROWS_OF_FORCE)
        ax.plot(centers, mean, style[0], ms=4, color=color, label=f"measured, {label}")
        shown.append(mean)
        mean = _means(diagnosis, values, slip, direction, near, MIN_ROWS_OF_FORCE)[1]
        lines.append((mean, style[1:], color, f"tire, {label}"))
    if coincide(lines[0][0], lines[1][0], *shown):
        mean = np.where(np.isfinite(lines[0][0]), lines[0][0], lines[1][0])
        lines = [(mean, "-", "0.2", "tire, both directions")]
    for mean, dashes, color, label in lines:
        ax.plot(centers, mean, dashes, lw=1.3, color=color, label=label)
    ax.text(0.98, 0.04, f"{LETTER['Fz']} near {frequent:.0f} N", transform=ax.transAxes, ha="right", fontsize=NOTE_SIZE)


def _draw_residuals(ax: Axes, diagnosis: Diagnosis, computed: FloatArray, channel: str, slip: str) -> None:
    """Draw the mean residual over slip for rows whose slip grows and for rows whose slip falls."""
    residual = diagnosis.rows[channel].to_numpy(dtype=np.float64) - computed
    for label, direction, color, style in DIRECTIONS:
        centers, mean = _means(diagnosis, residual, slip, direction, np.ones(len(residual), dtype=bool), MIN_ROWS)
        ax.plot(centers, mean, style, ms=3, lw=1.2, color=color, label=label)
    ax.axhline(0.0, color="0.6", lw=0.8)


def _means(
    diagnosis: Diagnosis,
    values: FloatArray,
    slip: str,
    direction: float,
    chosen: npt.NDArray[np.bool_],
    least: int,
) -> tuple[FloatArray, FloatArray]:
    """Return intervals of slip, in the drawn unit, and the mean value of the chosen rows of a direction in each."""
    rows = diagnosis.rows
    at = rows[slip].to_numpy(dtype=np.float64)
    growing = _growth(rows["t"].to_numpy(dtype=np.float64), at)
    edges = np.linspace(at.min(), at.max(), INTERVALS + 1)
    place = np.clip(np.digitize(at, edges) - 1, 0, INTERVALS - 1)
    known = chosen & (direction * growing > 0.0) & np.isfinite(values)
    count = np.bincount(place[known], minlength=INTERVALS)
    total = np.bincount(place[known], values[known], INTERVALS)
    mean = np.where(count >= least, total / np.maximum(count, 1), np.nan)
    return 0.5 * (edges[1:] + edges[:-1]) * per_si(slip), mean


def _growth(t: FloatArray, slip: FloatArray) -> FloatArray:
    """Return the change of the size of a slip over a short time."""
    later, earlier = (np.interp(t + sign * SMOOTHED / 2.0, t, np.abs(slip)) for sign in (1.0, -1.0))
    return np.asarray(later - earlier)
