r"""Curves, points and bands of a drawn figure as data: a page draws charts of them in which a reader can zoom.

The figure stays what is printed and what is seen without scripts. Its axes are read as they were drawn, so a chart
cannot differ from its figure.
"""

from __future__ import annotations

import re
import unicodedata
from base64 import b64encode
from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any

import numpy as np
import numpy.typing as npt

from .own_matplotlib import Axes, Figure, Line2D, PolyCollection, to_hex, to_rgba_array

FloatArray = npt.NDArray[np.float64]

#: Largest number of points of a series; of more, every k-th one is taken.
MOST_POINTS = 20_000
#: Letters of mathematical text that are no Greek small letters by their own name.
_LETTERS = {"varphi": "\u03c6", "partial": "\u2202", "omega": "\u03c9", "Delta": "\u0394", "infty": "\u221e"}


def panels_of(figure: Figure) -> list[dict[str, Any]]:
    r"""Return the panels of a figure that consist of lines, points and bands.

    Parameters
    ----------
    figure : matplotlib.figure.Figure

    Returns
    -------
    list of dict
        JSON values for each panel: title, labels of the axes, their limits, whether other panels have the same x axis,
        and its series: kind (line, points, band, across, upright), label, color, dashes, width, opacity, and x and y as
        base64 text of 32-bit floating-point numbers. Panels with images, bars or other content are left out.

    Examples
    --------
    >>> figure = Figure()
    >>> ax = figure.subplots()
    >>> _ = ax.plot([1.0, 2.0], [3.0, 5.0], "k--", label="$F_y$")
    >>> _ = ax.set_xlabel(r"$\varphi_t$ (1/m)")
    >>> panel = panels_of(figure)[0]
    >>> panel["x"], [(each["kind"], each["label"]) for each in panel["series"]]
    ('φt (1/m)', [('line', 'Fy')])
    """
    panels: list[dict[str, Any]] = []
    for ax in figure.axes:
        if ax.get_visible() and ax.lines and not (ax.images or ax.patches):
            panel = _panel(ax)
            panel["y"] = panel["y"] or (panels[-1]["y"] if panels else "")  # only the first of a row has the label
            panels.append(panel)
    return panels


def plain(text: str) -> str:
    r"""Return a text of a figure without the marks of mathematical text.

    Examples
    --------
    >>> plain(r"$|\partial F_y/\partial\varphi|$ (N)"), plain(r"cost \$")
    ('|∂Fy/∂φ| (N)', 'cost $')
    """
    parts = re.split(r"(?<!\\)\$", text)
    parts[1::2] = [_plain_mathematics(part) for part in parts[1::2]]
    return "".join(parts).replace(r"\$", "$")


def _plain_mathematics(text: str) -> str:
    named = re.sub(r"\\([A-Za-z]+) ?", lambda found: _letter(found[1]), text)
    return re.sub(r"[_^{}]|\\,", "", named)


def _letter(name: str) -> str:
    try:
        return _LETTERS.get(name) or unicodedata.lookup(f"GREEK SMALL LETTER {name.upper()}")
    except KeyError:
        return name


def _panel(ax: Axes) -> dict[str, Any]:
    legend = ax.get_legend()
    together = ax.get_shared_x_axes().get_siblings(ax)
    return {
        "title": plain(ax.get_title() or ax.get_title("left")).replace("\n", "; "),
        "x": next((plain(each.get_xlabel()) for each in together if each.get_xlabel()), ""),
        "y": plain(ax.get_ylabel()).replace("\n", " "),
        "legend": plain(legend.get_title().get_text()) if legend else "",
        "limits": [[float(value) for value in limits] for limits in (ax.get_xlim(), ax.get_ylim())],
        "shared": len(together) > 1,
        "series": [*_bands(ax), *_lines(ax)],
    }


def _bands(ax: Axes) -> list[dict[str, Any]]:
    filled = [
        (each, to_rgba_array(each.get_facecolor())[0]) for each in ax.collections if isinstance(each, PolyCollection)
    ]
    return [
        _series("band", "", to_hex(color), path.vertices, opacity=float(color[3]))
        for each, color in filled for path in each.get_paths()
    ]  # fmt: skip


def _lines(ax: Axes) -> list[dict[str, Any]]:
    """Return the lines in the order in which they are drawn; pieces of the same look are one series with gaps."""
    drawn = sorted((line for line in ax.lines if len(_points(line))), key=lambda line: line.get_zorder())
    return [
        series
        for look, lines in groupby(drawn, key=lambda line: _look(ax, line))
        for series in [_of_lines(look, list(lines))]
    ]


def _look(ax: Axes, line: Line2D) -> tuple[str, str, str, str, float]:
    """Return kind, label, color, dashes and width; label and kind keep lines of a meaning of their own apart."""
    label = line.get_label()
    named = "" if not isinstance(label, str) or label.startswith("_") else plain(label)
    kind = "points" if line.get_linestyle() in ("None", "none", "", " ") else "line"
    if line.get_transform() == ax.get_yaxis_transform(which="grid"):
        kind = "across"
    elif line.get_transform() == ax.get_xaxis_transform(which="grid"):
        kind = "upright"
    width = line.get_markersize() if kind == "points" else line.get_linewidth()
    return kind, named, to_hex(line.get_color()), str(line.get_linestyle()), float(width)


def _of_lines(look: tuple[str, str, str, str, float], lines: Sequence[Line2D]) -> dict[str, Any]:
    kind, label, color, dashes, width = look
    gap = np.full((1, 2), np.nan)
    points = np.concatenate([part for line in lines for part in (_points(line), gap)][:-1])
    return _series(kind, label, color, points, dashes=dashes, width=width)


def _points(line: Line2D) -> FloatArray:
    return np.column_stack(line.get_data()).astype(np.float64)


def _series(kind: str, label: str, color: str, points: npt.ArrayLike, **style: object) -> dict[str, Any]:
    shown = np.asarray(points, dtype=np.float64)
    step = -(-len(shown) // MOST_POINTS)
    x, y = shown[::step].T
    return {"kind": kind, "label": label, "color": color, "step": step, "x": _encoded(x), "y": _encoded(y), **style}


def _encoded(values: Iterable[float]) -> str:
    return b64encode(np.asarray(values, dtype="<f4").tobytes()).decode("ascii")
