"""Figures of a tire by itself: pure slip, surfaces over both slips, and how Fx and Fy share the friction.

In the manner of figures 6 to 10 of the UNICAMP paper behind the published tire ``unicamp_small_tire``.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, isfinite, radians
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.symbolic.errors import TirefmuError, UnknownName
from tirefmu.symbolic.escaping import figure_text

from ..definition import TireDefinition
from ..evaluation import Conventions, evaluate
from ..signs import REVERSED, SIGNS, convert_signs
from .own_matplotlib import (
    Axes,
    Figure,
    LinearSegmentedColormap,
    MaxNLocator,
    Normalize,
    ScalarMappable,
    colormaps,
    own_settings,
)
from .style import (
    HANDLE,
    LETTER,
    draw_line,
    drawn_unit,
    finish,
    held_text,
    letter,
    level_styles,
    level_text,
    per_si,
    some_of,
    write_footnote,
)

FloatArray = npt.NDArray[np.float64]

#: The figures of a tire, by the names that `plot` takes.
KINDS = ("pure", "surfaces", "combined")
#: Slips beyond these are not drawn, however far the tire is known.
WIDEST = {"kappa": (-1.0, 1.0), "alpha": (-radians(20.0), radians(20.0))}
#: Largest longitudinal slip that can be requested.
MOST_KAPPA = 10.0
#: What is drawn over which slip, the other slip being 0.
PURE = (("Fx", "kappa"), ("Fy", "alpha"), ("Mz", "alpha"))
#: Longitudinal slips that are marked where Fy is drawn against Fx.
MARKED = (-0.5, -0.2, -0.1, -0.05, 0.05, 0.1, 0.2, 0.5)
#: Measured rows are drawn at a load and as upright or in pure slip within these limits: a share, rad, 1.
NEAR_LOAD, NEAR_ZERO = 0.1, {"gamma": radians(0.5), "alpha": radians(0.5), "kappa": 0.01}
#: Measured rows are drawn within this distance of the pressure of the curves, Pa.
NEAR_PRESSURE = 3000.0
#: Crosses of a curve, because more would cover it; and their style.
MOST_CROSSES = 400
CROSS: dict[str, Any] = {"ms": 4.0, "mew": 0.8, "alpha": 0.7}
#: Blue below 0, red above, without the dark ends on which no number can be read.
_COLORS = LinearSegmentedColormap.from_list("forces", colormaps["RdBu_r"](np.linspace(0.1, 0.9, 256)))
_POINTS = 301  # of a curve
_MESH = 81  # points of a surface along each slip


def plot(
    tire: TireDefinition, kind: str = "pure", *, loads: Sequence[float] | None = None, signs: str = "iso"
) -> Figure:
    """Return one figure of a tire; `Tire.plot` documents the parameters.

    Raises
    ------
    UnknownName
        If the kind or the convention does not exist.
    TirefmuError
        If a load is not positive, or the tire makes no force or one that is not finite.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> len(plot(published("unicamp_small_tire"), "combined", loads=[60.0, 110.0]).axes)
    2
    """
    if kind not in KINDS:
        raise UnknownName("kind of figure", kind, KINDS)
    sketch = sketched(tire, loads, signs)
    if kind == "surfaces":
        return surfaces(sketch, sketch.loads[len(sketch.loads) // 2])
    return pure(sketch) if kind == "pure" else combined(sketch)


def sketched(
    tire: TireDefinition,
    loads: Sequence[float] | None,
    signs: str,
    points: pd.DataFrame | None = None,
    kappa: Sequence[float] | None = None,
) -> Sketch:
    """Return what the figures of a tire share, or report what cannot be drawn.

    `points` are measured rows in ISO, `kappa` is the drawn range of it, by default that of the tire.
    """
    if signs not in SIGNS:
        raise UnknownName("sign convention", signs, SIGNS)
    measured = None if points is None else convert_signs(points, "iso", signs)
    given = default_loads(tire) if loads is None else _checked(loads)
    return Sketch(tire, signs, given, measured, None if kappa is None else _checked_range(kappa))


def default_loads(tire: TireDefinition) -> tuple[float, ...]:
    """Return three loads over the range in which a tire is known, as round as the range allows.

    Parameters
    ----------
    tire : TireDefinition
        Of its range, the part from a quarter of the nominal load to three times it; up to twice the nominal load
        where it has no range.

    Returns
    -------
    tuple of float
        In N; fewer where the range is a single load.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> default_loads(published("unicamp_small_tire"))
    (60.0, 110.0, 160.0)
    """
    nominal = tire.values["FNOMIN"]
    low, high = tire.ranges.get("Fz", (0.0, 2.0 * nominal))
    high = min(high, 3.0 * nominal) if high > 0.0 else 2.0 * nominal
    low = min(max(low, 0.25 * nominal), high)
    even = np.linspace(low, high, 3).tolist()
    rounded = (float(f"{load:.2g}") for load in even)
    loads = (near if low <= near <= high else load for near, load in zip(rounded, even, strict=True))
    return tuple(dict.fromkeys(loads))


class Sketch:
    """A tire, loads and a convention: evaluates what the figures show."""

    def __init__(
        self,
        tire: TireDefinition,
        signs: str,
        loads: Sequence[float],
        points: pd.DataFrame | None = None,
        kappa: tuple[float, float] | None = None,
    ) -> None:
        self.tire, self.signs, self.loads, self.points = tire, signs, tuple(loads), points
        self._requested = {} if kappa is None else {"kappa": kappa}
        self.name = tire.name or tire.model
        self.title = figure_text(self.name)
        sample = pd.concat([self.over(load, kappa, alpha) for load in loads for kappa, alpha in [self.mesh(9)]])
        self.channels = [name for name in ("Fx", "Fy", "Mz") if name in tire.outputs and sample[name].any()]
        if not self.channels:
            raise TirefmuError(f"{self.name} makes no force at {', '.join(f'{load:g}' for load in loads)} N")

    def span(self, slip: str) -> tuple[float, float]:
        """Return the requested slips, or those at which the tire is known, limited to what is drawn."""
        if slip in self._requested:
            return self._requested[slip]
        widest = WIDEST[slip]
        known = self.tire.ranges.get(slip, widest)
        low, high = max(known[0], widest[0]), min(known[1], widest[1])
        return (low, high) if low < high else widest

    def grid(self, slip: str, count: int) -> FloatArray:
        """Return `count` slips, denser towards zero, where the forces turn; zero among them."""
        low, high = self.span(slip)
        if not low < 0.0 < high:
            return np.linspace(low, high, count)
        spread = np.linspace(0.0, 1.0, count // 2 + 1) ** 1.5
        return np.concatenate([low * spread[:0:-1], high * spread])

    def mesh(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Return kappa and alpha of a surface, each of shape (count, count)."""
        kappa, alpha = np.meshgrid(self.grid("kappa", count), self.grid("alpha", count))
        return kappa, alpha

    def over(self, load: float, kappa: npt.ArrayLike, alpha: npt.ArrayLike) -> pd.DataFrame:
        """Return the forces at a load over slips that broadcast, row by row."""
        kappa, alpha = np.broadcast_arrays(np.asarray(kappa, dtype=float), np.asarray(alpha, dtype=float))
        signed = -load if "Fz" in REVERSED[self.signs] else load
        table = pd.DataFrame({"kappa": kappa.ravel(), "alpha": alpha.ravel(), "gamma": 0.0, "Fz": signed})
        forces = evaluate(self.tire, table, Conventions(self.signs))[list(self.tire.outputs)]
        for name in ("Fx", "Fy", "Mz"):
            bad = np.flatnonzero(~np.isfinite(forces[name])) if name in forces else np.array([], dtype=int)
            if bad.size:
                row = table.iloc[bad[0]]
                where = f"kappa = {row['kappa']:g}, alpha = {row['alpha']:g}, Fz = {load:g}"
                raise TirefmuError(f"{self.name}: {name} is not finite at {where}")
        return forces

    def measured(self, load: float, *channels: str, zero: str = "") -> pd.DataFrame:
        """Return measured upright rows near a load in which channels are known, where one slip is zero if given."""
        if self.points is None or not {"kappa", "alpha", "Fz", *channels} <= set(self.points):
            return pd.DataFrame(columns=["kappa", "alpha", *channels])
        rows = self.points[(self.points["Fz"].abs() - load).abs() <= NEAR_LOAD * load]
        for name in ("gamma", *([zero] if zero else [])):
            rows = rows[rows[name].abs() <= NEAR_ZERO[name]] if name in rows else rows
        if "p" in self.tire.inputs and "p" in rows:  # the pressure of the curves
            rows = rows[(rows["p"] - self.tire.nominal("p")).abs() <= NEAR_PRESSURE]
        return some_of(rows.dropna(subset=["kappa", "alpha", *channels]), MOST_CROSSES)

    def footnotes(self, crosses: str = "at any slip") -> list[str]:
        """Return what all figures have in common, which rows crosses are, and which loads are beyond the range."""
        held = [f"$p$ = {self.tire.nominal('p') / 1000.0:.0f} kPa"] if "p" in self.tire.inputs else []
        notes = [f"model {self.tire.model}", ", ".join([r"$\gamma$ = 0", *held])]
        if self.points is not None:
            drawn = any(len(self.measured(load)) for load in self.loads)
            near = f"measured upright within {NEAR_LOAD:.0%} of the load"
            near += f" and {NEAR_PRESSURE / 1000.0:g} kPa of the pressure" * bool(held)
            notes.append(f"crosses: {near}, {crosses}" if drawn else f"no row was {near}")
        for slip, (first, last) in self._requested.items():
            low, high = self.tire.ranges.get(slip, (first, last))
            if first < low or last > high:
                notes.append(f"{LETTER[slip]} outside {low:g} to {high:g}, for which the tire is known: extrapolated")
        low, high = self.tire.ranges.get("Fz", (0.0, float("inf")))
        beyond = [f"{load:g}" for load in self.loads if not low <= load <= high]
        if beyond:
            notes.append(f"{', '.join(beyond)} N: outside {low:g} to {high:g} N, for which the tire is known")
        return notes

    def angles(self) -> FloatArray:
        """Return up to nine round slip angles over the span, in rad."""
        low, high = (end * per_si("alpha") for end in self.span("alpha"))
        steps = [step * decade for decade in (0.01, 0.1, 1.0, 10.0) for step in (1.0, 2.0, 2.5, 5.0)]
        step = next(step for step in steps if (high - low) / step <= 8.0 + 1e-9)
        first, last = ceil(low / step - 1e-9), int(np.floor(high / step + 1e-9))
        angles: FloatArray = np.radians(np.arange(first, last + 1) * step)
        return angles


