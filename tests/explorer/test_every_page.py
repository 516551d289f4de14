"""Every page that a command writes, in Chromium at the widths of a screen and of a phone (make pages)."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import pytest

from tirefmu.commands.cli import main

from ..docs.made_files import MadeFiles

pytestmark = pytest.mark.skipif("TIREFMU_PAGES" not in os.environ, reason="runs all steps: make pages")

FILES = ("run.csv", "tire.tir", "log.csv", "front.tir", "rear.tir")
COMMANDS = (
    "demo -o demo",
    "init run.csv --model mf61 --nominal Fz0=1000,R0=0.23",
    "run --only inspect,fit,check",
    "compare tire.tir results/tire.tir run.csv -o comparison",
    "plan tire.tir --bench bench.toml --minutes 4 -o program",
    "drive --example",
    "drive log.csv --vehicle car.toml --tire front.tir --rear rear.tir -o drive",
)
PAGES = (
    "demo/index.html", "demo/inspection.html", "demo/check.html", "demo/diagnosis/report.html", "demo/explorer.html",
    "results/index.html", "results/fit.html", "comparison/report.html", "program/report.html", "drive/report.html",
)  # fmt: skip


#: Reports of one recording: none is higher, px at 1,400 px, or larger, bytes.
REPORTS = (
    "demo/index.html",
    "results/fit.html",
    "demo/inspection.html",
    "demo/check.html",
    "demo/diagnosis/report.html",
    "comparison/report.html",
    "program/report.html",
    "drive/report.html",
)
HIGHEST, LARGEST = 4500, 1_000_000


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with the pages of all steps."""
    folder = tmp_path_factory.mktemp("pages")
    made = MadeFiles(tmp_path_factory.mktemp("made"))
    for name in FILES:
        made.copy(name, folder)
    with contextlib.chdir(folder):
        with Path("bench.toml").open("w", encoding="utf-8") as file, contextlib.redirect_stdout(file):
            main(["plan", "--example"])
        for line in COMMANDS:
            assert main(line.split()) in (0, 1), line
    return folder


@pytest.mark.parametrize("width", [1400, 390])
@pytest.mark.parametrize("name", PAGES)
def test_nothing_is_wider_than_the_screen_and_the_first_screen_has_the_verdict(folder, opened_file, name, width):
    page = opened_file(folder / name, width=width, height=844)
    page.wait_for_timeout(500)
    for y in range(0, page.evaluate("document.documentElement.scrollHeight"), 700):  # a chart is drawn where it is seen
        page.evaluate(f"window.scrollTo(0, {y})")
        page.wait_for_timeout(60)
    page.evaluate("window.scrollTo(0, 0)")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    if name in REPORTS and width == 1400:
        assert page.evaluate("document.documentElement.scrollHeight") < HIGHEST
        assert (folder / name).stat().st_size < LARGEST
    answer = page.locator(".verdict, #charts figure").first.bounding_box()
    assert answer["y"] + min(answer["height"], 200.0) < 844.0


def test_these_are_all_pages(folder):
    """The steps write no page that is not opened above, but that of the same kind."""
    kinds = {Path(name).name for name in PAGES} | {"check_run.html", "explorer.html", "inspect.html"}
    assert {path.name for path in folder.rglob("*.html")} <= kinds
