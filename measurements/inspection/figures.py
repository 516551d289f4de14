"""Figures of an inspection: channels over time, forces over slip, the operating conditions that were visited."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ...boundary.escaping import figure_text
from ...drawing.figure import Figure, Panel, Series, in_rows, measured
from ...drawing.labels import axis_label, drawn_value, held_text, level_text, note, per_si
from ...drawing.style import BLACK, BLUE, GRAY, GREEN, LIGHT_GRAY, ORANGE, RED, level_colors, some_of
from ...numerics.arrays import BoolArray, FloatArray
from ...numerics.ties import graded
from ...symbolic.channels import CHANNELS, INPUTS, OUTPUTS
from ..operating_conditions.levels import held_levels, level_tolerance
from .inspection import Inspection

#: Points of a line over time: two for each column of pixels.
MAX_COLUMNS = 900
#: Marked rows of one reason.
MAX_MARKED = 1500
#: Color by reason of an exclusion.
EXCLUDED = {"warm-up": ORANGE, "transition": GRAY, "outlier": RED, "lifted": BLACK, "standing": BLACK}
#: The slip over which an output is drawn.
SLIP = {"Fx": "kappa", "Fy": "alpha", "Mz": "alpha", "Mx": "alpha", "My": "kappa"}


def inspection_figures(inspection: Inspection) -> list[Figure]:
    """Return the figures of a recording: over slip, over time, and the visited conditions."""
    return [*_over_slip(inspection), _over_time(inspection), *_coverage(inspection)]


def _over_time(inspection: Inspection) -> Figure:
    """Return every channel that varies over time, or over the sample without a clock; excluded rows are marked."""
    table = inspection.recording.table
    clocked = "t" in table
    x = table["t"].to_numpy() if clocked else np.arange(1.0, len(table) + 1.0)
    panels = [
        Panel(
            "time (s)" if clocked else "sample", axis_label(name), tuple(_course(inspection, name, x)),
            x_axis="time", width=6.0, height=1.3,
        )
        for name in CHANNELS if name in table and name != "t" and np.ptp(table[name].dropna()) > 0.0
    ]  # fmt: skip
    marks = [f"{reason}: {count} rows" for reason, count in inspection.exclusion.counts.items()]
    text = f"colored points: rows that a fit excludes ({', '.join(marks)})" if marks else ""
    return Figure("time", f"{figure_text(inspection.recording.source)}: channels over time", in_rows(panels), text)


def _course(inspection: Inspection, name: str, x: FloatArray) -> Iterator[Series]:
    """Yield a channel over time, interrupted between segments, and its excluded rows."""
    y = drawn_value(name, inspection.recording.table[name].to_numpy(dtype=np.float64))
    pieces = [_envelope(x[piece], y[piece], len(x)) for piece in inspection.recording.segments()]
    joined = np.hstack([np.append(piece, [[np.nan], [np.nan]], axis=1) for piece in pieces])
    yield Series("line", joined[0], joined[1], BLUE if name in INPUTS else GREEN, size=0.8)
    for reason, color in EXCLUDED.items():
        rows = np.flatnonzero(inspection.exclusion.reasons == reason)
        if len(rows):
            few = rows[:: -(-len(rows) // MAX_MARKED)]
            yield Series("points", x[few], y[few], color, reason, marker="o", size=2.5)


def _envelope(x: FloatArray, y: FloatArray, rows_of_all: int) -> FloatArray:
    """Return lowest and highest value of each part of a segment, so that no spike is lost, shape (2, n)."""
    if rows_of_all > 2 * MAX_COLUMNS:
        parts = np.array_split(np.arange(len(x)), max(1, MAX_COLUMNS * len(x) // rows_of_all))
        rows = np.concatenate([part[np.sort([np.argmin(y[part]), np.argmax(y[part])])] for part in parts])
        x, y = x[rows], y[rows]
    return np.array([x, y])


def _over_slip(inspection: Inspection) -> Iterator[Figure]:
    """Yield each output over its slip, by load at one level of the other inputs; rows at other levels are gray."""
    signs, table = inspection.recording.signs, inspection.recording.table
    included = table[inspection.exclusion.included]
    slips = {name: _slip_of(inspection, name) for name in OUTPUTS if name in table and table[name].notna().any()}
    panels = [_slip_panel(included, slip, name, signs) for name, slip in slips.items() if slip]
    if panels:
        grayed = any(series.color == LIGHT_GRAY for panel in panels for series in panel.series)
        text = note(signs, *["gray: rows with other values of the inputs in the title"] * grayed)
        yield Figure("slip", "Outputs over slip, included rows", in_rows(panels), text)


def _slip_of(inspection: Inspection, output: str) -> str:
    """Return the slip over which an output is drawn; '' if it shows nothing.

    Its own; or the other one, if only that was swept, at a level of its own that is not zero.
    """
    slip = SLIP[output]
    table, swept = inspection.recording.table, {name for sweep in inspection.sweeps for name in sweep.moving}
    varied = [name for name in ("kappa", "alpha") if name in table and np.ptp(table[name]) > 0.0]
    usable = [name for name in varied if name in swept] or varied
    if slip in usable or not usable or slip not in table:
        return slip if slip in usable else ""
    held = held_levels(table[slip])
    return usable[0] if held and max(map(abs, held)) > level_tolerance(table[slip], slip) else ""


def _slip_panel(included: pd.DataFrame, slip: str, name: str, signs: str) -> Panel:
    load = included["Fz"].abs() if "Fz" in included else pd.Series(0.0, index=included.index, name="Fz")
    levels = held_levels(load) or [float(np.median(load.to_numpy(dtype=np.float64)))]
    nearest = np.abs(load.to_numpy()[:, None] - levels).argmin(axis=1)
    held, at_levels = _held(included, slip, SLIP[name])
    others = some_of(included[~at_levels].dropna(subset=[name]))
    x, y = others[slip] * per_si(slip), others[name]
    series = [Series("points", x, y, LIGHT_GRAY, marker="o", size=2.5)] if len(others) else []
    for level, (value, color) in enumerate(zip(levels, level_colors(len(levels), "Fz"), strict=True)):
        rows = included[at_levels & (nearest == level)]
        series.append(measured(rows, slip, name, color, level_text("Fz", value)))
    return Panel(axis_label(slip), axis_label(name), tuple(series), held_text(signs, held), (0.0,), (0.0,))


def _held(rows: pd.DataFrame, slip: str, slip_of_output: str) -> tuple[dict[str, float], BoolArray]:
    """Return levels of the inputs other than slip and load, and the rows at them.

    The other slip and the camber are nearest to zero, but the slip of the output itself is at its largest level;
    further inputs are at the level of their median. An input without levels is not held.
    """
    held: dict[str, float] = {}
    at_levels = np.ones(len(rows), dtype=np.bool_)
    for name in ("kappa", "alpha", "gamma", "p", "V"):
        if name == slip or name not in rows:
            continue
        values = rows[name].to_numpy(dtype=np.float64)
        tolerance = level_tolerance(values, name)
        levels = held_levels(rows[name])
        if name in ("kappa", "alpha"):
            levels = [max(levels, key=abs)] if name == slip_of_output and levels else [0.0]
        counts = {level: int((at_levels & (np.abs(values - level) <= tolerance)).sum()) for level in levels}
        if present := [level for level, count in counts.items() if count]:
            near = 0.0 if name == "gamma" else float(np.median(values))
            distances = [graded(abs(level - near)) for level in present]
            held[name] = present[distances.index(min(distances))]
            at_levels &= np.abs(values - held[name]) <= tolerance
    return held, at_levels


def _coverage(inspection: Inspection) -> Iterator[Figure]:
    table = inspection.recording.table
    rows = some_of(table.assign(Fz=table["Fz"].abs()) if "Fz" in table else table)
    panels = [
        Panel(
            axis_label(x), axis_label(y),
            (Series("points", rows[x] * per_si(x), rows[y] * per_si(y), marker="o", size=2.5, opacity=0.5),),
        )
        for x, y in (("alpha", "kappa"), ("Fz", "gamma"), ("Fz", "p"), ("V", "T")) if {x, y} <= set(table)
    ]  # fmt: skip
    if panels:
        yield Figure("conditions", "Visited combinations of inputs", in_rows(panels))
