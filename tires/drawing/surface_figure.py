"""Figures of a tire as matplotlib draws them: one for a notebook, and Fx and Fy over both slips."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.errors import TirefmuError, UnknownName
from ...drawing.labels import axis_label, held_text, letter, note, per_si
from ...drawing.own_matplotlib import (
    Axes,
    LinearSegmentedColormap,
    MatplotlibFigure,
    MaxNLocator,
    Normalize,
    ScalarMappable,
    colormaps,
    own_settings,
)
from ...drawing.picture import html_image, picture, write_note
from ..definition import TireDefinition
from .tire_figures import Sketch, combined, pure, sketched

FloatArray = npt.NDArray[np.float64]

#: The figures of a tire, by the names that `plot` takes.
KINDS = ("pure", "surfaces", "combined")
#: Blue below 0, red above, without the dark ends, on which numbers are not readable.
_COLORS = LinearSegmentedColormap.from_list("forces", colormaps["RdBu_r"](np.linspace(0.1, 0.9, 256)))
_MESH = 81  # points of a surface along each slip


def plot(
    tire: TireDefinition,
    kind: str = "pure",
    *,
    loads: Sequence[float] | None = None,
    signs: str = "iso",
    points: pd.DataFrame | None = None,
) -> MatplotlibFigure:
    """Return one figure of a tire; `Tire.plot` documents the parameters, `points` are measured rows in ISO.

    Raises `UnknownName` if the kind or the convention does not exist. Raises `TirefmuError` if a load is not positive,
    or the tire has no force or one that is not finite.

    >>> from tirefmu.tires import published
    >>> len(plot(published("unicamp_small_tire"), "combined", loads=[60.0, 110.0]).axes)
    2
    """
    if kind not in KINDS:
        raise UnknownName("kind of figure", kind, KINDS)
    sketch = sketched(tire, loads, signs, points)
    if kind == "surfaces":
        return surfaces(sketch, sketch.loads[len(sketch.loads) // 2])
    return picture(pure(sketch) if kind == "pure" else combined(sketch))


def notebook_figure(tire: TireDefinition) -> str:
    """Return the curves in pure slip as an image in HTML; empty for a tire that cannot be drawn."""
    try:
        return html_image(pure(sketched(tire, None, "iso")))
    except TirefmuError:
        return ""


@own_settings()
def surfaces(sketch: Sketch, load: float) -> MatplotlibFigure:
    """Fx and Fy over both slips at one load: as surfaces, and below as maps to read values from."""
    shown = [name for name in ("Fx", "Fy") if name in sketch.channels] or sketch.channels
    kappa, alpha = sketch.mesh(_MESH)
    forces = sketch.over(load, kappa, alpha)
    figure = MatplotlibFigure(figsize=(6.2 * len(shown), 10.2), layout="constrained")
    loaded = held_text(sketch.signs, {"Fz": load})
    figure.suptitle(f"{sketch.title}: forces in combined slip at {loaded}", fontweight="bold", parse_math=False)
    for column, channel in enumerate(shown, start=1):
        force = forces[channel].to_numpy().reshape(kappa.shape)
        top = float(np.abs(force).max())
        norm = Normalize(-top, top)
        solid = figure.add_subplot(2, len(shown), column, projection="3d")
        _draw_solid(solid, kappa, alpha, force, norm, channel)
        rows = sketch.measured(load, channel)
        x, y = (rows[slip].to_numpy(dtype=float) * per_si(slip) for slip in ("kappa", "alpha"))
        solid.plot(x, y, rows[channel].to_numpy(dtype=float), "ko", ms=2.0, mew=0.0, alpha=0.7, zorder=9)
        flat = figure.add_subplot(2, len(shown), len(shown) + column)
        _draw_map(flat, kappa, alpha, force, norm)
        bar = figure.colorbar(ScalarMappable(norm, _COLORS), ax=flat, shrink=0.9, pad=0.02)
        bar.set_label(axis_label(channel))
    write_note(figure, note(sketch.signs, *sketch.footnotes()))
    return figure


def _draw_solid(
    ax: Any, kappa: FloatArray, alpha: FloatArray, force: FloatArray, norm: Normalize, channel: str
) -> None:
    x, y = kappa * per_si("kappa"), alpha * per_si("alpha")
    ax.plot_surface(x, y, force, cmap=_COLORS, norm=norm, rcount=41, ccount=41, edgecolor="0.25", linewidth=0.2)
    ax.set(xlabel=axis_label("kappa"), ylabel=axis_label("alpha"))
    ax.zaxis.set_rotate_label(False)
    ax.set_zlabel(axis_label(channel), rotation=90.0)
    ax.set_title(f"{channel} over {letter('kappa')} and {letter('alpha')}", fontsize=10, y=0.98)
    # Viewed from the low side, so that no part is hidden.
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
    ax.set(xlabel=axis_label("kappa"), ylabel=axis_label("alpha"))
