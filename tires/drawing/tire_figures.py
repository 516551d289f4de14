"""Figures of a tire by itself: pure slip, surfaces over both slips, and how Fx and Fy share the friction.

In the manner of figures 6 to 10 of the UNICAMP paper behind the published tire ``unicamp_small_tire``.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, isfinite, radians

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.errors import TirefmuError, UnknownName
from ...boundary.escaping import figure_text
from ...drawing.figure import Figure, Panel, Series, curve, in_rows, measured
from ...drawing.labels import axis_label, held_text, letter, level_text, note, per_si
from ...drawing.style import BLACK, LIGHT_GRAY, level_colors, some_of
from ..definition import TireDefinition, default_loads
from ..evaluation import Conventions, evaluate
from ..input_check import SignedTable, checked_inputs, checked_table
from ..property_file.names import not_measured, unmeasured_outputs
from ..signs import REVERSED, SIGNS, convert_signs

FloatArray = npt.NDArray[np.float64]

#: Slips beyond these are not drawn, even if the range of the tire is larger.
WIDEST = {"kappa": (-1.0, 1.0), "alpha": (-radians(20.0), radians(20.0))}
#: Largest longitudinal slip that can be requested.
MAX_KAPPA = 10.0
#: The output and the slip of each figure; the other slip is 0.
PURE = (("Fx", "kappa"), ("Fy", "alpha"), ("Mz", "alpha"))
#: Longitudinal slips that are marked where Fy is drawn against Fx.
MARKED = (-0.5, -0.2, -0.1, -0.05, 0.05, 0.1, 0.2, 0.5)
#: Measured rows are drawn at a load and as upright or in pure slip within these limits: a share, rad, 1.
NEAR_LOAD, NEAR_ZERO = 0.1, {"gamma": radians(0.5), "alpha": radians(0.5), "kappa": 0.01}
#: Largest number of loads of measured rows that are drawn, and the smallest share of rows of one.
MAX_LOADS, MIN_LOAD_SHARE = 5, 0.05
#: Measured rows are drawn within this distance of the pressure of the curves, Pa.
NEAR_PRESSURE = 3000.0
#: Points of a curve, because more would cover it.
MAX_POINTS = 400
_POINTS = 301  # of a curve


def sketched(
    tire: TireDefinition,
    loads: Sequence[float] | None,
    signs: str,
    points: pd.DataFrame | None = None,
    kappa: Sequence[float] | None = None,
) -> Sketch:
    """Return the common parts of the figures of a tire, or report what cannot be drawn.

    `points` are measured rows in ISO; their loads are the default. `kappa` is the drawn range of it, by default that of
    the tire.
    """
    if signs not in SIGNS:
        raise UnknownName("sign convention", signs, SIGNS)
    rows = None if points is None else convert_signs(points, "iso", signs)
    default = default_loads(tire) if points is None else (measured_loads(points) or default_loads(tire))
    given = default if loads is None else _checked(tire, loads)
    return Sketch(tire, signs, given, rows, None if kappa is None else _checked_range(kappa))


def points_of(tire: TireDefinition, data: pd.DataFrame | SignedTable) -> pd.DataFrame:
    """Return measured rows in ISO; an absent slip has its nominal value. Raises as `checked_table`."""
    rows, written = checked_table(tire, data, None)
    absent = {name: 0.0 for name in ("kappa", "alpha") if name not in rows}
    return convert_signs(rows, written, "iso").assign(**absent)


def measured_loads(points: pd.DataFrame) -> tuple[float, ...]:
    """Return the loads of measured rows, in ascending order: the medians of the most frequent ones.

    >>> measured_loads(pd.DataFrame({"Fz": [698.0, 700.0, 703.0, 221.0, 220.0]}))
    (220.0, 700.0)
    """
    remaining = points["Fz"].abs().to_numpy(dtype=float) if "Fz" in points else np.empty(0)
    remaining = np.sort(remaining[remaining > 0.0])
    least, loads = MIN_LOAD_SHARE * len(remaining), list[float]()
    while len(remaining) and len(loads) < MAX_LOADS:
        last = np.searchsorted(remaining, remaining * (1.0 + NEAR_LOAD), side="right")
        counts = last - np.arange(len(remaining))
        first = int(counts.argmax())
        if counts[first] < least:
            break
        load = float(np.median(remaining[first : last[first]]))
        loads.append(float(f"{load:.2g}"))
        remaining = remaining[np.abs(remaining - load) > 2.0 * NEAR_LOAD * load]
    return tuple(sorted(set(loads)))


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
        limits = self.tire.ranges.get(slip, widest)
        low, high = max(limits[0], widest[0]), min(limits[1], widest[1])
        return (low, high) if low < high else widest

    def grid(self, slip: str, count: int) -> FloatArray:
        """Return `count` slips, denser towards zero, where the forces change most; zero is included."""
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
        return some_of(rows.dropna(subset=["kappa", "alpha", *channels]), MAX_POINTS)

    def footnotes(self, slips: str = "at any slip") -> list[str]:
        """Return the common notes of all figures: the rows drawn as points, and the loads beyond the range."""
        held = [f"p = {self.tire.nominal('p') / 1000.0:.0f} kPa"] if "p" in self.tire.inputs else []
        notes = [f"model {self.tire.model}", ", ".join(["γ = 0", *held])]
        if self.points is not None:
            drawn = any(len(self.measured(load)) for load in self.loads)
            near = f"measured upright within {NEAR_LOAD:.0%} of the load"
            near += f" and {NEAR_PRESSURE / 1000.0:g} kPa of the pressure" * bool(held)
            notes.append(f"points: {near}, {slips}" if drawn else f"no row was {near}")
        for slip, (first, last) in self._requested.items():
            low, high = self.tire.ranges.get(slip, (first, last))
            if first < low or last > high:
                notes.append(f"{letter(slip)} outside {low:g} to {high:g}, for which the tire is known: extrapolated")
        low, high = self.tire.ranges.get("Fz", (0.0, float("inf")))
        beyond = [f"{load:g}" for load in self.loads if not low <= load <= high]
        if beyond:
            notes.append(f"{', '.join(beyond)} N: outside {low:g} to {high:g} N, for which the tire is known")
        unmeasured = not_measured(self.tire)
        if unmeasured:
            notes.append(f"not measured (dotted): {figure_text(', '.join(unmeasured))}")
        return notes

    def angles(self) -> FloatArray:
        """Return up to nine round slip angles over the span, in rad."""
        low, high = (end * per_si("alpha") for end in self.span("alpha"))
        steps = [step * decade for decade in (0.01, 0.1, 1.0, 10.0) for step in (1.0, 2.0, 2.5, 5.0)]
        step = next(step for step in steps if (high - low) / step <= 8.0 + 1e-9)
        first, last = ceil(low / step - 1e-9), int(np.floor(high / step + 1e-9))
        angles: FloatArray = np.radians(np.arange(first, last + 1) * step)
        return angles


def _checked(tire: TireDefinition, loads: Sequence[float]) -> tuple[float, ...]:
    for load in loads:
        if not (isfinite(load) and load > 0.0):
            raise TirefmuError(f"load {load:g} N: a load is above 0")
        checked_inputs(tire, {"Fz": load})
    if not loads:
        raise TirefmuError("no load to draw the tire at")
    # Rounded to the digits of the file names, which distinguish them.
    return tuple(dict.fromkeys(float(f"{load:g}") for load in sorted(loads)))


def _checked_range(kappa: Sequence[float]) -> tuple[float, float]:
    if len(kappa) != 2 or not -MAX_KAPPA <= kappa[0] < kappa[1] <= MAX_KAPPA:
        given = ", ".join(f"{value:g}" for value in kappa)
        raise TirefmuError(f"range of kappa {given}: two numbers from {-MAX_KAPPA:g} to {MAX_KAPPA:g}, ascending")
    return float(kappa[0]), float(kappa[1])


def pure(sketch: Sketch) -> Figure:
    """Fx over kappa, Fy and Mz over alpha, one curve for each load."""
    shown = [(channel, slip) for channel, slip in PURE if channel in sketch.channels]
    zero = [name for name, _ in PURE if name in sketch.tire.outputs and name not in sketch.channels]
    left_out = [f"{' and '.join(zero)} 0 everywhere and not drawn"] if zero else []
    text = note(sketch.signs, *sketch.footnotes("in pure slip"), *left_out)
    row = tuple(_pure_panel(sketch, channel, slip) for channel, slip in shown)
    return Figure("pure", f"{sketch.title}: pure slip", (row,), text)


def _pure_panel(sketch: Sketch, channel: str, slip: str) -> Panel:
    grid, other = sketch.grid(slip, _POINTS), "alpha" if slip == "kappa" else "kappa"
    kappa, alpha = (grid, 0.0) if slip == "kappa" else (0.0, grid)
    x = grid * per_si(slip)
    series = []
    for load, color in zip(sketch.loads, level_colors(len(sketch.loads), "Fz"), strict=True):
        forces, is_measured = sketch.over(load, kappa, alpha), channel not in unmeasured_outputs(sketch.tire)
        series.append(measured(sketch.measured(load, channel, zero=other), slip, channel, color))
        series.append(curve(x, forces[channel], color, level_text("Fz", load), is_measured=is_measured))
    return Panel(
        axis_label(slip), axis_label(channel), tuple(series), f"{channel} over {letter(slip)} at {letter(other)} = 0",
        (0.0,), (0.0,), x_limits=(x[0], x[-1]), width=4.9, height=4.0,
    )  # fmt: skip


def combined(sketch: Sketch) -> Figure:
    """Fy against Fx at constant slip angle, kappa running: one panel for each load."""
    marked = ", ".join(f"{kappa:g}" for kappa in _marked(sketch))
    low, high = sketch.span("kappa")
    text = f"lines: κ from {low:g} to {high:g}; gray: constant κ = {marked}"
    panels = [_combined_panel(sketch, load) for load in sketch.loads]
    title = f"{sketch.title}: side force against longitudinal force"
    rows = in_rows(panels, 2 if len(panels) == 4 else 3)
    return Figure("combined", title, rows, note(sketch.signs, text, *sketch.footnotes()))


def _marked(sketch: Sketch) -> list[float]:
    low, high = sketch.span("kappa")
    return [kappa for kappa in MARKED if low <= kappa <= high]


def _combined_panel(sketch: Sketch, load: float) -> Panel:
    angles, kappa = sketch.angles(), sketch.grid("kappa", _POINTS)
    across = [sketch.over(load, slip, sketch.grid("alpha", _POINTS)) for slip in _marked(sketch)]
    series = [Series("line", forces["Fx"], forces["Fy"], LIGHT_GRAY, size=0.8) for forces in across]
    for angle, color in zip(angles, level_colors(len(angles), "alpha"), strict=True):
        along = sketch.over(load, kappa, angle)
        series.append(curve(along["Fx"], along["Fy"], color, level_text("alpha", angle)))
    series.append(measured(sketch.measured(load, "Fx", "Fy"), "Fx", "Fy", BLACK))
    return Panel(
        axis_label("Fx"), axis_label("Fy"), tuple(series), f"{held_text(sketch.signs, {'Fz': load})}, per slip angle",
        (0.0,), (0.0,), width=4.9, height=4.8, equal=True,
    )  # fmt: skip
