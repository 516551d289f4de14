"""A figure is drawn twice from the same data, and no text of it ends the script element of a page or is a formula."""

from __future__ import annotations

import json
from base64 import b64decode

import numpy as np
import pandas as pd
import pytest

from tests.hostile import HOSTILE
from tirefmu.tires.drawing.chart_data import MAX_POINTS, chart_data
from tirefmu.tires.drawing.figure import Cells, Figure, Panel, Series, band, in_rows
from tirefmu.tires.drawing.picture import picture, png
from tirefmu.tires.drawing.residual_panels import residuals_over_inputs

X = np.linspace(-1.0, 1.0, 7)
LINE = Series("line", X, -300.0 * X, "#123456", "tire", (4.0, 2.0))
PANEL = Panel("α (deg)", "Fy (N)", (Series("points", X, 200.0 * X, marker="^"), band(X, X, X + 5.0, "#123456"), LINE))


def figure_of(*panels, columns=2):
    return Figure("any", "any", in_rows(panels, columns))


def charts(figure):
    """Return the panels of the charts, with the numbers of their series."""
    panels = [panel for row in json.loads(chart_data(figure)) for panel in row if panel]
    for panel in panels:
        for series in panel["series"]:
            series |= {axis: np.frombuffer(b64decode(series[axis]), dtype="<f4") for axis in ("x", "y")}
    return panels


def test_the_chart_and_the_picture_have_the_values_and_the_look():
    (panel,) = charts(figure_of(PANEL))
    (ax,) = picture(figure_of(PANEL)).axes
    points, _, line = panel["series"]
    assert [series["kind"] for series in panel["series"]] == ["points", "band", "line"]
    assert (line["color"], line["label"], line["dashes"]) == ("#123456", "tire", [4.0, 2.0])
    for series, drawn in zip((points, line), ax.get_lines(), strict=True):
        np.testing.assert_allclose([series["x"], series["y"]], drawn.get_data(), rtol=1e-6)
        assert drawn.get_color() == series["color"]
    np.testing.assert_allclose(panel["limits"], [ax.get_xlim(), ax.get_ylim()])
    assert (ax.get_xlabel(), ax.get_ylabel()) == (panel["x"], panel["y"])


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
    np.testing.assert_array_equal(series["y"][:5], np.float32([0.0, 3.0, 6.0, np.nan, 9.0]))


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


@pytest.mark.parametrize("text", HOSTILE)
def test_a_text_is_drawn_literally_and_stays_inside_the_element(text):
    panel = Panel(text, text, (Series("line", [0.0, 1.0], [0.0, 1.0], label=text),), text, text)
    shown = chart_data(figure_of(panel))
    assert "<" not in shown
    ((decoded,),) = json.loads(shown)
    assert decoded["title"] == decoded["series"][0]["label"] == text
    if "\ud800" not in text and len(text) < 1000:
        assert png(Figure("any", text, ((panel,),), text), 40).startswith(b"\x89PNG")


# ------------------------------------ Panels of residuals over inputs exist where both were measured, and are labelled


ROWS = 60
SLIP = np.linspace(-0.1, 0.1, ROWS)
LATERAL = np.arange(ROWS) < ROWS // 2


def labels(figure):
    """Return the labels of the axes of the panels, in their order."""
    return [(panel.x, panel.y) for panel in figure.panels]


def test_a_panel_needs_rows_with_input_and_channel():
    """Two recordings: Fy with a temperature, Fx without one, and kappa varies for Fx only."""
    table = pd.DataFrame({"alpha": SLIP, "kappa": np.where(LATERAL, 0.0, SLIP), "Fz": 900.0})
    table["T"] = np.where(LATERAL, 30.0 + 100.0 * SLIP, np.nan)
    errors = np.cos(50.0 * SLIP)
    figure = residuals_over_inputs(
        table, {"Fx": np.where(LATERAL, np.nan, errors), "Fy": np.where(LATERAL, errors, np.nan)}, "iso"
    )
    assert labels(figure) == [
        ("α (deg)", "Fx (N)"), ("κ (-)", "Fx (N)"), ("α (deg)", "Fy (N)"), ("T (deg C)", "Fy (N)"),
    ]  # fmt: skip


def test_a_row_begins_with_its_first_panel():
    table = pd.DataFrame({"alpha": np.where(LATERAL, SLIP, 0.0), "kappa": np.where(LATERAL, 0.0, SLIP)})
    residuals = {"Fx": np.where(LATERAL, np.nan, 1.0), "Fy": np.where(LATERAL, 1.0, np.nan)}
    assert labels(residuals_over_inputs(table, residuals, "iso")) == [
        ("κ (-)", "Fx (N)"), ("α (deg)", "Fy (N)"),
    ]  # fmt: skip


def test_no_figure_without_an_input_or_a_channel():
    table = pd.DataFrame({"alpha": SLIP, "T": np.nan})
    assert residuals_over_inputs(table, {"Fy": np.full(ROWS, np.nan)}, "iso") is None
    assert residuals_over_inputs(table.assign(alpha=0.1), {"Fy": SLIP}, "iso") is None


def test_each_level_of_an_input_has_its_mean():
    loads = np.resize([200.0, 700.0, 900.0], ROWS)
    (panel,) = residuals_over_inputs(pd.DataFrame({"Fz": loads}), {"Fy": loads / 100.0}, "iso").panels
    (means,) = (series for series in panel.series if series.marker == "o")
    assert pytest.approx(np.array([[200.0, 2.0], [700.0, 7.0], [900.0, 9.0]])) == means.points.T