def _checked(loads: Sequence[float]) -> tuple[float, ...]:
    for load in loads:
        if not (isfinite(load) and load > 0.0):
            raise TirefmuError(f"load {load:g} N: a load is above 0")
    if not loads:
        raise TirefmuError("no load to draw the tire at")
    # Rounded to the digits of the file names, which distinguish them.
    return tuple(dict.fromkeys(float(f"{load:g}") for load in sorted(loads)))


def _checked_range(kappa: Sequence[float]) -> tuple[float, float]:
    if len(kappa) != 2 or not -MOST_KAPPA <= kappa[0] < kappa[1] <= MOST_KAPPA:
        given = ", ".join(f"{value:g}" for value in kappa)
        raise TirefmuError(f"range of kappa {given}: two numbers from {-MOST_KAPPA:g} to {MOST_KAPPA:g}, ascending")
    return float(kappa[0]), float(kappa[1])


@own_settings()
def pure(sketch: Sketch) -> Figure:
    """Fx over kappa, Fy and Mz over alpha, one curve for each load."""
    shown = [(channel, slip) for channel, slip in PURE if channel in sketch.channels]
    figure = Figure(figsize=(4.9 * len(shown) + 1.2, 4.9), layout="constrained")
    figure.suptitle(f"{sketch.title}: pure slip", fontweight="bold")
    for ax, (channel, slip) in zip(figure.subplots(1, len(shown), squeeze=False)[0], shown, strict=True):
        grid, other = sketch.grid(slip, _POINTS), "alpha" if slip == "kappa" else "kappa"
        kappa, alpha = (grid, 0.0) if slip == "kappa" else (0.0, grid)
        for load, style in zip(sketch.loads, level_styles(len(sketch.loads), "Fz"), strict=True):
            curve = sketch.over(load, kappa, alpha)[channel]
            draw_line(ax, grid * per_si(slip), curve, style, level_text("Fz", load))
            rows = sketch.measured(load, channel, zero=other)
            ax.plot(rows[slip] * per_si(slip), rows[channel], "x", color=style.color, **CROSS)
        finish(ax, slip, f"{LETTER[channel]} ({drawn_unit(channel)})")
        ax.set_title(f"{LETTER[channel]} over {LETTER[slip]} at {LETTER[other]} = 0", fontsize=10)
        ax.margins(x=0.0)
    _shared_legend(figure, ax, f"load {letter(sketch.signs, 'Fz')}")
    write_footnote(figure, sketch.signs, *sketch.footnotes("in pure slip"), *_left_out(sketch))
    return figure


