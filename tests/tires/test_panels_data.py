"""The data of a figure are those that it shows, and no text of it ends the script element of a page."""

from __future__ import annotations

import json
from base64 import b64decode

import numpy as np
import pytest
from matplotlib.figure import Figure

from tirefmu.tires.drawing.panels_data import MOST_POINTS, panels_of
from tirefmu.tires.drawing.shown_figure import shown_figure


def decoded(series):
    return [np.frombuffer(b64decode(series[axis]), dtype="<f4") for axis in ("x", "y")]


@pytest.fixture
def axes():
    """Return the axes of an empty figure."""
    return Figure().subplots()


def test_lines_points_and_bands_have_the_drawn_values_in_the_drawn_order(axes):
    x, y = np.linspace(-1.0, 1.0, 7), np.linspace(200.0, -300.0, 7)
    axes.plot(x, y, "C1--", label="tire", zorder=3)
    axes.plot(x, 2.0 * y, ".", color="0.5", zorder=1)
    axes.fill_between(x, y - 5.0, y + 5.0, color="C1", alpha=0.25)
    axes.axhline(10.0)
    axes.axvline(0.5)
    (panel,) = panels_of(axes.figure)
    band, *drawn = panel["series"]
    assert [(each["kind"], each["label"]) for each in drawn] == [
        ("points", ""), ("across", ""), ("upright", ""), ("line", "tire"),
    ]  # fmt: skip
    assert drawn[-1]["dashes"] == "--"
    assert band["kind"] == "band"
    assert band["color"] == drawn[-1]["color"]
    assert band["opacity"] == 0.25
    for series, expected in zip((drawn[0], drawn[3]), (2.0 * y, y), strict=True):
        np.testing.assert_array_equal(decoded(series), np.float32([x, expected]))
    assert decoded(drawn[1])[1][0] == 10.0
    assert decoded(drawn[2])[0][0] == 0.5
    assert panel["limits"] == [list(axes.get_xlim()), list(axes.get_ylim())]


def test_pieces_of_one_look_are_one_series_with_gaps(axes):
    for start in (0.0, 2.0):
        axes.plot([start, start + 1.0], [start, start], color="C0")
    axes.plot([5.0], [5.0], color="C1")
    first, second = panels_of(axes.figure)[0]["series"]
    np.testing.assert_array_equal(decoded(first)[0], np.float32([0.0, 1.0, np.nan, 2.0, 3.0]))
    assert len(decoded(second)[0]) == 1


def test_of_many_points_every_kth_is_taken_and_the_step_is_stated(axes):
    axes.plot(np.arange(2.5 * MOST_POINTS))
    (series,) = panels_of(axes.figure)[0]["series"]
    assert series["step"] == 3
    np.testing.assert_array_equal(decoded(series)[0], np.arange(0.0, 2.5 * MOST_POINTS, 3.0))


def test_panels_with_other_content_are_left_out_and_shared_axes_are_known():
    figure = Figure()
    first, second, bars = figure.subplots(1, 3, sharex=True)
    for ax in (first, second, bars):
        ax.plot([0.0, 1.0])
    bars.bar([0.0], [1.0])
    second.set_xlabel("time (s)")
    first.set_ylabel("force (N)")
    panels = panels_of(figure)
    assert [(panel["x"], panel["y"], panel["shared"]) for panel in panels] == [("time (s)", "force (N)", True)] * 2
    image = Figure()
    image.subplots().imshow(np.eye(2))
    assert shown_figure("map", image).panels == ""


@pytest.mark.parametrize("text", ["</script><script>alert(1)</script>", "<!--<script>", "a\u2028b", r"\$x"])
def test_texts_stay_inside_the_element(axes, text):
    axes.plot([0.0], [1.0], label=text)
    axes.set_title(text)
    shown = shown_figure("any", axes.figure).panels
    assert "<" not in shown
    (panel,) = json.loads(shown)
    assert panel["title"] == panel["series"][0]["label"] == text.replace(r"\$", "$")
