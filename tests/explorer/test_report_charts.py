"""The charts of a report in Chromium: they show the values of the figures, act, and are all printed."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tirefmu.drawing.page import page_text
from tirefmu.fitting.reporting import figures_of

#: A report of figures only.
TEMPLATE = """{% extends "page.html" %}{% from "parts.html" import figure %}{% block title %}charts{% endblock %}
{% block content %}<h1>charts</h1><h2>all</h2>{% for each in shown %}{{ figure(each) }}{% endfor %}{% endblock %}"""


@pytest.fixture
def report(opened_file, tires, bench, tmp_path, monkeypatch):
    """Return two figures of a tire over a recording, and a page with them in the browser."""
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "shown_report").mkdir()
    (tmp_path / "shown_report" / "__init__.py").touch()
    (tmp_path / "shown_report" / "report.html").write_text(TEMPLATE)
    shown = [figure for figure in figures_of(tires["mf96"], bench) if figure.name in ("pure_Fy", "residuals")]
    path = tmp_path / "report.html"
    path.write_text(page_text("shown_report", {}, shown=shown), encoding="utf-8")
    return shown, opened_file(path)


def limits_of(chart):
    """Return the limits along x that a chart describes."""
    text = chart.locator("canvas[role=img]").get_attribute("aria-label").rsplit(". ", 1)[1].split(";")[0]
    return [float(part) for part in text.split(":")[1].split(" to ")]


def drag(page, chart, start, end):
    """Drag over a part of a chart, as shares of its width."""
    over = chart.locator(".u-over")
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    page.mouse.move(box["x"] + start * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + end * box["width"], box["y"] + 0.5 * box["height"] + 1.0, steps=4)
    page.mouse.up()


def test_a_chart_reads_hides_and_zooms(report):
    (figure, _), page = report
    panel = figure.panels[0]
    chart = page.locator(".charts figure").first
    chart.locator("canvas[role=img]").wait_for()
    line = next(series for series in panel.series if series.kind == "line")
    alpha, force = line.points
    toggle = page.get_by_role("button", name="points", exact=True).first
    toggle.click()
    assert toggle.get_attribute("aria-pressed") == "false"
    box = chart.locator(".u-over").bounding_box()
    row = len(alpha) // 5
    across, down = (
        (values[row] - low) / (high - low)
        for values, (low, high) in zip((alpha, force), figure.limits(panel), strict=True)
    )
    page.mouse.move(box["x"] + across * box["width"], box["y"] + (1.0 - down) * box["height"])
    name, x, y = chart.locator("output").text_content().replace(",", ":").split(":")
    assert name == line.label
    assert float(x.split()[-1]) == pytest.approx(alpha[row], abs=0.3)
    assert float(y.split()[-1]) == pytest.approx(np.interp(float(x.split()[-1]), alpha, force), rel=1e-3, abs=0.5)
    (low, high), whole = figure.limits(panel)[0], limits_of(chart)
    drag(page, chart, 0.25, 0.75)
    middle = [low + share * (high - low) for share in (0.25, 0.75)]
    assert limits_of(chart) == pytest.approx(middle, abs=0.02 * (high - low))
    page.get_by_role("button", name="Reset zoom").click()
    assert limits_of(chart) == whole


def test_panels_over_time_are_zoomed_together(report):
    _, page = report
    rows = page.locator(".figure").nth(1).locator(".charts > div")
    rows.first.scroll_into_view_if_needed()
    first, histogram = rows.first.locator("figure").all()
    first.locator("canvas[role=img]").wait_for()
    before = limits_of(histogram)
    drag(page, first, 0.2, 0.4)
    second = rows.nth(1).locator("figure").first
    second.scroll_into_view_if_needed()
    second.locator("canvas[role=img]").wait_for()
    assert limits_of(second) == limits_of(first)
    assert limits_of(histogram) == before


def test_every_section_and_chart_is_printed_one_below_the_other(report):
    """Also those that were not in view; the page is as before after printing."""
    figures, page = report
    page.evaluate("""() => {
      const details = document.createElement("details");
      const second = document.querySelectorAll(".figure")[1];
      second.before(details);
      details.append(second);
    }""")
    page.emulate_media(media="print")
    page.set_viewport_size({"width": 718, "height": 900})  # A4 with margins
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    charts = page.locator(".charts figure")
    assert charts.count() == page.locator(".charts canvas[role=img]").count() == sum(len(f.panels) for f in figures)
    boxes = [chart.bounding_box() for chart in charts.all()]
    assert all(later["y"] >= box["y"] + box["height"] for box, later in pairwise(boxes))
    assert page.evaluate("document.documentElement.scrollWidth") <= 718
    assert not page.locator(".figure > img").is_visible()
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.evaluate("document.querySelector('details').open") is False


def test_the_charts_are_accessible(report):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed: make pages")
    _, page = report
    page.locator(".charts canvas[role=img]").first.wait_for()
    violations = axe.Axe().run(page).response["violations"]
    assert [(violation["id"], violation["nodes"][0]["html"]) for violation in violations] == []
