"""Figures and page of two tires over each other: forces over slip with points, their difference, quantities over load.

In the manner of figures 19 to 22 of the Trento report, which compare old and new parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.errors import path_from, writing
from ...boundary.escaping import figure_text
from ...drawing.figure import Figure, Panel, Series, curve, measured
from ...drawing.labels import axis_label, held_text, letter, level_text, note, per_si, stiffness_unit
from ...drawing.page import page_text, write_page
from ...drawing.picture import write_figures
from ...drawing.style import DASHED, DOTTED, SOLID, level_colors
from ...measurements import Recording
from ...tires import Tire
from ...tires.evaluation import Conventions, evaluate
from ...tires.property_file.names import is_measured, unmeasured_outputs
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

    `signs`, one of "iso", "adapted-sae", "sae": convention in which they are drawn. Returns: what a tire lacks is
    omitted, and what the data of neither determined.
    """
    given = [recording.with_signs(signs) for recording in recordings]
    figures, slopes = [], []
    for channel, slip in PAIRS:
        if not all(channel in tire.outputs and slip in tire.inputs for tire in comparison.tires):
            continue
        if all(channel in unmeasured_outputs(tire) for tire in comparison.tires):
            continue
        ranges = sweeps(comparison.tires, slip, given)
        if signs == "sae" and not len(ranges[0].rows):
            ranges = [Sweep(slip, {"Fz": -sweep.load}, sweep.low, sweep.high, sweep.rows) for sweep in ranges]
        figures.append(_family(comparison, ranges, channel, signs))
        if channel != "Mz":
            slopes.append(_slopes(comparison, ranges, channel, signs))
    figures += slopes
    for role, title in ROLES.items():
        names = [tire.symbolic_model.leading(role) for tire in comparison.tires]
        if all(names) and any(is_measured(tire, role) for tire in comparison.tires):
            figures.append(_over_load(comparison, role, title, signs))
    return figures


def _evaluated(tire: Tire, held: dict[str, float], name: str, values: FloatArray, signs: str) -> pd.DataFrame:
    return evaluate(tire, pd.DataFrame({**held, name: values}), Conventions(signs, steady=True))


def _curves(comparison: Comparison, sweep: Sweep, channel: str, signs: str) -> tuple[FloatArray, list[FloatArray]]:
    """Return a slip, and a channel of both tires over it."""
    x = np.linspace(sweep.low, sweep.high, _POINTS)
    return x, [_evaluated(tire, sweep.held, sweep.slip, x, signs)[channel].to_numpy() for tire in comparison.tires]


def _dashes(measured_in: Sequence[bool]) -> list[tuple[float, ...]]:
    """Return the dashes of both tires: those of its line, or dotted if its data did not determine what is drawn."""
    return [dashes if is_measured else DOTTED for is_measured, (_, dashes) in zip(measured_in, LINES, strict=True)]


def _measured_in(comparison: Comparison, channel: str) -> list[bool]:
    return [channel not in unmeasured_outputs(tire) for tire in comparison.tires]


def _pair(
    x: FloatArray, both: Sequence[FloatArray], color: str, label: str, dashes: Sequence[tuple[float, ...]]
) -> list[Series]:
    """Return the lines of both tires at a load."""
    return [Series("line", x, y, color, label, of) for y, of in zip(both, dashes, strict=True)]


def _notes(
    comparison: Comparison, ranges: Sequence[Sweep], signs: str, measured_in: Sequence[bool], *texts: str
) -> str:
    shown = zip(("dashed", "solid"), comparison.names, measured_in, strict=True)
    lines = [
        f"{line}: {figure_text(name)}" if is_measured else f"dotted: {figure_text(name)}, not measured"
        for line, name, is_measured in shown
    ]
    held = {name: level for name, level in ranges[0].held.items() if name in FURTHER}
    return note(signs, ", ".join(lines), *texts, *([held_text(signs, held)] if held else []))