def _left_out(sketch: Sketch) -> list[str]:
    zero = [LETTER[name] for name, _ in PURE if name in sketch.tire.outputs and name not in sketch.channels]
    return [f"{' and '.join(zero)} 0 everywhere and not drawn"] if zero else []


def _shared_legend(figure: Figure, ax: Axes, title: str) -> None:
    """Add one legend for all axes."""
    handles, labels = ax.get_legend_handles_labels()
    where: dict[str, Any] = {"loc": "outside right center", "frameon": False}
    figure.legend(handles, labels, title=title, fontsize=9, handlelength=HANDLE, **where)


@own_settings()
def surfaces(sketch: Sketch, load: float) -> Figure:
    """Fx and Fy over both slips at one load: as surfaces, and below as maps to read values from."""
    shown = [name for name in ("Fx", "Fy") if name in sketch.channels] or sketch.channels
    kappa, alpha = sketch.mesh(_MESH)
    forces = sketch.over(load, kappa, alpha)
    figure = Figure(figsize=(6.2 * len(shown), 10.2), layout="constrained")
    loaded = f"{letter(sketch.signs, 'Fz')} = {level_text('Fz', load)}"
    figure.suptitle(f"{sketch.title}: forces in combined slip at {loaded}", fontweight="bold")
    for column, channel in enumerate(shown, start=1):
        force = forces[channel].to_numpy().reshape(kappa.shape)
        top = float(np.abs(force).max())
        norm = Normalize(-top, top)
        solid = figure.add_subplot(2, len(shown), column, projection="3d")
        _draw_solid(solid, kappa, alpha, force, norm, channel)
        rows = sketch.measured(load, channel)
        x, y = (rows[slip].to_numpy(dtype=float) * per_si(slip) for slip in ("kappa", "alpha"))
        solid.plot(x, y, rows[channel].to_numpy(dtype=float), "kx", zorder=9, **CROSS)
        flat = figure.add_subplot(2, len(shown), len(shown) + column)
        _draw_map(flat, kappa, alpha, force, norm)
        bar = figure.colorbar(ScalarMappable(norm, _COLORS), ax=flat, shrink=0.9, pad=0.02)
        bar.set_label(f"{LETTER[channel]} ({drawn_unit(channel)})")
    write_footnote(figure, sketch.signs, *sketch.footnotes())
    return figure


