"""Figures of a check: measured data, simulation and error over time."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ...boundary.errors import FmuError, writing
from ...boundary.escaping import figure_text
from ...drawing.figure import Figure, Panel, Series
from ...drawing.labels import note
from ...drawing.style import BLACK, BLUE, GRAY, RED
from .compared import CheckedChannel, Compared

FloatArray = npt.NDArray[np.float64]

#: Largest number of segments that are separated by lines.
MAX_SEPARATED = 50
#: Number of rows from which points are small.
MANY = 1000


def draw_check(result: Compared, folder: str | os.PathLike[str], *, prefix: str = "") -> list[Path]:
    """Draw every measured channel of a check over time, one PNG each.

    The upper axes show the data and the FMU by segment, the lower axes the error, with lines at plus and minus the RMSE
    of each segment.

    `folder`: created if it does not exist. `prefix`: prefix of each file name, which is the name of the channel. Raises
    `FmuError` if a file cannot be written.

    >>> import pandas as pd
    >>> from tirefmu.tires import published
    >>> from tirefmu.fmu import export
    >>> from tirefmu.fmu import check
    >>> table = pd.DataFrame({"alpha": [-0.1, 0.0, 0.1], "Fz": 900.0, "Fy": [2100.0, 10.0, -2000.0]})
    >>> result = check(export(published("trento_hoosier"), "tire.fmu"), table)
    >>> [path.name for path in draw_check(result, "figures")]
    ['Fy.png']
    """
    from ...drawing.picture import write_figures  # imports matplotlib, which is slow

    with writing(Path(folder), FmuError):
        return write_figures(check_figures(result), Path(folder), prefix)


def check_figures(result: Compared) -> list[Figure]:
    """Return the figures of `draw_check`."""
    return [_figure(result, channel) for channel in result.channels]


def _figure(result: Compared, channel: CheckedChannel) -> Figure:
    segments = f"{result.segments} segment{'s'[: result.segments != 1]}, each started in steady state"
    names = f"{figure_text(result.fmu)} against {figure_text(result.source)}"
    unit = figure_text(channel.unit)
    score = f"RMSE {channel.rmse:.4g} {unit} ({channel.relative_rmse:.2%} of the largest), R2 {channel.r2:.4f}"
    time = _time(result)
    starts = tuple(float(time[start]) for start in result.starts[1:]) if result.segments <= MAX_SEPARATED else ()
    x = "time without the gaps between segments (s)"
    above = Panel(
        x, f"{channel.name} ({unit})", tuple(_values(result, channel, time)), score, upright=starts, x_axis="time",
        width=10.0, height=3.4,
    )  # fmt: skip
    below = Panel(
        x, f"FMU - data ({unit})", tuple(_errors(result, channel, time)), across=(0.0,), upright=starts, x_axis="time",
        width=10.0, height=1.7,
    )  # fmt: skip
    return Figure(channel.name, f"{names}: {channel.name}, {segments}", ((above,), (below,)), note("iso"))


def _segments(result: Compared) -> list[slice]:
    return [slice(a, b) for a, b in zip(result.starts, [*result.starts[1:], result.rows], strict=True)]


def _time(result: Compared) -> FloatArray:
    """Return the time of every row without the gaps between segments, s."""
    time = result.recording["t"].to_numpy(dtype=np.float64)
    steps = np.diff(time, prepend=time[:1])
    steps[list(result.starts)] = 0.0
    return np.cumsum(steps)


def _values(result: Compared, channel: CheckedChannel, time: FloatArray) -> Iterator[Series]:
    """Yield the data as dots and the FMU as a line that is interrupted between segments."""
    data, simulated = (table[channel.name].to_numpy() for table in (result.recording, result.simulated))
    yield Series("points", time, data, GRAY, "data", marker="o", size=1.5 if len(time) > MANY else 4.0)
    segments = _segments(result)
    last = [segment.stop for segment in segments]
    alone = all(segment.stop - segment.start == 1 for segment in segments)
    line = np.insert(time, last, np.nan), np.insert(simulated, last, np.nan)
    yield Series("line", *line, BLUE, "FMU", marker="o" if alone else "", size=0.9)


def _errors(result: Compared, channel: CheckedChannel, time: FloatArray) -> Iterator[Series]:
    """Yield the error as dots, lines at plus and minus its RMSE in each segment, and the worst point."""
    error = result.simulated[channel.name].to_numpy() - result.recording[channel.name].to_numpy()
    yield Series("points", time, error, RED, "FMU - data", marker="o", size=1.5 if len(time) > MANY else 4.0)
    lines = []
    for rows in _segments(result):
        finite = error[rows][np.isfinite(error[rows])]
        if len(finite):
            rmse = float(np.sqrt(np.mean(finite**2)))
            ends = [*time[rows][[0, -1]], np.nan]
            lines += [np.array([ends, [side, side, np.nan]]) for side in (-rmse, rmse)]
    x, y = np.hstack(lines)
    yield Series("line", x, y, BLACK, "RMSE of each segment", size=1.2)
    worst = channel.worst
    there = [worst.simulated - worst.measured]
    yield Series("points", time[[worst.row]], there, BLACK, "worst point", marker="ring", size=6.0)
