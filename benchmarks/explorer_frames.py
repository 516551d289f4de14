"""Times of the explorer page's frames while a slider moves: five curves over 20,000 measured points in Chromium."""

from __future__ import annotations

import json
import shutil
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from playwright.sync_api import Browser, Page, sync_playwright

from tirefmu.applications.explorer.explore import explore
from tirefmu.measurements import Recording
from tirefmu.tires import Tire, published

ROWS, FRAMES = 20_000, 300
#: Sliders that move: of a coefficient, which changes the curves of one tire, and of an input, which changes all curves.
SLIDERS = {"coefficient PDY1": 'panel.rows.get("PDY1")', "input Fz": 'inputRows.get("Fz")'}
#: Moves a slider in every frame, and returns the milliseconds between the frames, and those that computed the curves.
MOVE = """(frames) => new Promise((resolve) => {
  const row = ROW;
  const [starts, computed] = [[], []];
  const original = sweep;
  let spent = 0;
  sweep = (...given) => {
    const start = performance.now();
    const found = original(...given);
    spent += performance.now() - start;
    return found;
  };
  const step = (time) => {
    starts.push(time);
    computed.push(spent);
    spent = 0;
    row.slider.value = row.spec.value * (1 + 0.1 * Math.sin(starts.length / 10));
    row.slider.dispatchEvent(new Event("input"));
    if (starts.length <= frames) requestAnimationFrame(step);
    else {
      sweep = original;
      resolve([starts.slice(1).map((each, i) => each - starts[i]), computed.slice(1)]);
    }
  };
  requestAnimationFrame(step);
})"""
#: What the page's main thread does for a frame: scripts, layout, and the drawing of the canvases.
FRAME, SCRIPTS = "ProxyMain::BeginMainFrame", "FireAnimationFrame"


def recording(tire: Tire) -> Recording:
    """Return one sweep of the slip angle with noise."""
    rng = np.random.default_rng(0)
    table = pd.DataFrame({"alpha": rng.uniform(-0.2, 0.2, ROWS), "Fz": 700.0 + rng.normal(0.0, 5.0, ROWS)})
    side = tire.forces(alpha=table["alpha"].to_numpy(), Fz=table["Fz"].to_numpy())["Fy"]
    return Recording(table.assign(Fy=side + rng.normal(0.0, 20.0, ROWS)), "iso", "one sweep")


def measured(browser: Browser, page: Page, row: str, trace: Path) -> dict[str, NDArray[np.float64]]:
    """Return times of each frame in ms while a slider moves.

    Computing is in the scripts, and these are in the main thread's time; its CPU time is that of the same frames
    without waiting for other processes of the machine.
    """
    browser.start_tracing(page=page, path=trace, categories=["devtools.timeline", "cc", "blink"])
    between, computing = page.evaluate(MOVE.replace("ROW", row), FRAMES)
    browser.stop_tracing()
    events = json.loads(trace.read_text(encoding="utf-8"))["traceEvents"]
    frames = [event for event in events if event["name"] == FRAME and event["ph"] == "X"]
    scripts = [event for event in events if event["name"] == SCRIPTS and event["ph"] == "X"]
    # Two callbacks share a frame: the one that moves the slider, and the page's.
    sums = [
        sum(script["dur"] for script in scripts if 0 <= script["ts"] - frame["ts"] < frame["dur"]) / 1e3
        for frame in frames
    ]
    whole = np.array([frame["dur"] / 1e3 for frame in frames])
    return {
        "computing the curves": np.array(computing),
        "all scripts": np.array(sums),
        "layout and drawing": whole - np.array(sums),
        "main thread": whole,
        "main thread, CPU": np.array([frame["tdur"] / 1e3 for frame in frames if "tdur" in frame]),
        "from frame to frame": np.array(between),
    }


def main() -> None:
    """Print the times."""
    tire = published("trento_hoosier").in_signs("iso")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as running:
        path = Path(folder) / "page.html"
        explore(tire, path, tables=[recording(tire)])
        chromium = running.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = chromium.new_page(viewport={"width": 1400, "height": 900})
        page.goto(f"{path.as_uri()}#loads=5")
        page.wait_for_timeout(1000)
        points = page.evaluate("measured.conditions[0].rows")
        visible = page.evaluate("charts.filter((chart) => chart.visible).length")
        print(f"{points} points, 5 loads, {visible} visible charts, {FRAMES} frames, software rendering; ms per frame")
        for title, row in SLIDERS.items():
            print(f"{title:24}     min  median    95 %")
            for what, times in measured(chromium, page, row, Path(folder) / "trace.json").items():
                print(f"  {what:22}{times.min():8.1f}{np.median(times):8.1f}{np.quantile(times, 0.95):8.1f}")
        chromium.close()


if __name__ == "__main__":
    main()
