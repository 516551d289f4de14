"""Figure of the memory of a tire: residuals for growing and falling slip, before and after, and states over time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tirefmu.symbolic.quantities import ALPHA, KAPPA
from tirefmu.tires.drawing.style import LETTER, drawn_unit, per_si, png, write_whole
from tirefmu.tires.tire import Tire

from ..verdict.result import Diagnosis

FloatArray = npt.NDArray[np.float64]

#: Intervals of slip whose mean residual is drawn, and the least number of rows of an interval.
INTERVALS, MIN_ROWS = 24, 10
#: Seconds over which the direction of slip is determined.
SMOOTHED = 0.1


def draw_memory(diagnosis: Diagnosis, channel: str, path: str | Path) -> Path:
    """Draw the mean residual over the slip that varies most, by its direction, and the states of the improved tire.

    Parameters
    ----------
    diagnosis : Diagnosis
        Of a recording with time, whose improved tire has states.
    channel : str
    path : str or Path
        PNG file; written completely or not at all.

    Returns
    -------
    Path
    """
    computed = _evaluated(diagnosis, diagnosis.tire)
    states = [name for name in diagnosis.tire.states if np.ptp(computed[name]) > 0.0]
    figure = Figure(figsize=(13.0, 3.6 + 1.5 * len(states)), layout="constrained")
    grid = figure.add_gridspec(1 + len(states), 2, height_ratios=(2.4, *(1.0 for _ in states)))
    slip = max((n for n in (ALPHA.name, KAPPA.name) if n in diagnosis.rows), key=lambda n: np.ptp(diagnosis.rows[n]))
    left, right = (figure.add_subplot(grid[0, i]) for i in range(2))
    right.sharey(left)
    for ax, tire, title in ((left, diagnosis.base_tire, "baseline tire"), (right, diagnosis.tire, "improved tire")):
        _draw_directions(ax, diagnosis, tire, channel, slip)
        ax.set(title=title, xlabel=f"{LETTER[slip]} ({drawn_unit(slip)})")
    left.set_ylabel(f"mean residual of {LETTER[channel]} ({drawn_unit(channel)})")
    left.legend(fontsize=8)
    first: Axes | None = None
    for i, name in enumerate(states):
        ax = figure.add_subplot(grid[1 + i, :], sharex=first)
        first = first or ax
        ax.plot(diagnosis.rows["t"], computed[name], color="C0", lw=0.9)
        ax.set_ylabel(f"{name}\n({_unit(diagnosis.tire, name)})", fontsize=8)
    if first:
        ax.set_xlabel("t (s)")
    return write_whole(Path(path), png(figure))


def _unit(tire: Tire, state: str) -> str:
    unit = tire.book.states[state].unit
    return "-" if unit == "1" else unit


def _evaluated(diagnosis: Diagnosis, tire: Tire) -> pd.DataFrame:
    inputs = [name for name in diagnosis.rows if name == "t" or name in tire.inputs]
    return tire.evaluate(diagnosis.rows[inputs], signs=diagnosis.recording_signs)


def _draw_directions(ax: Axes, diagnosis: Diagnosis, tire: Tire, channel: str, slip: str) -> None:
    """Draw the mean residual over slip for rows whose slip grows and for rows whose slip falls."""
    rows = diagnosis.rows
    residual = rows[channel].to_numpy(dtype=np.float64) - _evaluated(diagnosis, tire)[channel].to_numpy()
    values = rows[slip].to_numpy(dtype=np.float64)
    growing = _growth(rows["t"].to_numpy(dtype=np.float64), values)
    edges = np.linspace(values.min(), values.max(), INTERVALS + 1)
    centers = 0.5 * (edges[1:] + edges[:-1]) * per_si(slip)
    place = np.clip(np.digitize(values, edges) - 1, 0, INTERVALS - 1)
    for label, chosen, color in (("size of slip grows", growing > 0.0, "C3"), ("falls", growing < 0.0, "C0")):
        known = chosen & np.isfinite(residual)
        count = np.bincount(place[known], minlength=INTERVALS)
        total = np.bincount(place[known], residual[known], INTERVALS)
        mean = np.where(count >= MIN_ROWS, total / np.maximum(count, 1), np.nan)
        ax.plot(centers, mean, "o-", ms=3, lw=1.2, color=color, label=label)
    ax.axhline(0.0, color="0.6", lw=0.8)


def _growth(t: FloatArray, slip: FloatArray) -> FloatArray:
    """Return the change of the size of a slip over a short time."""
    later, earlier = (np.interp(t + sign * SMOOTHED / 2.0, t, np.abs(slip)) for sign in (1.0, -1.0))
    return np.asarray(later - earlier)
