"""Figures over load: slip stiffnesses with slopes read from the data, and friction with the largest measured forces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.estimation.slip_slope import SLOPE_WINDOW
from tirefmu.tires.drawing.own_matplotlib import Axes, Figure, own_settings
from tirefmu.tires.drawing.style import (
    LETTER,
    TITLE_SIZE,
    draw_line,
    finish,
    held_text,
    letter,
    level_styles,
    level_text,
    panels,
    per_si,
    place_legend,
    stiffness_unit,
    write_footnote,
)
from tirefmu.tires.tire import Tire

from ..evidence.curves import Comparison, Family, Group
from ..results.fit_result import FitResult
from ..results.intervals import band
from .captions import BANDS, data_text

#: Most parts of the slip range of a measured friction, and the smallest number of rows of a part.
FRICTION_PARTS, FRICTION_ROWS = 25, 5
#: Loads at which stiffnesses are evaluated, loads and slips at which the friction is.
STIFFNESS_LOADS, FRICTION_LOADS, FRICTION_SLIPS = 201, 41, 101
#: The largest drawn load, as a multiple of the largest measured one.
BEYOND = 1.25

FloatArray = npt.NDArray[np.float64]


@own_settings()
def stiffness_over_load(comparison: Comparison, truth: Tire | None, fitted: FitResult | None) -> Figure | None:
    """Slip stiffnesses over load with slopes read from the data, and slopes over slip."""
    book = comparison.tire.book
    kinds = [
        (channel, slip, book.quantity(f"stiffness_{channel[1]}"), book.quantity(f"slope_{channel[1]}"))
        for channel, slip in (("Fx", "kappa"), ("Fy", "alpha"))
    ]
    shown: list[Family] = []
    draws: list[Callable[[Axes], None]] = []
    held_constant = False
    for channel, slip, stiffness, slope in kinds:
        families = comparison.pure(channel, slip)
        if not families:
            continue
        family = families[0]
        known = comparison.curve(family.groups[0], slip)
        if stiffness in known:
            draws.append(partial(_draw_stiffness, comparison, family, stiffness, truth, fitted))
        draws.append(partial(_draw_slopes, comparison, family, slope, truth))
        held_constant |= slope in known
        shown.append(family)
    if not draws:
        return None
    figure, axes = panels(len(draws), "Slip stiffness")
    for ax, draw in zip(axes, draws, strict=True):
        draw(ax)
    window = f"±{np.degrees(SLOPE_WINDOW['alpha']):g} deg or ±{SLOPE_WINDOW['kappa']:g}"
    note = (
        f"points: slope of the data at zero slip, read without a tire (robust local cubic within {window}); "
        f"slope over slip: of the pure curve{', E held constant' * held_constant}, positive at zero"
    )
    note += BANDS * (fitted is not None)
    dashed = ["black, dashed: the true tire"] if truth is not None else []
    rows = pd.concat([group.rows for family in shown for group in family.groups])
    write_footnote(figure, comparison.signs, note, *dashed, data_text(comparison, rows))
    return figure


def _draw_stiffness(
    comparison: Comparison, family: Family, quantity: str, truth: Tire | None, fitted: FitResult | None, ax: Axes
) -> None:
    sign = float(np.sign(family.groups[0].level))
    measured = [abs(group.level) for group in family.groups]
    loads = _loads(measured, STIFFNESS_LOADS)
    rows = pd.concat([group.rows for group in family.groups]).assign(**{family.slip: 0.0})
    curve = comparison.along(rows, "Fz", sign * loads)
    stiffness = curve[quantity].abs() / per_si(family.slip)
    _draw_over_load(ax, loads, stiffness.to_numpy(), measured)
    if fitted is not None:
        half = 1.96 * band(fitted, quantity, curve, comparison.signs)["error"] / per_si(family.slip)
        ax.fill_between(loads, stiffness - half, stiffness + half, color="C0", alpha=0.25, lw=0.0)
    if truth is not None:
        true = comparison.along(rows, "Fz", sign * loads, truth)[quantity].abs() / per_si(family.slip)
        ax.plot(loads, true, color="k", lw=1.2, ls="--", label="true tire")
    read = np.array(comparison.slopes_at_zero(family)).reshape(-1, 2)
    slopes = read[:, 1] / per_si(family.slip)
    if len(read):
        ax.plot(read[:, 0], slopes, "o", color="C3", ms=6, mec="white", label="slope of the data")
    symbol = {"kappa": r"$|K_{x\kappa}|$", "alpha": r"$|K_{y\alpha}|$"}[family.slip]
    ax.set_title(f"{symbol} over load, {held_text(comparison.signs, family.held)}", fontsize=TITLE_SIZE)
    ax.set(xlabel=f"load {letter(comparison.signs, 'Fz')} (N)")
    ax.set(ylabel=f"{symbol} ({stiffness_unit(family.slip)})", xlim=(0.0, loads[-1]))
    ax.set_ylim(bottom=0.0)
    ax.grid(alpha=0.3)
    place_legend(ax)


def _draw_slopes(comparison: Comparison, family: Family, quantity: str, truth: Tire | None, ax: Axes) -> None:
    scale = per_si(family.slip)
    for group, style in zip(family.groups, level_styles(len(family.groups), "Fz"), strict=True):
        curve = comparison.curve(group, family.slip)
        x, slope = curve[family.slip].to_numpy(), _slopes(curve, family, quantity)
        # Positive where the force grows in magnitude with the slip, in every convention.
        sign = np.sign(slope[np.abs(x).argmin()])
        draw_line(ax, x * scale, sign * slope / scale, style, level_text("Fz", group.level))
        if truth is not None:
            true = _slopes(comparison.curve(group, family.slip, truth), family, quantity)
            ax.plot(x * scale, sign * true / scale, "k--", lw=0.8, zorder=4)
    force, slip = LETTER[family.channel].strip("$"), LETTER[family.slip].strip("$")
    held = held_text(comparison.signs, family.held)
    ax.set_title(f"slope over {LETTER[family.slip]} per load, {held}", fontsize=TITLE_SIZE)
    finish(ax, family.slip, rf"$\partial {force} / \partial {slip}$ ({stiffness_unit(family.slip)})")
    place_legend(ax, f"load {letter(comparison.signs, 'Fz')}")


def _slopes(curve: pd.DataFrame, family: Family, quantity: str) -> FloatArray:
    """Return the slope of a curve: the model's quantity, or the derivative by differences if the model has none."""
    if quantity in curve:
        return curve[quantity].to_numpy(dtype=np.float64)
    force, slip = (curve[name].to_numpy(dtype=np.float64) for name in (family.channel, family.slip))
    slopes: FloatArray = np.gradient(force, slip)
    return slopes


