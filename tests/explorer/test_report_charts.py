"""Charts in place of the figures of a report, in Chromium: they show the values of the figures, and act."""

from __future__ import annotations

import numpy as np
import pytest

from tirefmu.fitting.reporting.figures import figures_of
from tirefmu.tires.drawing.page import page_text
from tirefmu.tires.drawing.shown_figure import shown_figures

#: A report of figures only.
TEMPLATE = """{% extends "page.html" %}{% from "parts.html" import figure %}{% block title %}charts{% endblock %}
{% block content %}<h1>charts</h1>{% for each in shown %}{{ figure(each.name, each) }}{% endfor %}{% endblock %}"""


@pytest.fixture
def report(opened_file, tires, bench, tmp_path, monkeypatch):
    """Return a page with the figures of a tire over a recording, in the browser."""
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "shown_report").mkdir()
    (tmp_path / "shown_report" / "__init__.py").touch()
    (tmp_path / "shown_report" / "report.html").write_text(TEMPLATE)
    figures = figures_of(tires["mf96"], bench)
    wanted = {name: figures[name] for name in ("pure_Fy", "residuals")}
    path = tmp_path / "report.html"
    path.write_text(page_text("shown_report", {}, shown=shown_figures(wanted)), encoding="utf-8")
    return figures, opened_file(path)


def test_a_figure_becomes_charts_that_read_hide_and_zoom(report):
    figures, page = report
    assert not page.locator(".charts").count()
    button = page.locator("button.offer").first
    button.click()
    assert button.text_content() == "Show the figure"
    figure = page.locator(".figure").first
    assert not figure.locator("> img").is_visible()
    chart = figure.locator("figure").first
    line = next(each for each in figures["pure_Fy"].axes[0].lines if not each.get_label().startswith("_"))
    alpha, force = (np.asarray(values, dtype=float) for values in line.get_data())
    over = chart.locator(".u-over")
    box = over.bounding_box()
    limits = figures["pure_Fy"].axes[0]
    row = len(alpha) // 5
    across, down = (
        (values[row] - low) / (high - low)
        for values, (low, high) in ((alpha, limits.get_xlim()), (force, limits.get_ylim()))
    )
    for toggle in chart.get_by_role("button", name="points").all():
        toggle.click()
        assert toggle.get_attribute("aria-pressed") == "false"
    page.mouse.move(box["x"] + across * box["width"], box["y"] + (1.0 - down) * box["height"])
    name, x, y = chart.locator("output").text_content().replace(",", ":").split(":")
    assert name == line.get_label()
    assert float(x.split()[-1]) == pytest.approx(alpha[row], abs=0.3)
    assert float(y.split()[-1]) == pytest.approx(np.interp(float(x.split()[-1]), alpha, force), rel=1e-3, abs=0.5)
    canvas = chart.locator("canvas")
    whole = canvas.get_attribute("aria-label")
    over.scroll_into_view_if_needed()
    page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 0.2 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 0.8 * box["height"], steps=4)
    page.mouse.up()
    low, high = limits.get_xlim()
    shown = canvas.get_attribute("aria-label").rsplit(". ", 1)[1].split(";")[0].split(":")[1].split(" to ")
    assert [float(each) for each in shown] == pytest.approx(
        [low + 0.25 * (high - low), low + 0.75 * (high - low)], abs=0.02 * (high - low)
    )
    chart.get_by_role("button", name="Reset zoom").click()
    assert canvas.get_attribute("aria-label") == whole
    button.click()
    assert figure.locator("> img").is_visible()


def test_a_printed_page_has_the_figure(report):
    _, page = report
    page.get_by_role("button", name="Zoom and read values").first.click()
    page.emulate_media(media="print")
    figure = page.locator(".figure").first
    assert figure.locator("> img").is_visible()
    assert not figure.locator("figure").first.is_visible()
    assert not page.get_by_role("button", name="Show the figure").is_visible()
