"""Figures over load: slip stiffnesses with slopes read from the data, and friction with the largest measured forces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.escaping import figure_text
from ...drawing.figure import Figure, Panel, Series, band, curve, in_rows
from ...drawing.labels import axis_label, held_text, letter, level_text, note, per_si, stiffness_unit
from ...drawing.style import BLACK, BLUE, DASHED, DOTTED, RED, level_colors
from ...measurements import levels
from ...numerics.arrays import FloatArray
from ...numerics.slip_slope import SLOPE_WINDOW
from ...numerics.ties import graded
from ...tires.tire import Tire
from ..checks.characteristics import Characteristic
from ..checks.curves import CurveFamily, Group, MeasuredCurves
from ..checks.slip_stiffness import SlipStiffness
from ..results.fitted import Fitted
from ..results.intervals import band as confidence_band

#: Recordings listed below a figure.
MAX_SOURCES = 30
#: Most parts of the slip range of a measured friction, and the smallest number of rows of a part.
FRICTION_PARTS, FRICTION_ROWS = 25, 5
#: Loads at which stiffnesses are evaluated, loads and slips at which the friction is.
STIFFNESS_LOADS, FRICTION_LOADS, FRICTION_SLIPS = 201, 41, 101
#: The largest drawn load, as a multiple of the largest measured one.
BEYOND = 1.25
#: Differences within which the levels of a condition and of a panel are the same: rad, Pa, m/s.
HELD = {"gamma": np.radians(0.5), "p": 3e3, "V": 1.0}


def data_text(comparison: MeasuredCurves, rows: pd.DataFrame) -> str:
    """Return the recordings of the rows and their inflation pressures as a text."""
    numbers = sorted(set(rows["recording"].tolist()))
    sources = [figure_text(name) for name in dict.fromkeys(comparison.sources[number] for number in numbers)]
    text = f"data: {', '.join(sources[:MAX_SOURCES])}"
    if len(sources) > MAX_SOURCES:
        text += f" and {len(sources) - MAX_SOURCES} more"
    if "p" not in rows or rows["p"].isna().all():
        return text
    held = [f"{level / 1000.0:.0f}" for level in levels(rows["p"])]
    span = " to ".join(f"{value / 1000.0:.0f}" for value in (rows["p"].min(), rows["p"].max()))
    return f"{text}; inflation pressure {', '.join(held) or span} kPa"


def stiffness_over_load(comparison: MeasuredCurves, truth: Tire | None, fitted: Fitted | None) -> Figure | None:
    """Slip stiffnesses over load with slopes read from the data, and slopes over slip."""
    model = comparison.tire.symbolic_model
    panels: list[Panel] = []
    rows: list[pd.DataFrame] = []
    held_constant = False
    for channel, slip in (("Fx", "kappa"), ("Fy", "alpha")):
        for family in comparison.pure(channel, slip)[:1]:
            stiffness, slope = (model.quantity(f"{kind}_{channel[1]}") for kind in ("stiffness", "slope"))
            curve = comparison.curve(family.groups[0], slip)
            if stiffness in curve:
                panels.append(_stiffness_panel(comparison, family, stiffness, truth, fitted))
            panels.append(_slopes_panel(comparison, family, slope, truth))
            held_constant |= slope in curve
            rows += [group.rows for group in family.groups]
    if not panels:
        return None
    window = f"±{np.degrees(SLOPE_WINDOW['alpha']):g} deg or ±{SLOPE_WINDOW['kappa']:g}"
    text = (
        f"points: slope of the data at zero slip, read without a tire (robust local cubic within {window}); "
        f"slope over slip: of the pure curve{', E held constant' * held_constant}, positive at zero"
    )
    dashed = ["black, dashed: the true tire"] if truth is not None else []
    sources = data_text(comparison, pd.concat(rows))
    text = note(comparison.signs, text, *dashed, sources)
    return Figure("stiffness", "Slip stiffness", in_rows(panels), text)


def _stiffness_panel(
    comparison: MeasuredCurves, family: CurveFamily, quantity: str, truth: Tire | None, fitted: Fitted | None
) -> Panel:
    sign = float(np.sign(family.groups[0].level))
    measured = [abs(group.level) for group in family.groups]
    loads = _loads(measured, STIFFNESS_LOADS)
    rows = pd.concat([group.rows for group in family.groups]).assign(**{family.slip: 0.0})
    over_load = comparison.along(rows, "Fz", sign * loads)
    half = None
    if fitted is not None:
        half = 1.96 * confidence_band(fitted, quantity, over_load, comparison.signs)["error"].to_numpy()
    series = _over_load(loads, over_load[quantity].abs().to_numpy(), half, measured)
    if truth is not None:
        true = comparison.along(rows, "Fz", sign * loads, truth)[quantity].abs()
        series.append(Series("line", loads, true, BLACK, "true tire", DASHED, size=1.2))
    read = comparison.slopes_at_zero(family) if fitted is None else _judged(fitted.findings.stiffnesses, family)
    if read:
        series.append(_read([load for load, _ in read], [value for _, value in read], "slope of the data"))
    symbol = {"kappa": "|Kxκ|", "alpha": "|Kyα|"}[family.slip]
    return Panel(
        f"load {letter('Fz', comparison.signs)} (N)", f"{symbol} ({stiffness_unit(family.slip)})", tuple(series),
        f"{symbol} over load, {held_text(comparison.signs, family.held)}",
        x_limits=(0.0, loads[-1]), y_limits=(0.0, None),
    )  # fmt: skip


def _slopes_panel(comparison: MeasuredCurves, family: CurveFamily, quantity: str, truth: Tire | None) -> Panel:
    scale = per_si(family.slip)
    series = []
    for group, color in zip(family.groups, level_colors(len(family.groups), "Fz"), strict=True):
        shown = comparison.curve(group, family.slip)
        x, slope = shown[family.slip].to_numpy(), _slopes(shown, family, quantity)
        # Positive where the force grows in magnitude with the slip, in every convention.
        sign = np.sign(slope[np.abs(x).argmin()])
        series.append(curve(x * scale, sign * slope, color, level_text("Fz", group.level)))
        if truth is not None:
            true = _slopes(comparison.curve(group, family.slip, truth), family, quantity)
            series.append(Series("line", x * scale, sign * true, BLACK, dashes=DASHED, size=0.8))
    slip = letter(family.slip)
    return Panel(
        axis_label(family.slip), f"∂{family.channel} / ∂{slip} ({stiffness_unit(family.slip)})",
        tuple(series), f"slope over {slip} per load, {held_text(comparison.signs, family.held)}",
        (0.0,), (0.0,),
    )  # fmt: skip


def _slopes(curve: pd.DataFrame, family: CurveFamily, quantity: str) -> FloatArray:
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


def _over_load(
    loads: FloatArray, values: FloatArray, half: FloatArray | None, measured: Sequence[float]
) -> list[Series]:
    """Return a quantity of the tire with its interval; beyond the measured loads, without data, dotted and thinner."""
    low, high = min(measured), max(measured)
    inside, strictly = (loads >= low) & (loads <= high), (loads > low) & (loads < high)
    return [
        *([] if half is None else [band(loads, values - half, values + half, BLUE)]),
        Series("line", loads, np.where(inside, values, np.nan), BLUE, "tire", size=2.0),
        Series("line", loads, np.where(strictly, np.nan, values), BLUE, "not measured", DOTTED, size=1.2),
    ]


def _read(loads: npt.ArrayLike, values: npt.ArrayLike, label: str) -> Series:
    return Series("points", loads, values, RED, label, marker="o", size=6.0)


def friction_over_load(comparison: MeasuredCurves, fitted: Fitted | None) -> Figure | None:
    """Largest force over load within the measured slip range, of the data and of the tire."""
    families = [*comparison.pure("Fx", "kappa")[:1], *comparison.pure("Fy", "alpha")[:1]]
    if not families:
        return None
    text = (
        "points: largest median of |force| / load of the data over parts of the slip range; line: the tire over the "
        "slip range of all loads, no peak where the data do not reach it; points are below it there, "
        "and slightly above under noise, as the largest of several medians"
    )
    rows = pd.concat([group.rows for family in families for group in family.groups])
    text = note(comparison.signs, text, data_text(comparison, rows))
    panels = [_friction_panel(comparison, family, fitted) for family in families]
    return Figure("friction", "Friction", in_rows(panels), text)


def _friction_panel(comparison: MeasuredCurves, family: CurveFamily, fitted: Fitted | None) -> Panel:
    channel, slip = family.channel, family.slip
    measured = [(abs(group.level), largest_friction(group, family)) for group in family.groups]
    rows = pd.concat([group.rows for group in family.groups])
    sign = float(np.sign(family.groups[0].level))
    loads = _loads([load for load, _ in measured], FRICTION_LOADS)
    slips = np.linspace(rows[slip].min(), rows[slip].max(), FRICTION_SLIPS)
    grid = {"Fz": sign * np.repeat(loads, len(slips)), slip: np.tile(slips, len(loads))}
    curves = comparison.over(rows, grid)
    largest = graded(curves[channel].abs().to_numpy().reshape(len(loads), -1)).argmax(axis=1)
    peaks = curves.iloc[np.arange(len(loads)) * len(slips) + largest]
    half = None
    if fitted is not None:
        half = 1.96 * confidence_band(fitted, channel, peaks, comparison.signs)["error"].to_numpy() / loads
    series = _over_load(loads, peaks[channel].abs().to_numpy() / loads, half, [load for load, _ in measured])
    read = [(load, value) for load, value in measured if np.isfinite(value)]
    if fitted is not None:
        peaks_read = [c for c in fitted.findings.characteristics if c.quantity == "peak friction" and c.shown]
        read = _judged(peaks_read, family)
    if read:
        series.append(_read([load for load, _ in read], [value for _, value in read], "data"))
    symbol = f"largest |{channel}| / |Fz|"
    return Panel(
        f"load {letter('Fz', comparison.signs)} (N)", f"{symbol} (-)", tuple(series),
        f"{symbol} over load, {held_text(comparison.signs, family.held)}", x_limits=(0.0, loads[-1]),
    )  # fmt: skip


def _judged(
    readings: Sequence[Characteristic] | Sequence[SlipStiffness], family: CurveFamily
) -> list[tuple[float, float]]:
    """Return load and value of the readings by which a fit is judged, in the conditions of a family of curves."""
    held = {name: abs(level) for name, level in family.held.items() if name in HELD}

    def inside(reading: Characteristic | SlipStiffness) -> bool:
        levels = ((abs(reading.at[name]), level, HELD[name]) for name, level in held.items() if name in reading.at)
        return reading.channel == family.channel and all(abs(at - level) <= width for at, level, width in levels)

    return [(abs(reading.load), reading.read) for reading in readings if inside(reading)]


def largest_friction(group: Group, family: CurveFamily) -> float:
    """Return the largest median of |force| / load over parts of the slip range."""
    slip = group.rows[family.slip].to_numpy(dtype=float)
    friction = (group.rows[family.channel] / group.rows["Fz"]).abs().to_numpy(dtype=float)
    parts = min(FRICTION_PARTS, max(1, len(slip) // FRICTION_ROWS))
    edges = np.linspace(slip.min(), slip.max(), parts + 1)[1:-1]
    part = np.digitize(slip, edges)
    medians = [np.median(friction[part == i]) for i in np.unique(part) if (part == i).sum() >= FRICTION_ROWS]
    return float(max(medians, default=np.nan))
