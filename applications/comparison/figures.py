"""Figures and page of two tires: forces and their slopes over slip with measured points, key figures over load.

In the manner of figures 19 to 22 of the Trento report, which compare old and new parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.errors import path_from, writing
from ...boundary.escaping import figure_text
from ...drawing.figure import Figure, Panel, Series, curve, measured
from ...drawing.labels import axis_label, held_text, letter, level_text, note, per_si, stiffness_unit
from ...drawing.page import page_text, write_page
from ...drawing.picture import write_figures
from ...drawing.style import DASHED, SOLID, level_styles
from ...measurements import Recording
from ...tires import Tire
from ...tires.evaluation import Conventions, evaluate
from .comparison import ROLES, Comparison
from .sweeps import FURTHER, Sweep, sweeps

FloatArray = npt.NDArray[np.float64]

#: What is drawn over which slip.
PAIRS = (("Fx", "kappa"), ("Fy", "alpha"), ("Mz", "alpha"))
#: The slips of the stiffnesses among the quantities over load; the others are friction coefficients.
STIFFNESS_OVER = {"stiffness_x": "kappa", "stiffness_y": "alpha"}
#: Colors and dashes of the two tires: they differ in both.
LINES = (("#a33b00", DASHED), ("#0b4f9c", SOLID))
_POINTS = 201


def comparison_figures(comparison: Comparison, recordings: Sequence[Recording], signs: str) -> list[Figure]:
    """Return the figures of a comparison.

    `signs`, one of "iso", "adapted-sae", "sae": convention in which they are drawn. Returns: what neither tire has is
    omitted.
    """
    given = [recording.with_signs(signs) for recording in recordings]
    figures = []
    for channel, slip in PAIRS:
        if not all(channel in tire.outputs and slip in tire.inputs for tire in comparison.tires):
            continue
        ranges = sweeps(comparison.tires[1], slip, given)
        if signs == "sae" and not len(ranges[0].rows):
            ranges = [Sweep(slip, {"Fz": -sweep.load}, sweep.low, sweep.high, sweep.rows) for sweep in ranges]
        figures.append(_family(comparison, ranges, channel, signs, slope=False))
        if channel != "Mz":
            figures.append(_family(comparison, ranges, channel, signs, slope=True))
    for role, title in ROLES.items():
        if all(tire.symbolic_model.quantity(role) for tire in comparison.tires):
            figures.append(_over_load(comparison, role, title, signs))
    return figures


def _evaluated(tire: Tire, held: dict[str, float], name: str, values: FloatArray, signs: str) -> pd.DataFrame:
    return evaluate(tire, pd.DataFrame({**held, name: values}), Conventions(signs, steady=True))


def _family(comparison: Comparison, ranges: Sequence[Sweep], channel: str, signs: str, *, slope: bool) -> Figure:
    """Return a panel for each tire with a curve for each load; both have the same axes."""
    slip = ranges[0].slip
    panels = [
        _tire_panel(tire, name, ranges, channel, signs, slope)
        for tire, name in zip(comparison.tires, comparison.names, strict=True)
    ]
    points = ["points: measured at zero camber and zero other slip"] if len(ranges[0].rows) else []
    held = {name: level for name, level in ranges[0].held.items() if name in FURTHER}
    notes = [held_text(signs, held)] if held else []
    title = f"Pure slip: {'slope of ' * slope}{channel} over {letter(slip)}"
    text = note(signs, *(["positive at zero slip"] if slope else points), *notes)
    return Figure(f"{channel}{'_slope' * slope}_over_{slip}", title, (tuple(panels),), text)


def _tire_panel(tire: Tire, name: str, ranges: Sequence[Sweep], channel: str, signs: str, slope: bool) -> Panel:
    slip = ranges[0].slip
    points, lines = [], []
    for sweep, style in zip(ranges, level_styles(len(ranges), "Fz"), strict=True):
        label = level_text("Fz", sweep.load)
        x = np.linspace(sweep.low, sweep.high, _POINTS)
        y = _evaluated(tire, sweep.held, slip, x, signs)[channel].to_numpy()
        if slope:
            y = np.gradient(y, x) / per_si(slip)
            y *= np.sign(y[np.abs(x).argmin()])  # positive where the force grows in magnitude, in every convention
        elif channel in sweep.rows:
            points.append(measured(sweep.rows.dropna(subset=[channel]), slip, channel, style, label))
        lines.append(curve(x * per_si(slip), y, style, label))
    y_label = f"∂{channel} / ∂{letter(slip)} ({stiffness_unit(slip)})" if slope else axis_label(channel)
    return Panel(
        axis_label(slip), y_label, (*points, *lines), figure_text(name), f"load {letter('Fz', signs)}", (0.0,), (0.0,),
        x_axis="slip", y_axis="force", height=4.3,
    )  # fmt: skip


def _over_load(comparison: Comparison, role: str, title: str, signs: str) -> Figure:
    """Return the magnitude of a quantity of both tires over load, in one panel."""
    slip = STIFFNESS_OVER.get(role)
    scale, unit = (per_si(slip), stiffness_unit(slip)) if slip else (1.0, "-")
    ranges = [tire.ranges.get("Fz", (0.0, 2.0 * tire.values["FNOMIN"])) for tire in comparison.tires]
    series = []
    for tire, name, (low, high), (color, dashes) in zip(comparison.tires, comparison.names, ranges, LINES, strict=True):
        quantity = tire.symbolic_model.quantity(role)
        loads = np.linspace(max(low, 0.01 * high), high, _POINTS)  # a formula may have no meaning at other loads
        signed = -loads if signs == "sae" else loads
        values = _evaluated(tire, {}, "Fz", signed, signs)[quantity].abs() / scale
        series.append(Series("line", loads, values, color, figure_text(name), dashes, size=1.8))
    panel = Panel(f"load {letter('Fz', signs)} (N)", f"{title} ({unit})", tuple(series), height=4.1)
    text = note(signs, "magnitudes at zero slip; each tire over its own range of loads")
    return Figure(f"{role}_over_load", f"{title.capitalize()} over load", ((panel,),), text)


def write_comparison(
    comparison: Comparison, recordings: Sequence[Recording], folder: str | Path, *, signs: str = "iso"
) -> list[Path]:
    """Write the figures of a comparison and the page ``report.html``, which contains them.

    `folder`: created if it does not exist. `signs`, one of "iso", "adapted-sae", "sae": convention in which the figures
    are drawn. Returns: the page first. Raises `TirefmuError` if a file cannot be written.
    """
    folder = path_from(folder, "folder")
    figures = comparison_figures(comparison, recordings, signs)
    page = page_text("tirefmu.applications.comparison", {"short": short}, comparison=comparison, figures=figures)
    with writing(folder):
        drawn = write_figures(figures, folder)
        write_page(page, folder / "report.html")
    return [folder / "report.html", *drawn]


def short(value: float | None) -> str:
    """Return a number with five digits, or a dash where there is none."""
    return "-" if value is None else f"{value:.5g}"
