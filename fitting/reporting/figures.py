"""Figures of a tire and measurements, similar to figures 1 to 17, 19 and 20 of the Trento report."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.errors import FitError, UnknownName
from ...boundary.escaping import figure_text
from ...drawing.figure import Figure, Panel, Series, band, curve, in_rows, measured
from ...drawing.labels import LEVEL, axis_label, drawn_unit, held_text, level_text, note, per_si
from ...drawing.residual_panels import residuals_over_inputs
from ...drawing.style import BLUE, DOTTED, GRAY, GREEN, ORANGE, RED, level_colors, some_of
from ...measurements import Recording, TableLike, recordings_from
from ...tires import TireLike
from ...tires.drawing.tire_figures import PURE
from ...tires.signs import SIGNS
from ...tires.tire import Tire
from ..checks.curves import CurveFamily, MeasuredCurves, compare
from ..results.fitted import Fitted
from ..results.intervals import band as confidence_band
from ..results.records import quality
from ..temperature.fitted_temperature import FittedTemperature
from ..temperature.heat_balance import ZERO_CELSIUS, HeatBalance
from ..temperature.temperature_fit import with_temperature
from .load_figures import data_text, friction_over_load, stiffness_over_load

#: Longitudinal slips at which a weighting function is drawn over the slip angle, and points of such a curve.
WEIGHTING_LEVELS, CURVE_POINTS = 5, 201
#: Bins of a histogram of residuals.
BINS = 80
#: Slip to which a force whose peak was not measured is drawn, as a multiple of the measured one.
BEYOND_PEAK = 2.5


def draw_figures(
    tire: TireLike | Fitted,
    recordings: TableLike | Iterable[TableLike],
    folder: str | Path,
    *,
    prefix: str = "",
    truth: Tire | None = None,
    signs: str | None = "iso",
    bands: bool = False,
) -> list[Path]:
    """Draw a tire and recordings, one PNG for each kind of curve in the data.

    Parameters
    ----------
    tire : Tire, path of a .tir file, name of a published tire, or FitResult
        With a FitResult, the curves can have their 95 % bands.
    recordings : path, DataFrame or Recording, or a sequence of them
        Of any test program and sign convention.
    folder : str or Path
        Created if it does not exist.
    prefix : str
        Of the file names.
    truth : Tire, optional
        The true tire of a virtual recording: its stiffnesses are drawn, too.
    signs : str, optional
        Sign convention of the figures, stated in their footnotes: by default that of tire files; with None that of the
        recordings, or iso if they differ.
    bands : bool
        Whether 95 % bands of a FitResult are drawn.

    Returns
    -------
    list of Path
        Of ``pure_Fx``, ``pure_Fy``, ``pure_Mz``, ``combined``, ``weighting``, ``stiffness``, ``friction``,
        ``residuals_over_inputs``, ``residuals`` (over time) and ``temperature`` those for which
        there are data.

    Raises
    ------
    FitError
        If there is no recording, or a file cannot be written. No incomplete file remains.
    DataError
        If a recording has no measured output.
    """
    from ...drawing.picture import write_figures  # imports matplotlib, which takes its time

    figures = [replace(f, bands=bands) for f in figures_of(tire, recordings, truth=truth, signs=signs)]
    try:
        return write_figures(figures, Path(folder), prefix)
    except OSError as error:
        raise FitError(f"{folder}: figures cannot be written: {error.strerror or error}") from None


def figures_of(
    tire: TireLike | Fitted,
    recordings: TableLike | Iterable[TableLike],
    *,
    truth: Tire | None = None,
    signs: str | None = "iso",
) -> list[Figure]:
    """Return the figures of `draw_figures`.

    `tire`, `recordings`, `truth`, `signs`: as for `draw_figures`. Raises `FitError` if there is no recording. Raises
    `DataError` if a recording has no measured output.
    """
    fitted = tire if isinstance(tire, Fitted) and len(tire.uncertainty.complete) else None
    comparison = compare(tire.tire if isinstance(tire, Fitted) else tire, recordings, signs)
    families = [
        ("pure_Fx", "Pure longitudinal force", comparison.pure("Fx", "kappa")),
        ("pure_Fy", "Pure side force", comparison.pure("Fy", "alpha")),
        ("pure_Mz", "Aligning moment at pure side slip", comparison.pure("Mz", "alpha")),
        ("pure_Mx", "Overturning moment at pure side slip", comparison.pure("Mx", "alpha")),
        ("combined", "Forces at combined slip", comparison.combined()),
    ]
    drawn = [
        *(_families(comparison, family, name, title, fitted) for name, title, family in families if family),
        weighting_figure(comparison),
        stiffness_over_load(comparison, truth, fitted),
        friction_over_load(comparison, fitted),
        residuals_over_inputs(
            comparison.table, comparison.residuals(), comparison.signs, data_text(comparison, comparison.table)
        ),
        _residuals(comparison),
        temperature_over_time(tire.tire, tire.temperature, recordings_from(recordings))
        if isinstance(tire, Fitted) and tire.temperature
        else None,
    ]
    return [figure for figure in drawn if figure]


class NotDrawn(FitError):
    """A fit without rows that can be drawn."""


def figure_of_fit(result: Fitted, kind: str = "pure", *, bands: bool = False, signs: str = "iso") -> Figure:
    """Return a figure of the fitted rows and the tire; `FitResult.plot` documents the parameters.

    Raises `UnknownName` for a kind that does not exist or has no data, `NotDrawn` for a fit without such rows.
    """
    if signs not in SIGNS:
        raise UnknownName("sign convention", signs, SIGNS)
    recordings = _fitted_recordings(result)
    if kind == "pure":
        comparison = compare(result.tire, recordings, signs)
        families = [comparison.pure(channel, slip)[:1] for channel, slip in PURE]
        drawn = [family for families_of_channel in families for family in families_of_channel]
        if not drawn:
            raise NotDrawn("no fitted row is in pure slip: another kind of figure may have data")
        name = figure_text(result.tire.name or result.tire.model)
        return _families(comparison, drawn, "pure", f"{name}: data and fit", result if bands else None, bands)
    figures = {figure.name: figure for figure in figures_of(result if bands else result.tire, recordings, signs=signs)}
    if kind not in figures:
        raise UnknownName("kind of figure of this fit", kind, ("pure", *figures))
    return replace(figures[kind], bands=bands)


def _fitted_recordings(result: Fitted) -> list[Recording]:
    """Return the fitted rows of each recording."""
    residuals = result.residuals
    if residuals is None:
        raise NotDrawn("the result has no fitted rows")
    table = residuals.table.drop(columns=["segment"], errors="ignore")
    return [
        Recording(rows.drop(columns="recording").reset_index(drop=True), "adapted-sae", source)
        for number, source in enumerate(residuals.sources)
        if len(rows := table[table["recording"] == number])
    ]


def _families(
    comparison: MeasuredCurves, families: Sequence[CurveFamily], name: str, title: str, fitted: Fitted | None,
    bands: bool = False,
) -> Figure:  # fmt: skip
    """One panel for each family: measured points and curves of the tire."""
    rows = pd.concat([group.rows for family in families for group in family.groups])
    text = "points: data; lines: the tire at the medians of each level's conditions"
    peak = ("peak friction", families[0].channel)
    unreached = fitted is not None and any(
        not c.determined for c in fitted.findings.coverage if (c.characteristic, c.channel) == peak
    )
    text += "; dotted: extrapolation beyond data that do not reach the peak, with the prior of tires" * unreached
    panels = [_family_panel(comparison, family, fitted, unreached) for family in families]
    return Figure(name, title, in_rows(panels), note(comparison.signs, text, data_text(comparison, rows)), bands)


def _family_panel(comparison: MeasuredCurves, family: CurveFamily, fitted: Fitted | None, unreached: bool) -> Panel:
    signs, channel, slip = comparison.signs, family.channel, family.slip
    points, lines = [], []
    for group, color in zip(family.groups, level_colors(len(family.groups), family.by), strict=True):
        label = level_text(family.by, group.level)
        points.append(measured(group.rows, slip, channel, color, label))
        shown = comparison.curve(group, slip)
        measured_slips = shown[slip].min(), shown[slip].max()
        if unreached:
            shown = comparison.along(group.rows, slip, BEYOND_PEAK * np.asarray(shown[slip]))
        x = shown[slip] * per_si(slip)
        if fitted is not None:
            interval = confidence_band(fitted, channel, shown, signs)
            lines.append(band(x, interval["lower"], interval["upper"], color, label))
        inside = shown[slip].between(*measured_slips)
        lines.append(curve(x, shown[channel].where(inside), color, label))
        if unreached:
            lines.append(Series("line", x, shown[channel].where(~inside), color, label, DOTTED, size=1.2))
    rows = pd.concat([group.rows for group in family.groups])
    _, rmse, r2, _ = quality(rows[channel].to_numpy(), rows[f"{channel}_fit"].to_numpy())
    conditions = f"{channel} per {LEVEL[family.by]}, at {held_text(signs, family.held)}"
    return Panel(
        axis_label(slip), axis_label(channel), (*points, *lines),
        f"{conditions}\nRMSE of these rows {rmse:.3g} {drawn_unit(channel)}, R² {r2:.4f}",
        (0.0,), (0.0,),
    )  # fmt: skip


def weighting_figure(comparison: MeasuredCurves) -> Figure | None:
    """Weighting functions of combined slip over each slip, for levels of the other: figures 13 and 15 of the report."""
    model = comparison.tire.symbolic_model
    names = {"Fx": (model.quantity("weighting_x"), "Gxα"), "Fy": (model.quantity("weighting_y"), "Gyκ")}
    panels = []
    for family in comparison.combined():
        name, symbol = names[family.channel]
        over_kappa = [(group.level, comparison.curve(group, "kappa")) for group in family.groups]
        if family.by != "alpha" or name not in over_kappa[0][1]:
            continue
        over_alpha = _over_alpha(comparison, family)
        for slip, by, curves in (("kappa", "alpha", over_kappa), ("alpha", "kappa", over_alpha)):
            colored = zip(curves, level_colors(len(curves), by), strict=True)
            lines = [
                curve(shown[slip] * per_si(slip), shown[name], color, level_text(by, level))
                for (level, shown), color in colored
            ]
            title = f"{symbol} per {LEVEL[by]}, at {held_text(comparison.signs, family.held)}"
            panels.append(Panel(axis_label(slip), f"{symbol} (-)", tuple(lines), title, (0.0, 1.0), (0.0,)))
    text = "weighting functions of the tire (positive for a valid tire) over the measured slip range; not measurable"
    title = "Weighting functions of combined slip"
    return Figure("weighting", title, in_rows(panels), note(comparison.signs, text)) if panels else None


def _over_alpha(comparison: MeasuredCurves, family: CurveFamily) -> list[tuple[float, pd.DataFrame]]:
    """Return the tire over the measured slip angles at evenly spaced longitudinal slips from 0 to the largest."""
    rows = pd.concat([group.rows for group in family.groups])
    grid = np.linspace(min(rows["alpha"].min(), 0.0), max(rows["alpha"].max(), 0.0), CURVE_POINTS)
    levels = np.linspace(0.0, max(rows["kappa"].min(), rows["kappa"].max(), key=abs), WEIGHTING_LEVELS).tolist()
    return [(level, comparison.over(rows, {"alpha": grid, "kappa": np.full(len(grid), level)})) for level in levels]


def _residuals(comparison: MeasuredCurves) -> Figure:
    """Residuals over time and their histogram, for each recording and measured channel."""
    table = comparison.table
    rows = []
    for number, source in enumerate(comparison.sources):
        for channel in comparison.residuals():
            part = table[(table["recording"] == number) & table[channel].notna()]
            if len(part):
                rows.append(_residual_panels(number, source, channel, part))
    text = "the axes contain 99.9 % of the rows"
    notes = note(comparison.signs, text, data_text(comparison, table))
    return Figure("residuals", "Residuals: data minus tire", tuple(rows), notes)


def _residual_panels(number: int, source: str, channel: str, rows: pd.DataFrame) -> tuple[Panel, Panel]:
    residual = (rows[channel] - rows[f"{channel}_fit"]).rename("residual")
    clocked = "t" in rows and bool(rows["t"].notna().all())
    clock = rows["t"].to_numpy() if clocked else np.arange(len(rows))
    few = some_of(residual.to_frame().assign(clock=clock))
    points = Series("points", few["clock"], few["residual"], BLUE, marker="o", size=2.5, opacity=0.5)
    limit = 1.15 * float(np.quantile(residual.abs(), 0.999)) or 1.0
    counts, edges = np.histogram(residual, BINS, (-limit, limit))
    outline = np.repeat(counts, 2), np.repeat(edges, 2)[1:-1]
    histogram = Series("area", [0, *outline[0], 0], [-limit, *outline[1], limit], BLUE, opacity=0.7)
    _, rmse, r2, _ = quality(rows[channel].to_numpy(), rows[f"{channel}_fit"].to_numpy())
    unit, label = drawn_unit(channel), axis_label(channel)
    score = f"mean {residual.mean():.3g} {unit}, RMSE {rmse:.3g} {unit}, R² {r2:.4f}"
    shared: dict[str, Any] = {
        "across": (0.0,), "y_limits": (-limit, limit), "y_axis": f"{number} {channel}", "height": 1.65,
    }  # fmt: skip
    title = f"{figure_text(source)}, {channel}: {score}"
    return (
        Panel("time (s)" if clocked else "row", label, (points,), title, x_axis=f"{number}", width=8.5, **shared),
        Panel("number of rows", label, (histogram,), x_limits=(0.0, None), width=2.0, **shared),
    )  # fmt: skip


def temperature_over_time(tire: Tire, fitted: FittedTemperature, recordings: Iterable[Recording]) -> Figure:
    """Return a figure with two panels for each recording with a recorded temperature."""
    panels = []
    chosen = with_temperature(list(recordings), fitted.column)
    balances = HeatBalance.of_all(tire, chosen, fitted.column)
    for balance, start in zip(balances, fitted.starts, strict=True):
        course = balance.temperatures({}, np.array(start))
        supplied, stored = balance.energy({}, course)
        recorded = Series("points", balance.t, balance.measured - ZERO_CELSIUS, GRAY, "recorded", marker="o", size=2.0)
        colors = (BLUE, ORANGE, GREEN, RED)
        lines = [
            Series("line", balance.t, values - ZERO_CELSIUS, color, name)
            for name, values, color in zip(balance.states, course.T, colors, strict=True)
        ]
        title = figure_text(balance.source)
        panels.append(Panel("t (s)", "temperature (deg C)", (*lines, recorded), title=title))
        heats = {"from sliding and rolling": supplied, "to road and air": supplied - stored, "stored": stored}
        drawn = [
            Series("line", balance.t, heat / 1e3, color, name)
            for (name, heat), color in zip(heats.items(), (ORANGE, BLUE, GREEN), strict=True)
        ]
        panels.append(Panel("t (s)", "heat (kJ)", tuple(drawn), title=f"energy balance, {title}"))
    return Figure("temperature", "Temperature", in_rows(panels, 2), fitted.text())