def _draw_solid(
    ax: Any, kappa: FloatArray, alpha: FloatArray, force: FloatArray, norm: Normalize, channel: str
) -> None:
    x, y = kappa * per_si("kappa"), alpha * per_si("alpha")
    ax.plot_surface(x, y, force, cmap=_COLORS, norm=norm, rcount=41, ccount=41, edgecolor="0.25", linewidth=0.2)
    ax.set(xlabel=f"{LETTER['kappa']} ({drawn_unit('kappa')})", ylabel=f"{LETTER['alpha']} ({drawn_unit('alpha')})")
    ax.zaxis.set_rotate_label(False)
    ax.set_zlabel(f"{LETTER[channel]} ({drawn_unit(channel)})", rotation=90.0)
    ax.set_title(f"{LETTER[channel]} over {LETTER['kappa']} and {LETTER['alpha']}", fontsize=10, y=0.98)
    # Seen from the low side: no valley hides behind a hill.
    azimuth = -128.0 if channel == "Fx" else -55.0 if np.sum(force * alpha) > 0.0 else 55.0
    ax.view_init(elev=24.0, azim=azimuth)
    ax.set_box_aspect((1.0, 1.0, 0.8), zoom=1.0)
    ax.tick_params(labelsize=8)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(5))


def _draw_map(ax: Axes, kappa: FloatArray, alpha: FloatArray, force: FloatArray, norm: Normalize) -> None:
    x, y = kappa * per_si("kappa"), alpha * per_si("alpha")
    ax.contourf(x, y, force, levels=41, cmap=_COLORS, norm=norm)
    if np.ptp(force) > 0.0:
        lines = ax.contour(x, y, force, levels=11, colors="0.15", linewidths=0.7)
        ax.clabel(lines, fontsize=7, fmt="%g")
    ax.set(xlabel=f"{LETTER['kappa']} ({drawn_unit('kappa')})", ylabel=f"{LETTER['alpha']} ({drawn_unit('alpha')})")


