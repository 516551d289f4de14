"""Figures of a tire and measurements, similar to figures 1 to 17, 19 and 20 of the Trento report."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from tirefmu.measurements import TableLike
from tirefmu.symbolic.errors import FitError
from tirefmu.symbolic.escaping import figure_text
from tirefmu.tires import TireLike
from tirefmu.tires.drawing.own_matplotlib import Axes, Figure, own_settings
from tirefmu.tires.drawing.residual_panels import residuals_over_inputs
from tirefmu.tires.drawing.shown_figure import shown_figures, write_figures
from tirefmu.tires.drawing.style import (
    LETTER,
    LEVEL,
    SHOWN,
    TITLE_SIZE,
    draw_line,
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
from tirefmu.tires.tire import Tire

from ..evidence.curves import Comparison, Family, compare
from ..results.fit_result import FitResult
from ..results.intervals import band
from ..results.records import quality
from .captions import BANDS, data_text
from .load_figures import friction_over_load, stiffness_over_load
from .profile_figure import profile_curves

#: Longitudinal slips at which a weighting function is drawn over the slip angle, and points of such a curve.
WEIGHTING_LEVELS, CURVE_POINTS = 5, 201


def draw_figures(
    tire: TireLike | FitResult,
    recordings: TableLike | Iterable[TableLike],
    folder: str | Path,
    *,
    prefix: str = "",
    truth: Tire | None = None,
    signs: str | None = "iso",
) -> list[Path]:
    """Draw a tire and recordings, one PNG for each kind of curve in the data.

    Parameters
    ----------
    tire : Tire, path of a .tir file, name of a published tire, or FitResult
        With a FitResult, the curves of forces and slip stiffnesses have their 95 % bands.
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

    Returns
    -------
    list of Path
        Of ``pure_Fx``, ``pure_Fy``, ``pure_Mz``, ``combined``, ``weighting``, ``stiffness``, ``friction``,
        ``residuals_over_inputs``, ``residuals`` (over time) and ``profile_likelihood`` those for which there are data.

    Raises
    ------
    FitError
        If there is no recording, or a file cannot be written. No incomplete file remains.
    DataError
        If a recording has no measured output.
    """
    # All figures are rendered before the first is written: after a failure the folder is unchanged.
    drawn = shown_figures(figures_of(tire, recordings, truth=truth, signs=signs))
    try:
        return write_figures(drawn, Path(folder), prefix)
    except OSError as error:
        raise FitError(f"{folder}: figures cannot be written: {error.strerror or error}") from None


def figures_of(
    tire: TireLike | FitResult,
    recordings: TableLike | Iterable[TableLike],
    *,
    truth: Tire | None = None,
    signs: str | None = "iso",
) -> dict[str, Figure]:
    """Return the figures of `draw_figures` by name.

    Parameters
    ----------
    tire, recordings, truth, signs
        As for `draw_figures`.

    Returns
    -------
    dict of str to matplotlib.figure.Figure

    Raises
    ------
    FitError
        If there is no recording.
    DataError
        If a recording has no measured output.
    """
    fitted = tire if isinstance(tire, FitResult) and len(tire.prediction_covariance) else None
    comparison = compare(tire.tire if isinstance(tire, FitResult) else tire, recordings, signs)
    drawn: dict[str, Figure | None] = {
        "pure_Fx": _families(comparison, comparison.pure("Fx", "kappa"), "Pure longitudinal force", fitted),
        "pure_Fy": _families(comparison, comparison.pure("Fy", "alpha"), "Pure side force", fitted),
        "pure_Mz": _families(comparison, comparison.pure("Mz", "alpha"), "Aligning moment at pure side slip", fitted),
        "combined": _families(comparison, comparison.combined(), "Forces at combined slip", fitted),
        "weighting": _weighting(comparison),
        "stiffness": stiffness_over_load(comparison, truth, fitted),
        "friction": friction_over_load(comparison, fitted),
        "residuals_over_inputs": residuals_over_inputs(
            comparison.table, comparison.residuals(), comparison.signs, data_text(comparison, comparison.table)
        ),
        "residuals": _residuals(comparison),
        "profile_likelihood": profile_curves(tire) if isinstance(tire, FitResult) and tire.profiles else None,
    }
    return {name: figure for name, figure in drawn.items() if figure is not None}


@own_settings()
def _families(
    comparison: Comparison, families: Sequence[Family], title: str, fitted: FitResult | None
) -> Figure | None:
    """One panel for each family: measured points and curves of the tire."""
    if not families:
        return None
    figure, axes = panels(len(families), title)
    for ax, family in zip(axes, families, strict=True):
        _draw_family(ax, comparison, family, fitted)
    rows = pd.concat([group.rows for family in families for group in family.groups])
    note = "points: data; lines: the tire at the medians of each level's conditions" + BANDS * (fitted is not None)
    write_footnote(figure, comparison.signs, note, data_text(comparison, rows))
    return figure


def _draw_family(ax: Axes, comparison: Comparison, family: Family, fitted: FitResult | None) -> None:
    signs, channel, slip = comparison.signs, family.channel, family.slip
    styled = list(zip(family.groups, level_styles(len(family.groups), family.by), strict=True))
    for group, style in styled:
        draw_points(ax, group.rows, slip, channel, style)
    for group, style in styled:
        curve = comparison.curve(group, slip)
        draw_line(ax, curve[slip] * per_si(slip), curve[channel], style, level_text(family.by, group.level))
        if fitted is not None:
            found = band(fitted, channel, curve, signs)
            x, color = curve[slip] * per_si(slip), style.color
            ax.fill_between(x, found["lower"], found["upper"], color=color, alpha=0.25, lw=0.0)
    rows = pd.concat([group.rows for group in family.groups])
    _, rmse, r2, _ = quality(rows[channel].to_numpy(), rows[f"{channel}_fit"].to_numpy())
    unit = drawn_unit(channel)
    conditions = f"{LETTER[channel]} per {LEVEL[family.by]}, at {held_text(signs, family.held)}"
    ax.set_title(f"{conditions}\nRMSE {rmse:.3g} {unit}, R² {r2:.4f}", fontsize=TITLE_SIZE)
    finish(ax, slip, f"{LETTER[channel]} ({unit})")
    place_legend(ax, f"{LEVEL[family.by]} {letter(signs, family.by)}")


@own_settings()
def _weighting(comparison: Comparison) -> Figure | None:
    """Weighting functions of combined slip over each slip, for levels of the other: figures 13 and 15 of the report."""
    book = comparison.tire.book
    names = {
        "Fx": (book.quantity("weighting_x"), r"$G_{x\alpha}$"),
        "Fy": (book.quantity("weighting_y"), r"$G_{y\kappa}$"),
    }
    families = [family for family in comparison.combined() if family.by == "alpha"]
    shown = [family for family in families if names[family.channel][0] in comparison.curve(family.groups[0], "kappa")]
    if not shown:
        return None
    figure, axes = panels(2 * len(shown), "Weighting functions of combined slip")
    for family, over_kappa, over_alpha in zip(shown, axes[::2], axes[1::2], strict=True):
        name, symbol = names[family.channel]
        curves = [(group.level, comparison.curve(group, "kappa")) for group in family.groups]
        _draw_weighting(over_kappa, "kappa", "alpha", [(level, curve, curve[name]) for level, curve in curves])
        curves = _over_alpha(comparison, family)
        _draw_weighting(over_alpha, "alpha", "kappa", [(level, curve, curve[name]) for level, curve in curves])
        for ax, per in ((over_kappa, "slip angle"), (over_alpha, "longitudinal slip")):
            ax.set_title(f"{symbol} per {per}, at {held_text(comparison.signs, family.held)}", fontsize=TITLE_SIZE)
            ax.set_ylabel(f"{symbol} (-)")
    note = "weighting functions of the tire (positive for a valid tire) over the measured slip range; not measurable"
    write_footnote(figure, comparison.signs, note)
    return figure


def _over_alpha(comparison: Comparison, family: Family) -> list[tuple[float, pd.DataFrame]]:
    """Return the tire over the measured slip angles at evenly spaced longitudinal slips from 0 to the largest."""
    rows = pd.concat([group.rows for group in family.groups])
    grid = np.linspace(min(rows["alpha"].min(), 0.0), max(rows["alpha"].max(), 0.0), CURVE_POINTS)
    levels = np.linspace(0.0, max(rows["kappa"].min(), rows["kappa"].max(), key=abs), WEIGHTING_LEVELS).tolist()
    return [(level, comparison.over(rows, {"alpha": grid, "kappa": np.full(len(grid), level)})) for level in levels]


def _draw_weighting(ax: Axes, slip: str, by: str, curves: Sequence[tuple[float, pd.DataFrame, pd.Series]]) -> None:
    for (level, curve, values), style in zip(curves, level_styles(len(curves), by), strict=True):
        draw_line(ax, curve[slip] * per_si(slip), values, style, level_text(by, level))
    finish(ax, slip, "")
    ax.axhline(1.0, color="0.3", lw=0.8, ls=":")
    place_legend(ax, f"{LEVEL[by]} {LETTER[by]}")


@own_settings()
def _residuals(comparison: Comparison) -> Figure:
    """Residuals over time and their histogram, for each recording and measured channel."""
    table = comparison.table
    parts = [
        (source, channel, rows)
        for number, source in enumerate(comparison.sources)
        for channel in comparison.channels
        if len(rows := table[(table["recording"] == number) & table[channel].notna()])
    ]
    figure = Figure(figsize=(11, 1.0 + 1.65 * len(parts)), layout="constrained")
    figure.suptitle("Residuals: data minus tire", fontweight="bold")
    grid = figure.subplots(len(parts), 2, squeeze=False, sharey="row", width_ratios=(5, 1))
    for (over_time, spread), (source, channel, rows) in zip(grid, parts, strict=True):
        _draw_residual(over_time, spread, source, channel, rows)
    grid[-1, 1].set_xlabel("number of rows")
    note = "the axes contain 99.9 % of the rows"
    write_footnote(figure, comparison.signs, note, data_text(comparison, table))
    return figure


def _draw_residual(over_time: Axes, spread: Axes, source: str, channel: str, rows: pd.DataFrame) -> None:
    residual = (rows[channel] - rows[f"{channel}_fit"]).rename("residual")
    clocked = "t" in rows and bool(rows["t"].notna().all())
    clock = rows["t"].to_numpy() if clocked else np.arange(len(rows))
    few = some_of(residual.to_frame().assign(clock=clock), 3 * SHOWN)
    over_time.plot(
        few["clock"], few["residual"], ".", ms=2.0 if len(few) > SHOWN else 3.5, mew=0.0, color="C0", alpha=0.5
    )
    over_time.set_xlabel("time (s)" if clocked else "row")
    limit = 1.15 * float(np.quantile(residual.abs(), 0.999)) or 1.0
    over_time.set_ylim(-limit, limit)
    spread.hist(residual, bins=80, range=(-limit, limit), orientation="horizontal", color="C0", alpha=0.7)
    _, rmse, r2, _ = quality(rows[channel].to_numpy(), rows[f"{channel}_fit"].to_numpy())
    unit = drawn_unit(channel)
    score = f"mean {residual.mean():.3g} {unit}, RMSE {rmse:.3g} {unit}, R² {r2:.4f}"
    over_time.set_title(f"{figure_text(source)}, {LETTER[channel]}: {score}", fontsize=TITLE_SIZE)
    over_time.set_ylabel(f"{LETTER[channel]} ({unit})")
    for ax in (over_time, spread):
        ax.axhline(0.0, color="k", lw=0.8)
        ax.grid(alpha=0.3)
