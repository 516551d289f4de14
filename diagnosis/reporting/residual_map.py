"""Residual map: the mean residual of a tire on a recording over two inputs. A missing effect shows as a pattern."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.bounded_file import write_whole
from ...boundary.errors import DataError, nearest
from ...drawing.figure import Cells, Figure, Panel, Series
from ...drawing.labels import axis_label, drawn_unit, note, per_si
from ...drawing.style import BLACK
from ...measurements import Recording, TableLike, levels, recording_from
from ...numerics.ties import graded
from ...tires import TireLike, tire_from
from ...tires.evaluation import Conventions, evaluate
from ...tires.tire import Tire
from ..thresholds import MIN_ROWS_OF_CELL

FloatArray = npt.NDArray[np.float64]

_MAX_NUMBERS = 200  # cells with numbers; in more cells the numbers would be too small to read


@dataclass(frozen=True)
class Bin:
    """One bin of a residual map.

    Attributes
    ----------
    at : dict of str to float
        Its center, SI units; for a stepped channel: the level.
    mean, rms, standard_error : float
        Of the residuals in it, SI units. The standard error assumes independent rows: with ripple and drift it is
        larger.
    count : int
    """

    at: dict[str, float]
    mean: float
    rms: float
    standard_error: float
    count: int


@dataclass(frozen=True, eq=False)
class ResidualMap:
    """Residuals, measured minus computed, in bins over two inputs.

    Attributes
    ----------
    channel, signs : str
        Channel of the residuals, and sign convention of the recording.
    over : tuple of (str, str)
    edges : tuple of ndarray, shapes (n0 + 1,), (n1 + 1,)
        Ascending, SI.
    steps : tuple of ndarray, shapes (n0,) or (0,), (n1,) or (0,)
        Levels of a stepped channel; empty for a swept channel.
    mean, rms, standard_error : ndarray, shape (n0, n1)
        SI units; NaN in bins without data (standard error: with fewer than two rows).
    counts : ndarray of int, shape (n0, n1)
    """

    channel: str
    signs: str
    over: tuple[str, str]
    edges: tuple[FloatArray, FloatArray]
    steps: tuple[FloatArray, FloatArray]
    mean: FloatArray
    rms: FloatArray
    standard_error: FloatArray
    counts: npt.NDArray[np.int64]

    @property
    def middles(self) -> tuple[FloatArray, FloatArray]:
        """The levels of a stepped channel, the bin centers of a swept channel."""
        first, second = (
            steps if len(steps) else 0.5 * (edges[1:] + edges[:-1])
            for edges, steps in zip(self.edges, self.steps, strict=True)
        )
        return first, second

    @property
    def worst(self) -> Bin:
        """The bin with the largest mean by magnitude, of those with at least ten rows (if any have)."""
        i, j = self._worst
        at = {name: float(middles[k]) for name, middles, k in zip(self.over, self.middles, (i, j), strict=True)}
        error = float(self.standard_error[i, j])
        return Bin(at, float(self.mean[i, j]), float(self.rms[i, j]), error, int(self.counts[i, j]))

    @property
    def largest_mean(self) -> float:
        """The magnitude of the worst bin's mean."""
        return abs(self.worst.mean)

    @property
    def total_rms(self) -> float:
        """The root mean square of all residuals."""
        return float(np.sqrt(np.nansum(self.rms**2 * self.counts) / self.counts.sum()))

    @property
    def _worst(self) -> tuple[int, int]:
        enough = self.counts >= min(MIN_ROWS_OF_CELL, int(self.counts.max()))
        i, j = np.unravel_index(np.argmax(graded(np.where(enough, np.abs(self.mean), -1.0))), self.mean.shape)
        return int(i), int(j)


def residual_map(
    tire: TireLike,
    recording: TableLike,
    channel: str,
    over: tuple[str, str] = ("alpha", "gamma"),
    bins: int | Mapping[str, npt.ArrayLike] = 12,
) -> ResidualMap:
    """Average the residual of a tire in bins over two inputs.

    Parameters
    ----------
    tire : Tire, path of a .tir file, or name of a published tire
    recording : path, DataFrame or Recording
        In any sign convention, which is also that of the map. A DataFrame is in ISO signs.
    channel : str
        Measured output that the tire computes.
    over : tuple of (str, str)
        Columns of the recording.
    bins : int or mapping of str to array_like
        Number of bins of a swept channel, or ascending edges by channel. A stepped channel without edges has one bin
        per level. Rows outside the given edges are excluded.

    Returns
    -------
    ResidualMap

    Raises
    ------
    DataError
        If a column is missing, the tire does not compute the channel, or the bins are invalid.

    Examples
    --------
    >>> from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps
    >>> from tirefmu.tires import published
    >>> tire = published("trento_hoosier")
    >>> recording = VirtualBench(tire, Noise.none()).run(alpha_sweeps([700.0], [0.0, 0.05]))
    >>> flat = residual_map(tire, recording, "Fy")
    >>> flat.counts.shape, int(flat.counts.sum()) == len(recording), flat.largest_mean < 1e-9
    ((12, 2), True, True)
    """
    tire, recording = tire_from(tire), recording_from(recording, parameter="recording")
    table = _usable_rows(tire, recording, channel, over)
    computed = evaluate(tire, table, Conventions(recording.signs))[channel]
    residual = (table[channel] - computed).to_numpy(dtype=float)
    first, second = (_edges(table[name], name, bins) for name in over)
    edges, steps = (first[0], second[0]), (first[1], second[1])
    x, y = (table[name].to_numpy(dtype=float) for name in over)

    def total(weights: FloatArray | None = None) -> FloatArray:
        return np.asarray(np.histogram2d(x, y, edges, weights=weights)[0])

    counts = total()
    with np.errstate(invalid="ignore", divide="ignore"):
        mean, square = total(residual) / counts, total(residual**2) / counts
        variance = np.maximum(square - mean**2, 0.0) * counts / (counts - 1.0)
        error = np.where(counts > 1, np.sqrt(variance / counts), np.nan)
    if not counts.any():
        raise DataError(f"residual map of {channel}: no row is within the bins")
    integer_counts = counts.astype(np.int64)
    return ResidualMap(channel, recording.signs, over, edges, steps, mean, np.sqrt(square), error, integer_counts)