@own_settings()
def combined(sketch: Sketch) -> Figure:
    """Fy against Fx at constant slip angle, kappa running: one panel for each load."""
    columns = 2 if len(sketch.loads) == 4 else min(len(sketch.loads), 3)
    rows = ceil(len(sketch.loads) / columns)
    figure = Figure(figsize=(4.9 * columns + 1.2, 0.9 + 4.8 * rows), layout="constrained")
    figure.suptitle(f"{sketch.title}: side force against longitudinal force", fontweight="bold")
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for unused in axes[len(sketch.loads) :]:
        unused.remove()
    for ax, load in zip(axes, sketch.loads, strict=False):
        _draw_shared(ax, sketch, load)
    _shared_legend(figure, axes[0], f"slip angle {LETTER['alpha']}")
    marked = ", ".join(f"{kappa:g}" for kappa in _marked(sketch))
    low, high = sketch.span("kappa")
    note = f"lines: {LETTER['kappa']} from {low:g} to {high:g}; grey: constant {LETTER['kappa']} = {marked}"
    write_footnote(figure, sketch.signs, note, *sketch.footnotes())
    return figure


def _marked(sketch: Sketch) -> list[float]:
    low, high = sketch.span("kappa")
    return [kappa for kappa in MARKED if low <= kappa <= high]


def _draw_shared(ax: Axes, sketch: Sketch, load: float) -> None:
    angles, kappa = sketch.angles(), sketch.grid("kappa", _POINTS)
    for slip in _marked(sketch):
        across = sketch.over(load, slip, sketch.grid("alpha", _POINTS))
        ax.plot(across["Fx"], across["Fy"], color="0.75", lw=0.8, zorder=1)
    for angle, style in zip(angles, level_styles(len(angles), "alpha"), strict=True):
        along = sketch.over(load, kappa, angle)
        draw_line(ax, along["Fx"], along["Fy"], style, level_text("alpha", angle))
    rows = sketch.measured(load, "Fx", "Fy")
    ax.plot(rows["Fx"], rows["Fy"], "kx", zorder=1, **CROSS)
    ax.set_title(held_text(sketch.signs, {"Fz": load}), fontsize=10)
    ax.set(xlabel=f"{LETTER['Fx']} ({drawn_unit('Fx')})", ylabel=f"{LETTER['Fy']} ({drawn_unit('Fy')})")
    ax.set_aspect("equal", adjustable="datalim")
    ax.xaxis.set_major_locator(MaxNLocator(6))
    ax.grid(alpha=0.3)
    ax.axhline(0.0, color="0.3", lw=0.8)
    ax.axvline(0.0, color="0.3", lw=0.8)
