"""Times of the explorer page's frames while a slider moves: five curves over 20,000 measured points in Chromium."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from playwright.sync_api import CDPSession, sync_playwright

from tirefmu.explorer.explore import explore
from tirefmu.measurements import Recording
from tirefmu.tires import Tire, published

ROWS, FRAMES = 20_000, 120
#: Moves a slider in every frame, and returns the milliseconds between the frames.
MOVE = """(frames) => new Promise((resolve) => {
  const row = panel.rows.get("PDY1");
  const times = [];
  const step = (time) => {
    times.push(time);
    row.slider.value = row.spec.value * (1 + 0.1 * Math.sin(times.length / 10));
    row.slider.dispatchEvent(new Event("input"));
    if (times.length <= frames) requestAnimationFrame(step);
    else resolve(times.slice(1).map((each, i) => each - times[i]));
  };
  requestAnimationFrame(step);
})"""

#: Adds up the time in which curves are computed, apart from drawing them.
COUNT = """() => {
  const original = sweep;
  window.computed = 0;
  window.sweep = (...given) => {
    const start = performance.now();
    const found = original(...given);
    window.computed += performance.now() - start;
    return found;
  };
}"""


def recording(tire: Tire) -> Recording:
    """Return one sweep of the slip angle with noise."""
    rng = np.random.default_rng(0)
    table = pd.DataFrame({"alpha": rng.uniform(-0.2, 0.2, ROWS), "Fz": 700.0 + rng.normal(0.0, 5.0, ROWS)})
    side = tire.forces(alpha=table["alpha"].to_numpy(), Fz=table["Fz"].to_numpy())["Fy"]
    return Recording(table.assign(Fy=side + rng.normal(0.0, 20.0, ROWS)), "iso", "one sweep")


def metrics(session: CDPSession) -> dict[str, float]:
    """Return the time of the page's main thread so far, s: scripts, and all tasks."""
    found = {each["name"]: each["value"] for each in session.send("Performance.getMetrics")["metrics"]}
    return {name: found[name] for name in ("ScriptDuration", "TaskDuration")}


def main() -> None:
    """Print the times."""
    tire = published("trento_hoosier").in_signs("iso")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as running:
        path = Path(folder) / "page.html"
        explore(tire, path, recordings=[recording(tire)])
        chromium = running.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = chromium.new_page(viewport={"width": 1400, "height": 900})
        page.goto(f"{path.as_uri()}#loads=5")
        page.wait_for_timeout(1000)
        points = page.evaluate("measured.conditions[0].rows")
        session = page.context.new_cdp_session(page)
        session.send("Performance.enable")
        page.evaluate(COUNT)
        before = metrics(session)
        frames = np.array(page.evaluate(MOVE, FRAMES))
        used = {name: 1e3 * (value - before[name]) / FRAMES for name, value in metrics(session).items()}
        used = {"computing the curves": page.evaluate("window.computed") / FRAMES, **used}
        visible = page.evaluate("charts.filter((each) => each.visible).length")
        chromium.close()
    print(f"{points} points, 5 loads, {visible} visible charts, {FRAMES} frames, software rendering")
    print(f"between frames: median {np.median(frames):.1f} ms, 95 % {np.quantile(frames, 0.95):.1f} ms")
    print("per frame: " + ", ".join(f"{name} {value:.1f} ms" for name, value in used.items()))


if __name__ == "__main__":
    main()