def _family(comparison: Comparison, ranges: Sequence[Sweep], channel: str, signs: str) -> Figure:
    """Return the curves of both tires at each load, and below their difference."""
    slip = ranges[0].slip
    measured_in = _measured_in(comparison, channel)
    points, lines, differences = [], [], []
    for sweep, color in zip(ranges, level_colors(len(ranges), "Fz"), strict=True):
        label = level_text("Fz", sweep.load)
        x, both = _curves(comparison, sweep, channel, signs)
        if channel in sweep.rows:
            points.append(measured(sweep.rows.dropna(subset=[channel]), slip, channel, color, label))
        lines += _pair(x * per_si(slip), both, color, label, _dashes(measured_in))
        differences.append(curve(x * per_si(slip), both[1] - both[0], color, label, is_measured=all(measured_in)))
    first, second = map(figure_text, comparison.names)
    shared: dict[str, Any] = {"across": (0.0,), "upright": (0.0,), "x_axis": "slip", "width": 9.0}
    above = Panel(axis_label(slip), axis_label(channel), (*points, *lines), height=4.3, **shared)
    below = Panel(
        axis_label(slip), axis_label(channel), tuple(differences), f"{second} minus {first}", height=2.6, **shared
    )
    texts = ["points: measured at zero camber and zero other slip"] * bool(points)
    title = f"Pure slip: {channel} over {letter(slip)}"
    text = _notes(comparison, ranges, signs, measured_in, *texts)
    return Figure(f"{channel}_over_{slip}", title, ((above,), (below,)), text)


def _slopes(comparison: Comparison, ranges: Sequence[Sweep], channel: str, signs: str) -> Figure:
    """Return the slopes of the curves of both tires at each load, positive at zero slip in every convention."""
    slip, measured_in = ranges[0].slip, _measured_in(comparison, channel)
    lines = []
    for sweep, color in zip(ranges, level_colors(len(ranges), "Fz"), strict=True):
        x, both = _curves(comparison, sweep, channel, signs)
        slopes = [np.gradient(y, x) for y in both]
        slopes = [slope * np.sign(slope[np.abs(x).argmin()]) for slope in slopes]
        lines += _pair(x * per_si(slip), slopes, color, level_text("Fz", sweep.load), _dashes(measured_in))
    y_label = f"∂{channel} / ∂{letter(slip)} ({stiffness_unit(slip)})"
    panel = Panel(axis_label(slip), y_label, tuple(lines), across=(0.0,), upright=(0.0,), width=9.0)
    title = f"Pure slip: slope of {channel} over {letter(slip)}"
    text = _notes(comparison, ranges, signs, measured_in, "positive at zero slip")
    return Figure(f"{channel}_slope_over_{slip}", title, ((panel,),), text)


def _over_load(comparison: Comparison, role: str, title: str, signs: str) -> Figure:
    """Return the magnitude of a quantity of both tires over load, in one panel."""
    slip = STIFFNESS_OVER.get(role)
    unit = stiffness_unit(slip) if slip else "-"
    ranges = [tire.ranges.get("Fz", (0.0, 2.0 * tire.values["FNOMIN"])) for tire in comparison.tires]
    measured_by = [is_measured(tire, role) for tire in comparison.tires]
    shown = zip(comparison.tires, comparison.names, ranges, LINES, _dashes(measured_by), strict=True)
    series = []
    for tire, name, (low, high), (color, _), dashes in shown:
        quantity = tire.symbolic_model.quantity(role)
        loads = np.linspace(max(low, 0.01 * high), high, _POINTS)  # a formula may have no meaning at other loads
        signed = -loads if signs == "sae" else loads
        values = _evaluated(tire, {}, "Fz", signed, signs)[quantity].abs()
        series.append(Series("line", loads, values, color, figure_text(name), dashes, size=1.8))
    panel = Panel(f"load {letter('Fz', signs)} (N)", f"{title} ({unit})", tuple(series), width=9.0)
    dotted = (
        [] if all(measured_by) else [f"dotted: {figure_text(comparison.names[measured_by.index(False)])}, not measured"]
    )
    text = note(signs, "magnitudes at zero slip; each tire over its own range of loads", *dotted)
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
    """Return a number with five digits, or a dash where there is none.

    >>> short(0.0123456), short(222105.3), short(None)
    ('0.012346', '222105', '-')
    """
    if value is None:
        return "-"
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value:.5g}"
