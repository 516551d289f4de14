"""Figures of an inspection: channels over time, forces over slip, the operating conditions that were visited."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tirefmu.tires.drawing.own_matplotlib import Figure, own_settings
from tirefmu.tires.drawing.style import (
    LETTER,
    NOTE_SIZE,
    TITLE_SIZE,
    draw_points,
    drawn_unit,
    finish,
    held_text,
    letter,
    level_styles,
    level_text,
    panels,
    per_si,
    place_legend,
    some_of,
    write_footnote,
)

from ..channels import CHANNELS, INPUTS, OUTPUTS
from ..operating_conditions.levels import held_levels, level_tolerance
from .inspection import Inspection

#: Points of a line over time: two for each column of pixels.
MOST_COLUMNS = 900
#: Color by reason of an exclusion.
EXCLUDED = {"warm-up": "tab:orange", "transition": "tab:gray", "outlier": "tab:red", "lifted": "k", "standing": "k"}
#: The slip over which an output is drawn.
SLIP = {"Fx": "kappa", "Fy": "alpha", "Mz": "alpha", "Mx": "alpha", "My": "kappa"}


def inspection_figures(inspection: Inspection) -> dict[str, Figure]:
    """Draw a recording: over time, over slip, and the visited conditions.

    Parameters
    ----------
    inspection : Inspection

    Returns
    -------
    dict of str to matplotlib.figure.Figure
        By name.
    """
    drawn = {"time": _over_time(inspection), "slip": _over_slip(inspection), "conditions": _coverage(inspection)}
    return {name: figure for name, figure in drawn.items() if figure is not None}


@own_settings()
def _over_time(inspection: Inspection) -> Figure:
    """Draw every channel over time, or over the sample without a clock; excluded rows are marked."""
    table = inspection.recording.table
    names = [name for name in CHANNELS if name in table and name != "t"]
    clock = "t" in table
    x = table["t"].to_numpy() if clock else np.arange(1.0, len(table) + 1.0)
    figure = Figure(figsize=(12.0, 0.9 + 1.15 * len(names)), layout="constrained")
    figure.suptitle(f"{inspection.recording.source}: channels over time", fontweight="bold", parse_math=False)
    axes = figure.subplots(len(names), 1, sharex=True, squeeze=False).ravel()
    for name, ax in zip(names, axes, strict=True):
        y = table[name].to_numpy(dtype=np.float64) * per_si(name)
        for piece in inspection.recording.segments():
            ax.plot(*_envelope(x[piece], y[piece]), color="tab:blue" if name in INPUTS else "tab:green", lw=0.8)
        for reason, color in EXCLUDED.items():
            rows = inspection.exclusion.reasons == reason
            if rows.any():
                ax.plot(
                    x[rows],
                    y[rows],
                    ".",
                    ms=3,
                    color=color,
                    label=f"{reason}, {rows.sum()} row{'s' * bool(rows.sum() != 1)}",
                )
        ax.set_ylabel(f"{LETTER[name]}\n({drawn_unit(name)})", fontsize=NOTE_SIZE)
        ax.tick_params(labelsize=NOTE_SIZE)
        ax.grid(alpha=0.3)
    axes[-1].set_xlabel("time (s)" if clock else "sample")
    if inspection.exclusion.counts:
        place_legend(axes[0], "excluded")
    return figure


def _envelope(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return lowest and highest value of each of a few hundred parts, so that no spike is lost."""
    if len(x) <= 2 * MOST_COLUMNS:
        return x, y
    parts = np.array_split(np.arange(len(x)), MOST_COLUMNS)
    rows = np.concatenate([part[np.sort([np.argmin(y[part]), np.argmax(y[part])])] for part in parts])
    return x[rows], y[rows]


@own_settings()
def _over_slip(inspection: Inspection) -> Figure | None:
    """Draw each output over its slip, by load at one level of the other inputs; rows at other levels are gray."""
    signs, table = inspection.recording.signs, inspection.recording.table
    pairs = [
        (SLIP[name], name) for name in OUTPUTS if name in table and SLIP[name] in table and table[name].notna().any()
    ]
    if not pairs:
        return None
    included = table[inspection.exclusion.included]
    load = included["Fz"].abs() if "Fz" in included else pd.Series(0.0, index=included.index, name="Fz")
    levels = held_levels(load) or [float(np.median(load.to_numpy(dtype=np.float64)))]
    nearest = np.abs(load.to_numpy()[:, None] - levels).argmin(axis=1)
    figure, axes = panels(len(pairs), "Outputs over slip, included rows")
    grayed = False
    for (slip, name), ax in zip(pairs, axes, strict=True):
        held, at_levels = _held(included, slip)
        others = some_of(included[~at_levels].dropna(subset=[name]))
        grayed |= len(others) > 0
        ax.plot(others[slip] * per_si(slip), others[name], ".", ms=2.5, mew=0.0, color="0.8", zorder=0)
        for level, (value, style) in enumerate(zip(levels, level_styles(len(levels), "Fz"), strict=True)):
            draw_points(ax, included[at_levels & (nearest == level)], slip, name, style)
            ax.plot([], [], style.marker, ms=4, color=style.color, label=level_text("Fz", value))
        ax.set_title(held_text(signs, held), fontsize=TITLE_SIZE)
        finish(ax, slip, f"{LETTER[name]} ({drawn_unit(name)})")
        place_legend(ax, f"load {letter(signs, 'Fz')}")
    write_footnote(figure, signs, *["gray: rows with other values of the inputs in the title"] * grayed)
    return figure


def _held(rows: pd.DataFrame, slip: str) -> tuple[dict[str, float], NDArray[np.bool_]]:
    """Return levels of the inputs other than slip and load, and the rows at them.

    Other slips and the camber are nearest to zero, further inputs at their level with the most rows. An input without
    levels is not held.
    """
    held: dict[str, float] = {}
    at_levels = np.ones(len(rows), dtype=np.bool_)
    for name in ("kappa", "alpha", "gamma", "p", "V"):
        if name == slip or name not in rows:
            continue
        values = rows[name].to_numpy(dtype=np.float64)
        tolerance = level_tolerance(values, name)
        known = [0.0] if name in ("kappa", "alpha") else held_levels(rows[name])
        counts = {level: int((at_levels & (np.abs(values - level) <= tolerance)).sum()) for level in known}
        present = {level: count for level, count in counts.items() if count}
        if present:
            held[name] = min(present, key=abs) if name == "gamma" else max(present, key=present.__getitem__)
            at_levels &= np.abs(values - held[name]) <= tolerance
    return held, at_levels


@own_settings()
def _coverage(inspection: Inspection) -> Figure | None:
    """Draw the visited combinations of inputs."""
    table = inspection.recording.table
    pairs = [(x, y) for x, y in (("alpha", "kappa"), ("Fz", "gamma"), ("Fz", "p"), ("V", "T")) if {x, y} <= set(table)]
    if not pairs:
        return None
    figure, axes = panels(len(pairs), "Visited combinations of inputs")
    rows = some_of(table.assign(Fz=table["Fz"].abs()) if "Fz" in table else table)
    letters = {**LETTER, "Fz": "load"}
    for (x, y), ax in zip(pairs, axes, strict=True):
        ax.plot(rows[x] * per_si(x), rows[y] * per_si(y), ".", ms=2.5, mew=0.0, alpha=0.5)
        ax.set(xlabel=f"{letters[x]} ({drawn_unit(x)})", ylabel=f"{letters[y]} ({drawn_unit(y)})")
        ax.grid(alpha=0.3)
    return figure
