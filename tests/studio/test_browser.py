"""The window in Chromium: from two recordings to an FMU by mouse and keyboard, errors of a user, accessibility."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time

import pytest

from tirefmu.commands.cli import main
from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps, kappa_sweeps, recording_from, write_table
from tirefmu.tires import published

from ..chromium import launched

#: Actions by mouse and keyboard from the recordings to the FMU: the showing of the window.
MAX_ACTIONS = 60
WAIT = 120_000  # ms
LOADS, CAMBERS = [220.0, 450.0, 700.0, 900.0, 1100.0], [0.0, 0.02, 0.035, 0.05, 0.07]


@pytest.fixture(scope="module")
def browser():
    """Return a running Chromium; skip the tests without it."""
    if "TIREFMU_STUDIO" not in os.environ:
        pytest.skip("the window in a browser: make studio")
    with launched("make studio") as running:
        yield running


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """Return the files of two recordings of one tire: cornering, driving and braking."""
    folder = tmp_path_factory.mktemp("bench")
    bench = VirtualBench(published("trento_hoosier"), seed=1)
    loads, cambers = [220.0, 700.0, 1100.0], [0.0, 0.035, 0.07]
    programs = {
        "cornering.csv": alpha_sweeps(loads, cambers, sample_rate=20.0),
        "braking.csv": kappa_sweeps(loads, [0.0, -0.05, -0.1], cambers, sample_rate=20.0),
    }
    for name, program in programs.items():
        table = bench.run(program).with_signs("iso").table
        write_table(table.drop(columns="Fx") if name == "cornering.csv" else table, folder / name)
    return [folder / name for name in programs]


class Studio:
    """A server in a process of its own, and pages of it whose actions are counted."""

    def __init__(self, folder, browser):
        self.folder, self.browser, self.actions, self.problems = folder, browser, 0, []
        self.start()

    def start(self):
        line = [sys.executable, "-m", "tirefmu", "studio", "--no-browser"]
        self.process = subprocess.Popen(line, cwd=self.folder, stdout=subprocess.PIPE, text=True)
        self.address = re.search(r"http://\S+", self.process.stdout.readline())[0]

    def end(self, number):
        self.process.send_signal(number)
        self.process.wait(20)
        self.process.stdout.close()

    def open(self, width=1400, height=900):
        page = self.browser.new_context(viewport={"width": width, "height": height}).new_page()
        page.on("pageerror", lambda error: self.problems.append(str(error)))
        page.on("console", lambda message: self.problems.append(message.text) if message.type == "error" else None)
        page.set_default_timeout(WAIT)
        page.goto(self.address)
        self.until(page, "studio.state")
        return page

    def until(self, page, expression):
        """Wait until an expression is true. The page's policy forbids the library's own way to wait."""
        end = time.monotonic() + WAIT / 1000
        while not page.evaluate(f"Boolean({expression})"):
            assert time.monotonic() < end, (expression, page.inner_text("#message"))
            page.wait_for_timeout(50)

    def settled(self, page):
        self.until(page, "!studio.refreshing && !studio.running")

    def click(self, page, selector):
        self.actions += 1
        page.click(selector)

    def type(self, page, selector, text):
        self.actions += 2
        page.fill(selector, text)
        page.keyboard.press("Tab")
        self.settled(page)

    def work(self, page, selector):
        """Click on what starts work, and wait for its end."""
        self.click(page, selector)
        self.until(page, "studio.running")
        self.settled(page)

    def project(self):
        return (self.folder / "tirefmu.toml").read_text()


@pytest.fixture
def studio(browser, tmp_path):
    running = Studio(tmp_path, browser)
    yield running
    running.end(signal.SIGINT)
    assert not running.problems


def add(studio, page, *files):
    studio.actions += 1
    page.set_input_files("#upload", files)
    studio.until(page, f"studio.state.sections.data.tables.length >= {len(files)}")
    studio.settled(page)
    studio.until(page, "studio.tabs.data.chart.plot")


def results(folder):
    """Return the files of results; without times and what contains them."""
    found = {}
    for path in sorted((folder / "results").iterdir()):
        if path.suffix in (".tir", ".json") and path.name != "run.json":
            found[path.name] = re.sub(r'"(seconds|bytes)": [\d.e-]+', "", path.read_text())
    return found


def test_from_two_recordings_to_an_fmu(studio, recordings, monkeypatch):
    """In few actions; `tirefmu run` afterwards gives the same files to the last digit."""
    began = time.monotonic()
    page = studio.open()
    add(studio, page, *recordings)
    page.locator("#time-chart").scroll_into_view_if_needed()
    box = page.locator("#time-chart .u-over").bounding_box()
    studio.actions += 1
    page.mouse.move(box["x"] + 5, box["y"] + 50)
    page.mouse.down()
    page.mouse.move(box["x"] + 40, box["y"] + 50, steps=4)
    page.mouse.up()
    studio.click(page, "#exclude")
    studio.until(page, "(studio.state.sections.data.exclude ?? []).length === 1")
    studio.settled(page)
    studio.click(page, "#tab-fit")
    studio.settled(page)
    studio.actions += 1
    page.select_option("#model", "mf96")
    studio.settled(page)
    studio.type(page, "#Fz0", "700")
    studio.type(page, "#R0", "0.2304")
    studio.work(page, "#run-fit")
    assert page.inner_text("#verdict").startswith("tire usable")
    studio.click(page, "#tab-export")
    studio.settled(page)
    for name in ("convert-adams", "generate-cpp"):
        studio.click(page, f"#{name}")
        studio.until(page, f"studio.state.steps.some((step) => step.name === '{name.replace('-', ' ')}')")
        studio.settled(page)
    studio.work(page, "#run-export")
    assert (studio.folder / "results" / "tire_adams.tir").is_file()
    assert "code in cpp" in page.inner_text("#results")
    assert "FMU check passed" in page.inner_text("#results")
    seconds = time.monotonic() - began
    print(f"\nfrom two recordings to an FMU: {studio.actions} actions, {seconds:.1f} s")
    assert studio.actions <= MAX_ACTIONS
    assert (studio.folder / "results" / "tire.fmu").is_file()
    before = results(studio.folder)
    monkeypatch.chdir(studio.folder)
    again = ["run", "--only", "check,explore,inspect", "--quiet", "--json", "steps.json"]
    assert main(again) == 0
    assert not any(step["repeated"] for step in json.loads((studio.folder / "steps.json").read_text())["steps"])
    # A process of its own has one BLAS thread, as the window has.
    subprocess.run([sys.executable, "-m", "tirefmu", *again, "--force"], check=True)
    assert results(studio.folder) == before


def test_errors_of_a_user_lose_nothing(studio, recordings, tmp_path_factory):
    """A wrong file, a fit that is stopped, a server that is killed and restarted, two pages."""
    page = studio.open()
    wrong = tmp_path_factory.mktemp("wrong") / "photo.png"
    wrong.write_bytes(b"\x89PNG")
    page.set_input_files("#upload", wrong)
    studio.until(page, "document.getElementById('message').textContent.includes('not a kind of recording')")
    add(studio, page, *recordings)
    second = studio.open()
    second.click("#tab-fit")
    studio.settled(second)
    second.select_option("#model", "mf52")
    studio.until(page, "studio.state.sections.fit.model === 'mf52'")
    page.evaluate("studio.state.version = 'stale'")
    page.select_option("#signs", "iso")
    studio.until(page, "document.getElementById('message').textContent.includes('another window')")
    assert "signs = " not in studio.project().replace("# signs", "")
    studio.settled(page)
    second.click("#run-fit")
    studio.until(page, "studio.running")
    second.click("#stop")
    studio.until(second, "!studio.running")
    assert not (studio.folder / "results" / "fit.json").exists()
    text = studio.project()
    second.click("#run-fit")
    studio.until(second, "studio.running")
    studio.end(signal.SIGKILL)
    assert studio.project() == text
    studio.problems.clear()  # the lost connection
    page.context.close()
    second.context.close()
    studio.start()
    page = studio.open()
    page.click("#tab-fit")
    studio.until(page, "document.getElementById('model').value === 'mf52'")
    studio.work(page, "#run-fit")
    assert page.inner_text("#verdict")
    page.click("#undo")
    studio.until(page, "document.getElementById('model').value === 'mf61'")


def test_a_wrong_unit_is_corrected_by_a_click(studio, recordings, tmp_path_factory):
    """The table is refused with its error; the button writes the unit; the table of columns has it."""
    path = tmp_path_factory.mktemp("unit") / "pounds.csv"
    table = recording_from(recordings[0]).table
    write_table(table.assign(Fz=table["Fz"] / 4.4482216), path)
    page = studio.open()
    add(studio, page, path)
    assert "Fz is in lbf" in page.inner_text("#tables .bad")
    if folder := os.environ.get("TIREFMU_STUDIO_PICTURES"):
        page.screenshot(path=f"{folder}/wrong_unit.png", full_page=True)
    page.click("text=Read so: Fz is in lbf")
    studio.until(page, "studio.state.sections.data.units?.Fz === 'lbf'")
    studio.settled(page)
    assert not page.locator("#tables .bad").count()
    page.click("text=what they were taken for")
    page.select_option("[aria-label='Unit of Fz in pounds.csv']", "")
    studio.until(page, "!studio.state.sections.data.units")
    studio.settled(page)
    page.click("[aria-label='Other sign of Fy in pounds.csv']")
    studio.until(page, "studio.state.sections.data.columns?.Fy === '-Fy'")
    studio.settled(page)
    assert "Fy has the other sign" in page.inner_text("#tables .bad")
    if folder:
        page.screenshot(path=f"{folder}/meanings.png", full_page=True)
    studio.type(page, "[aria-label='Column of Fy in pounds.csv']", "")
    studio.until(page, "!studio.state.sections.data.columns")


def test_sliders_move_curves_and_errors(studio, tmp_path_factory):
    """60,000 points: time from a move of a slider to new curves and errors; printed."""
    path = tmp_path_factory.mktemp("large") / "large.csv"
    program = alpha_sweeps(LOADS, CAMBERS, sample_rate=204.0)
    recording = VirtualBench(published("trento_hoosier"), Noise.none(), seed=1).run(program)
    write_table(recording.with_signs("iso").table, path)
    page = studio.open()
    add(studio, page, path)
    page.click("#tab-fit")
    studio.settled(page)
    studio.until(page, "studio.tabs.fit.errors")
    rows = page.evaluate("studio.tabs.fit.errors.Fy.all.rows")
    page.locator("#slider-PKY1").focus()
    times = []
    for _ in range(60):
        page.keyboard.press("ArrowLeft")
        studio.until(page, "Math.min(studio.tabs.fit.drawn, studio.tabs.fit.computed) >= studio.tabs.fit.moved")
        times.append(page.evaluate("Math.max(studio.tabs.fit.drawn, studio.tabs.fit.computed) - studio.tabs.fit.moved"))
    times.sort()
    print(f"\n{rows} points: curves, errors and residuals after {times[30]:.0f} ms (median), {times[57]:.0f} ms (95 %)")
    assert page.evaluate("studio.tabs.fit.now.changes().coefficients.length") == 1


def test_the_first_curves_of_a_fit(studio, tmp_path_factory):
    """20,000 rows: time from the click to the first curves of the fit, and to those of its first stage; printed."""
    path = tmp_path_factory.mktemp("fit") / "run.csv"
    program = alpha_sweeps(LOADS, CAMBERS, sample_rate=67.0)
    write_table(VirtualBench(published("trento_hoosier"), seed=1).run(program).with_signs("iso").table, path)
    page = studio.open()
    add(studio, page, path)
    page.click("#tab-fit")
    studio.settled(page)
    page.wait_for_timeout(5000)  # the process of the fit is loaded
    page.evaluate(
        """() => {
          window.stages = [];
          const { draw } = studio.tabs.fit;
          studio.tabs.fit.draw = function (moving) {
            draw.call(this, moving);
            stages.push([performance.now() - this.moved, this.name]);
          };
          const clicked = () => { studio.tabs.fit.moved = performance.now(); };
          document.getElementById("run-fit").addEventListener("click", clicked);
        }"""
    )
    page.click("#run-fit")
    studio.until(page, "studio.running")
    studio.settled(page)
    stages = page.evaluate("stages")
    print("\nfirst curves of a fit, s:", ", ".join(f"{name} {ms / 1000:.2f}" for ms, name in stages[:8]))
    assert stages[-1][1] == "result"
    assert any(name == "live" for _, name in stages)


@pytest.mark.parametrize("width", [1400, 390])
def test_pages_have_no_accessibility_findings(studio, recordings, width):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed: make studio")
    page = studio.open(width=width)
    add(studio, page, *recordings)
    page.keyboard.press("Tab")
    page.locator("summary").first.click()  # the table of columns
    page.locator("#tab-data").focus()
    for name in ("data", "fit", "compare", "diagnose", "export"):
        if name == "fit":
            studio.until(page, "studio.tabs.fit.errors")
            page.select_option("#model", "mf96")
            studio.settled(page)
            studio.work(page, "#run-fit")  # the other tabs have something to show
            page.locator("#tab-fit").focus()
        studio.settled(page)
        assert page.get_attribute(f"#tab-{name}", "aria-selected") == "true"
        violations = axe.Axe().run(page).response["violations"]
        assert not [(violation["id"], [node["html"] for node in violation["nodes"]]) for violation in violations], name
        assert page.evaluate("document.documentElement.scrollWidth") <= width, name
        if path := os.environ.get("TIREFMU_STUDIO_PICTURES"):
            page.screenshot(path=f"{path}/{name}_{width}.png", full_page=True)
        page.locator(f"#tab-{name}").focus()
        page.keyboard.press("ArrowRight")