def _usable_rows(tire: Tire, recording: Recording, channel: str, over: tuple[str, str]) -> pd.DataFrame:
    if channel not in tire.outputs:
        hint = nearest(channel, tire.outputs)
        raise DataError(f"residual map: {tire.model} does not compute {channel!r}{hint}")
    if len(set(over)) != 2:
        raise DataError(f"residual map: two different channels are required, not {' and '.join(over)}")
    table = recording.table
    for name in (channel, *over):
        if name not in table:
            hint = nearest(name, [str(column) for column in table.columns])
            raise DataError(f"{recording.source}: no column {name!r} for the residual map{hint}")
    table = table[table[[channel, *over]].notna().all(axis=1)]
    if table.empty:
        raise DataError(f"{recording.source}: no row contains {channel}, {over[0]} and {over[1]}")
    return table


def _edges(values: pd.Series, name: str, bins: int | Mapping[str, npt.ArrayLike]) -> tuple[FloatArray, FloatArray]:
    """Return the bin edges, and the levels of a stepped channel; without given edges, the bins contain all values."""
    none = np.empty(0)
    if not isinstance(bins, int) and name in bins:
        edges = np.asarray(bins[name], dtype=np.float64)
        if edges.ndim != 1 or len(edges) < 2 or not (np.diff(edges) > 0.0).all():
            raise DataError(f"residual map: the edges for {name} must be at least two ascending numbers")
        return edges, none
    number = bins if isinstance(bins, int) else 12
    if number < 1:
        raise DataError(f"residual map: {number} bins for {name}: at least one is required")
    low, high = float(values.min()), float(values.max())
    steps = np.array(levels(values)) if low < high else np.array([low])
    if len(steps):
        between = 0.5 * (steps[1:] + steps[:-1])
        # The outer bins are symmetric about their level, or extend to the limits of the data.
        reach = float(np.diff(steps).min()) / 2.0 if len(steps) > 1 else 1e-9 + 1e-3 * abs(low)
        return np.array([min(low, steps[0] - reach), *between, max(high, steps[-1] + reach)]), steps
    return np.linspace(low, high, number + 1), none


def draw_residual_maps(maps: Sequence[tuple[str, ResidualMap]], path: str | Path) -> Path:
    """Draw maps side by side on one color scale, with the number of rows in each bin.

    Parameters
    ----------
    maps : sequence of (str, ResidualMap)
        Titles and maps, all of one channel and sign convention.
    path : str or Path
        PNG file; written completely or not at all.

    Returns
    -------
    Path

    Raises
    ------
    DataError
        If there is no map, their channels or conventions differ, or the file cannot be written.
    """
    from ...drawing.picture import DPI, png  # imports matplotlib, which takes its time

    image = png(residual_map_figure(maps), DPI)
    try:
        return write_whole(Path(path), image)
    except OSError as error:
        raise DataError(f"{path}: cannot be written: {error.strerror or error}") from None


def residual_map_figure(maps: Sequence[tuple[str, ResidualMap]]) -> Figure:
    """Return the figure of `draw_residual_maps`.

    Raises `DataError` if there is no map, or their channels or conventions differ.
    """
    if len({(shown.channel, shown.signs) for _, shown in maps}) != 1:
        raise DataError("residual maps on one scale require one channel and one sign convention")
    channel, signs = maps[0][1].channel, maps[0][1].signs
    limit = max(shown.largest_mean for _, shown in maps) or 1.0
    text = (
        f"numbers: rows in the bin; gray: no data; frame: largest mean of the bins with {MIN_ROWS_OF_CELL} rows or more"
    )
    panels = tuple(_map_panel(title, shown, limit) for title, shown in maps)
    return Figure("residual_map", f"Residual of {channel}", (panels,), note(signs, text))


def _map_panel(title: str, shown: ResidualMap, limit: float) -> Panel:
    worst, unit = shown.worst, drawn_unit(shown.channel)
    score = f"largest mean {worst.mean:.3g} {unit}, RMS of all rows {shown.total_rms:.3g} {unit}"
    x, y = (edges * per_si(name) for edges, name in zip(shown.edges, shown.over, strict=True))
    label = f"mean residual of {shown.channel}, measured minus computed ({unit})"
    i, j = shown._worst
    frame = [x[i], x[i + 1], x[i + 1], x[i], x[i]], [y[j], y[j], y[j + 1], y[j + 1], y[j]]
    first, second = map(axis_label, shown.over)
    return Panel(
        first, second, (Series("line", *frame, BLACK, size=1.6),), f"{title}\n{score}",
        x_limits=(x[0], x[-1]), y_limits=(y[0], y[-1]),
        cells=Cells(x, y, shown.mean, shown.counts, shown.counts.size <= _MAX_NUMBERS, limit, label),
    )  # fmt: skip
