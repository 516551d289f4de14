"""Figures of a check: measured data, simulation and error over time."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.errors import FmuError
from tirefmu.symbolic.escaping import figure_text
from tirefmu.tires.drawing.own_matplotlib import Axes, Figure, own_settings
from tirefmu.tires.drawing.shown_figure import shown_figures, write_figures
from tirefmu.tires.drawing.style import LEGEND_SIZE, TITLE_SIZE

from .result import Channel, CheckResult

FloatArray = npt.NDArray[np.float64]

DATA, MODEL, ERROR = "0.65", "tab:blue", "tab:red"
#: Size of markers in a legend, points.
LEGEND_MARKER = 5.0


def draw_check(result: CheckResult, folder: str | os.PathLike[str], *, prefix: str = "") -> list[Path]:
    """Draw every measured channel of a check over time, one PNG each.

    The upper axes show the data and the FMU by segment, the lower axes the error, with lines at plus and minus the RMSE
    of each segment.

    Parameters
    ----------
    result : CheckResult
    folder : path-like
        Created if it does not exist.
    prefix : str
        Prefix of each file name, which is the name of the channel.

    Returns
    -------
    list of Path

    Raises
    ------
    FmuError
        If a file cannot be written.

    Examples
    --------
    >>> import pandas as pd
    >>> from tirefmu.tires import published
    >>> from tirefmu.fmu import export
    >>> from tirefmu.fmu import check
    >>> table = pd.DataFrame({"alpha": [-0.1, 0.0, 0.1], "Fz": 900.0, "Fy": [2100.0, 10.0, -2000.0]})
    >>> result = check(export(published("trento_hoosier"), "tire.fmu"), table)
    >>> [path.name for path in draw_check(result, "figures")]
    ['Fy.png']
    """
    try:
        return write_figures(shown_figures(check_figures(result)), Path(folder), prefix)
    except OSError as error:
        raise FmuError(f"{folder}: cannot be written ({error.strerror or error})") from error


def check_figures(result: CheckResult) -> dict[str, Figure]:
    """Return the figures of `draw_check` by channel.

    Parameters
    ----------
    result : CheckResult

    Returns
    -------
    dict of str to matplotlib.figure.Figure
    """
    return {channel.name: _figure(result, channel) for channel in result.channels}


@own_settings()
def _figure(result: CheckResult, channel: Channel) -> Figure:
    figure = Figure(figsize=(11.0, 6.0), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    segments = f"{result.segments} segment{'s'[: result.segments != 1]}, each started in steady state"
    names = f"{figure_text(result.fmu)} against {figure_text(result.source)}"
    figure.suptitle(f"{names}: {channel.name}, {segments}", fontsize=11)
    _draw_values(above, result, channel)
    _draw_errors(below, result, channel)
    for ax in (above, below):
        ax.grid(alpha=0.3)
        for start in result.starts[1:] if result.segments <= 50 else ():
            ax.axvline(_time(result)[start], color="0.5", lw=0.6, ls=":")
    below.set_xlabel("time simulated (s), without the gaps between segments; ISO signs")
    return figure


def _segments(result: CheckResult) -> list[slice]:
    return [slice(a, b) for a, b in zip(result.starts, [*result.starts[1:], result.rows], strict=True)]


def _time(result: CheckResult) -> FloatArray:
    """Return the time of every row without the gaps between segments, s."""
    time = result.recording["t"].to_numpy(dtype=np.float64)
    steps = np.diff(time, prepend=time[:1])
    steps[list(result.starts)] = 0.0
    return np.cumsum(steps)


def _draw_values(ax: Axes, result: CheckResult, channel: Channel) -> None:
    """Draw the data as dots and the FMU as one line per segment."""
    time, data = _time(result), result.recording[channel.name].to_numpy()
    ax.plot(time, data, ".", ms=1.2 if len(time) > 1000 else 4.0, color=DATA, label="data")
    for i, rows in enumerate(_segments(result)):
        shown = result.simulated[channel.name].to_numpy()[rows]
        marker = "." if len(shown) == 1 else ""
        ax.plot(time[rows], shown, marker=marker, color=MODEL, lw=0.9, label="FMU" if i == 0 else None)
    unit = figure_text(channel.unit)
    title = f"RMSE {channel.rmse:.4g} {unit} ({channel.relative_rmse:.2%} of the largest), R2 {channel.r2:.4f}"
    ax.set_title(title, fontsize=TITLE_SIZE, loc="left")
    ax.set_ylabel(f"{channel.name} ({unit})")
    _add_legend(ax)


def _draw_errors(ax: Axes, result: CheckResult, channel: Channel) -> None:
    time, data = _time(result), result.recording[channel.name].to_numpy()
    error = result.simulated[channel.name].to_numpy() - data
    ax.plot(time, error, ".", ms=1.2 if len(time) > 1000 else 4.0, color=ERROR, label="FMU - data")
    for i, rows in enumerate(_segments(result)):
        known = error[rows][np.isfinite(error[rows])]
        if len(known):
            rmse = float(np.sqrt(np.mean(known**2)))
            for side in (-rmse, rmse):
                label = "RMSE of each segment" if i == 0 and side > 0.0 else None
                ax.plot(time[rows][[0, -1]], [side, side], color="black", lw=1.2, label=label)
    worst = channel.worst
    ax.plot(time[worst.row], worst.simulated - worst.measured, "o", mfc="none", color="black", label="worst point")
    ax.axhline(0.0, color="0.3", lw=0.8)
    ax.set_ylabel(f"FMU - data ({figure_text(channel.unit)})")
    _add_legend(ax)


def _add_legend(ax: Axes) -> None:
    """Show the markers of all series in one size: those of many rows are too small to see."""
    legend = ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=LEGEND_SIZE)
    for handle in legend.get_lines():
        handle.set_markersize(LEGEND_MARKER)
