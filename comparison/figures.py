"""Figures of two tires: forces over slip with measured points, their slope, slip stiffness and friction over load.

In the manner of figures 19 to 22 of the Trento report, which compare old and new parameters.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.measurements import Recording
from tirefmu.symbolic.escaping import figure_text
from tirefmu.tires import Tire
from tirefmu.tires.drawing.own_matplotlib import Axes, Figure, own_settings
from tirefmu.tires.drawing.style import (
    LETTER,
    TITLE_SIZE,
    draw_line,
    draw_points,
    drawn_unit,
    finish,
    held_text,
    letter,
    level_styles,
    level_text,
    per_si,
    place_legend,
    stiffness_unit,
    write_footnote,
)

from .comparison import ROLES, Comparison
from .sweeps import FURTHER, Sweep, sweeps

FloatArray = npt.NDArray[np.float64]

#: What is drawn over which slip.
PAIRS = (("Fx", "kappa"), ("Fy", "alpha"), ("Mz", "alpha"))
#: The slips of the stiffnesses among the quantities over load; the others are friction coefficients.
STIFFNESS_OVER = {"stiffness_x": "kappa", "stiffness_y": "alpha"}
#: Colors and dashes of the two tires: they differ in both.
LINES = (("#a33b00", "--"), ("#0b4f9c", "-"))
_POINTS = 201


def comparison_figures(comparison: Comparison, recordings: Sequence[Recording], signs: str) -> dict[str, Figure]:
    """Return the figures of a comparison by name.

    Parameters
    ----------
    comparison : Comparison
    recordings : sequence of Recording
    signs : {"iso", "adapted-sae", "sae"}
        Convention in which they are drawn.

    Returns
    -------
    dict of str to Figure
        What neither tire has is omitted.
    """
    measured = [recording.with_signs(signs) for recording in recordings]
    figures = {}
    for channel, slip in PAIRS:
        if not all(channel in tire.outputs and slip in tire.inputs for tire in comparison.tires):
            continue
        found = sweeps(comparison.tires[1], slip, measured)
        if signs == "sae" and not len(found[0].rows):
            found = [Sweep(slip, {"Fz": -each.load}, each.low, each.high, each.rows) for each in found]
        figures[f"{channel}_over_{slip}"] = _family(comparison, found, channel, signs, slope=False)
        if channel != "Mz":
            figures[f"{channel}_slope_over_{slip}"] = _family(comparison, found, channel, signs, slope=True)
    for role, title in ROLES.items():
        if all(tire.book.quantity(role) for tire in comparison.tires):
            figures[f"{role}_over_load"] = _over_load(comparison, role, title, signs)
    return figures


def _evaluated(tire: Tire, held: dict[str, float], name: str, values: FloatArray, signs: str) -> pd.DataFrame:
    return tire.evaluate(pd.DataFrame({**held, name: values}), signs=signs, steady=True)


@own_settings()
def _family(comparison: Comparison, found: Sequence[Sweep], channel: str, signs: str, *, slope: bool) -> Figure:
    """Return a panel for each tire with a curve for each load; both have the same axes."""
    slip = found[0].slip
    figure = Figure(figsize=(13.0, 5.2), layout="constrained")
    what = f"slope of {LETTER[channel]} over {LETTER[slip]}" if slope else f"{LETTER[channel]} over {LETTER[slip]}"
    figure.suptitle(f"Pure slip: {what}", fontweight="bold")
    unit = stiffness_unit(slip) if slope else drawn_unit(channel)
    force, over = (LETTER[name].strip("$") for name in (channel, slip))
    letters = rf"$\partial {force} / \partial {over}$" if slope else LETTER[channel]
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    for ax, tire, name in zip(panels, comparison.tires, comparison.names, strict=True):
        for sweep, style in zip(found, level_styles(len(found), "Fz"), strict=True):
            x = np.linspace(sweep.low, sweep.high, _POINTS)
            y = _evaluated(tire, sweep.held, slip, x, signs)[channel].to_numpy()
            if slope:
                y = np.gradient(y, x) / per_si(slip)
                y *= np.sign(y[np.abs(x).argmin()])  # positive where the force grows in magnitude, in every convention
            elif channel in sweep.rows:
                draw_points(ax, sweep.rows.dropna(subset=[channel]), slip, channel, style)
            draw_line(ax, x * per_si(slip), y, style, level_text("Fz", sweep.load))
        finish(ax, slip, f"{letters} ({unit})")
        ax.set_title(figure_text(name), fontsize=TITLE_SIZE)
    place_legend(panels[1], f"load {letter(signs, 'Fz')}")
    points = ["points: measured at zero camber and zero other slip"] if len(found[0].rows) else []
    held = {name: level for name, level in found[0].held.items() if name in FURTHER}
    notes = [held_text(signs, held)] if held else []
    write_footnote(figure, signs, *(["positive at zero slip"] if slope else points), *notes)
    return figure


@own_settings()
def _over_load(comparison: Comparison, role: str, title: str, signs: str) -> Figure:
    """Return the magnitude of a quantity of both tires over load, in one panel."""
    figure = Figure(figsize=(7.5, 5.0), layout="constrained")
    figure.suptitle(f"{title.capitalize()} over load", fontweight="bold")
    ax: Axes = figure.subplots()
    slip = STIFFNESS_OVER.get(role)
    scale, unit = (per_si(slip), stiffness_unit(slip)) if slip else (1.0, "-")
    ranges = [tire.ranges.get("Fz", (0.0, 2.0 * tire.values["FNOMIN"])) for tire in comparison.tires]
    for tire, name, (low, high), (color, dashes) in zip(comparison.tires, comparison.names, ranges, LINES, strict=True):
        quantity = tire.book.quantity(role)
        loads = np.linspace(max(low, 0.01 * high), high, _POINTS)  # a formula may have no meaning at other loads
        signed = -loads if signs == "sae" else loads
        values = _evaluated(tire, {}, "Fz", signed, signs)[quantity].abs() / scale
        ax.plot(loads, values, dashes, color=color, lw=1.8, label=figure_text(name))
    ax.set(xlabel=f"load {letter(signs, 'Fz')} (N)", ylabel=f"{title} ({unit})")
    ax.grid(alpha=0.3)
    ax.legend(frameon=False)
    write_footnote(figure, signs, "magnitudes at zero slip; each tire over its own range of loads")
    return figure
