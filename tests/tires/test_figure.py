"""A figure is drawn twice from the same data, and no text of it ends the script element of a page or is a formula."""

from __future__ import annotations

import json
from base64 import b64decode
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.hostile import EACH_PAGE
from tirefmu.drawing.chart_data import MAX_POINTS, MISSING, chart_data
from tirefmu.drawing.figure import LINE, Cells, Figure, Panel, Series, band, in_rows
from tirefmu.drawing.picture import picture, png

pytestmark = pytest.mark.usefixtures("drawn_figures")
X = np.linspace(-1.0, 1.0, 7)
TIRE = Series("line", X, -300.0 * X, "#123456", "tire", (4.0, 2.0))
PANEL = Panel("α (deg)", "Fy (N)", (Series("points", X, 200.0 * X, marker="o"), band(X, X, X + 5.0, "#123456"), TIRE))


def figure_of(*panels, columns=2):
    return Figure("any", "any", in_rows(panels, columns))


def charts(figure):
    """Return the panels of the charts, with the numbers of their series."""
    panels = [panel for row in json.loads(chart_data(figure)) for panel in row if panel]
    for panel in panels:
        for series in panel["series"]:
            series |= {axis: decoded(**series[axis]) for axis in ("x", "y")}
    return panels


def decoded(low, unit, steps):
    """Return the numbers of an axis as the script of a page does."""
    integers = np.frombuffer(b64decode(steps), dtype="<u2")
    return np.where(integers == MISSING, np.nan, low + unit * integers)


def test_the_chart_and_the_picture_have_the_values_and_the_look():
    (panel,) = charts(figure_of(PANEL))
    (ax,) = picture(figure_of(PANEL)).axes
    points, _, line = panel["series"]
    assert [series["kind"] for series in panel["series"]] == ["points", "band", "line"]
    assert (line["color"], line["label"], line["dashes"]) == ("#123456", "tire", [4.0, 2.0])
    for series, drawn in zip((points, line), ax.get_lines(), strict=True):
        np.testing.assert_allclose([series["x"], series["y"]], drawn.get_data(), atol=400.0 / MISSING)
        assert drawn.get_color() == series["color"]
    np.testing.assert_allclose(panel["limits"], [ax.get_xlim(), ax.get_ylim()])
    assert (ax.get_xlabel(), ax.get_ylabel()) == (panel["x"], panel["y"])


def test_bands_are_drawn_on_request_only():
    for bands in (False, True):
        figure = Figure("any", "any", ((PANEL,),), bands=bands)
        assert charts(figure)[0]["bands"] is bands
        assert len(picture(figure).axes[0].patches) == bands


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=12))
def test_names_are_beside_the_ends_of_their_lines_and_do_not_cover_one_another(ends):
    lines = tuple(Series("line", [0.0, 1.0], [0.0, y], label=str(i)) for i, y in enumerate(ends))
    panel = Panel("x", "y", lines, height=4.0)
    names = figure_of(panel).names(panel)
    heights = [height for _, _, height in names]
    assert sorted(label for label, *_ in names) == sorted(line.label for line in lines)
    assert all(0.0 <= height <= 1.0 for height in heights)
    assert all(upper - lower > 0.999 * LINE / 4.0 for upper, lower in pairwise(heights))
    if len(ends) == 1:
        low, high = figure_of(panel).limits(panel)[1]
        assert heights == pytest.approx([(ends[0] - low) / (high - low)])


def test_panels_with_a_common_axis_have_its_limits():
    shared = {"x_axis": "slip", "y_axis": "force"}
    near, far = (Panel("x", "y", (Series("line", [0.0, end], [0.0, 2.0 * end]),), **shared) for end in (1.0, 10.0))
    other = Panel("x", "y", (Series("line", [0.0, 1.0], [0.0, 1.0]),), y_limits=(0.0, None))
    first, second, alone = charts(figure_of(near, far, other))
    assert first["limits"] == second["limits"] == [[-0.5, 10.5], [-1.0, 21.0]]
    np.testing.assert_allclose(alone["limits"], [[-0.05, 1.05], [0.0, 1.05]])


def test_values_without_range_and_without_number_have_limits():
    for values in ([3.0, 3.0], [np.nan, np.nan], []):
        for low, high in charts(figure_of(Panel("x", "y", (Series("line", values, values),))))[0]["limits"]:
            assert low < high


def test_of_many_points_every_kth_is_taken_and_gaps_stay():
    y = np.arange(2.5 * MAX_POINTS)
    y[7] = np.nan
    (series,) = charts(figure_of(Panel("x", "y", (Series("line", y, y),))))[0]["series"]
    assert series["step"] == 3
    np.testing.assert_allclose(series["y"][:5], [0.0, 3.0, 6.0, np.nan, 9.0], atol=len(y) / MISSING)


def test_a_map_has_its_cells_in_both():
    means = np.array([[1.0, np.nan], [-2.0, 0.5]])
    cells = Cells(np.arange(3.0), np.arange(3.0), means, np.array([[4, 0], [5, 6]]), True, 2.0, "mean (N)")
    figure = figure_of(Panel("x", "y", x_limits=(0.0, 2.0), y_limits=(0.0, 2.0), cells=cells))
    (panel,) = charts(figure)
    assert panel["cells"]["means"] == [[1.0, None], [-2.0, 0.5]]
    assert sorted(text.get_text() for text in picture(figure).axes[0].texts) == ["4", "5", "6"]


def test_a_single_panel_of_a_row_is_as_wide_as_the_others_together():
    wide = Figure("any", "any", ((PANEL, PANEL), (PANEL,)))
    made = picture(wide)
    made.draw_without_rendering()
    widths = [ax.get_position().width for ax in made.axes]
    assert widths[2] > 1.8 * widths[0]
    assert in_rows([PANEL] * 3)[1] == (PANEL, None)


@pytest.mark.parametrize("text", EACH_PAGE)
def test_a_text_is_drawn_literally_and_stays_inside_the_element(text):
    panel = Panel(text, text, (Series("line", [0.0, 1.0], [0.0, 1.0], label=text),), text)
    shown = chart_data(figure_of(panel))
    assert "<" not in shown
    ((decoded,),) = json.loads(shown)
    assert decoded["title"] == decoded["series"][0]["label"] == text
    if "\ud800" not in text and len(text) < 1000:
        assert png(Figure("any", text, ((panel,),), text), 40).startswith(b"\x89PNG")