def _loads(measured: Sequence[float], points: int) -> FloatArray:
    """Return loads from nearly zero to a quarter beyond the largest measured one; the ends of these are among them."""
    loads = np.linspace(0.0, BEYOND * max(measured), points)[1:]
    return np.unique(np.append(loads, [min(measured), max(measured)]))


def _draw_over_load(ax: Axes, loads: FloatArray, values: FloatArray, measured: Sequence[float]) -> None:
    """Draw a quantity of the tire; beyond the measured loads, where no data support it, dotted and thinner."""
    low, high = min(measured), max(measured)
    inside, strictly = (loads >= low) & (loads <= high), (loads > low) & (loads < high)
    ax.plot(loads, np.where(inside, values, np.nan), color="C0", lw=2, label="tire")
    ax.plot(loads, np.where(strictly, np.nan, values), color="C0", lw=1.2, ls=":", label="beyond the\nmeasured loads")


@own_settings()
def friction_over_load(comparison: Comparison, fitted: FitResult | None) -> Figure | None:
    """Largest force over load within the measured slip range, of the data and of the tire."""
    families = [comparison.pure(channel, slip)[:1] for channel, slip in (("Fx", "kappa"), ("Fy", "alpha"))]
    shown = [family for found in families for family in found]
    if not shown:
        return None
    figure, axes = panels(len(shown), "Friction")
    for ax, family in zip(axes, shown, strict=True):
        _draw_friction(ax, comparison, family, fitted)
    note = "points: largest median of |force| / load of the data over parts of the slip range; line: the tire over the "
    note += "slip range of all loads; points are below it where the data do not reach the peak, "
    note += "and slightly above under noise, as the largest of several medians"
    rows = pd.concat([group.rows for family in shown for group in family.groups])
    write_footnote(figure, comparison.signs, note + BANDS * (fitted is not None), data_text(comparison, rows))
    return figure


def _draw_friction(ax: Axes, comparison: Comparison, family: Family, fitted: FitResult | None) -> None:
    channel, slip = family.channel, family.slip
    measured = [(abs(group.level), _largest_friction(group, family)) for group in family.groups]
    rows = pd.concat([group.rows for group in family.groups])
    sign = float(np.sign(family.groups[0].level))
    loads = _loads([load for load, _ in measured], FRICTION_LOADS)
    slips = np.linspace(rows[slip].min(), rows[slip].max(), FRICTION_SLIPS)
    grid = {"Fz": sign * np.repeat(loads, len(slips)), slip: np.tile(slips, len(loads))}
    curves = comparison.over(rows, grid)
    largest = curves[channel].abs().to_numpy().reshape(len(loads), -1).argmax(axis=1)
    peaks = curves.iloc[np.arange(len(loads)) * len(slips) + largest]
    friction = peaks[channel].abs().to_numpy() / loads
    _draw_over_load(ax, loads, friction, [load for load, _ in measured])
    if fitted is not None:
        half = 1.96 * band(fitted, channel, peaks, comparison.signs)["error"].to_numpy() / loads
        ax.fill_between(loads, friction - half, friction + half, color="C0", alpha=0.25, lw=0.0)
    read = [(load, value) for load, value in measured if np.isfinite(value)]
    if read:
        ax.plot(*np.transpose(read), "o", color="C3", ms=6, mec="white", label="data")
    symbol = f"largest |{LETTER[channel]}| / |{LETTER['Fz']}|"
    ax.set_title(f"{symbol} over load, {held_text(comparison.signs, family.held)}", fontsize=TITLE_SIZE)
    ax.set(xlabel=f"load {letter(comparison.signs, 'Fz')} (N)", ylabel=f"{symbol} (-)", xlim=(0.0, loads[-1]))
    ax.grid(alpha=0.3)
    place_legend(ax)


def _largest_friction(group: Group, family: Family) -> float:
    """Return the largest median of |force| / load over parts of the slip range."""
    slip = group.rows[family.slip].to_numpy(dtype=float)
    friction = (group.rows[family.channel] / group.rows["Fz"]).abs().to_numpy(dtype=float)
    parts = min(FRICTION_PARTS, max(1, len(slip) // FRICTION_ROWS))
    edges = np.linspace(slip.min(), slip.max(), parts + 1)[1:-1]
    part = np.digitize(slip, edges)
    medians = [np.median(friction[part == i]) for i in np.unique(part) if (part == i).sum() >= FRICTION_ROWS]
    return float(max(medians, default=np.nan))
