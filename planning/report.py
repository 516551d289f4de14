"""A planned program as files: rows over time, list of steps, plan.json, and a page with figures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd

from tirefmu.boundary.errors import path_from
from tirefmu.measurements import write_table
from tirefmu.tires.drawing.figure import Figure, Panel, Series
from tirefmu.tires.drawing.page import page_text, write_page
from tirefmu.tires.drawing.style import BLUE, level_styles

from .bench_file import PlanError
from .plan import PlanResult, Prediction
from .program import UNITS

#: What a target is in a text, by its name.
MEANING = {
    "Fx": "longitudinal force", "Fy": "side force", "Mz": "aligning moment", "friction_x": "longitudinal friction",
    "friction_y": "lateral friction", "stiffness_x": "longitudinal slip stiffness",
    "stiffness_y": "cornering stiffness",
}  # fmt: skip
#: Names of the written files.
ROWS, STEPS, JSON, PAGE = "program.csv", "steps.csv", "plan.json", "report.html"


def write_plan(result: PlanResult, folder: str | Path, *, command: str = "", next_command: str = "") -> list[Path]:
    """Write the program and its page.

    Parameters
    ----------
    result : PlanResult
        The program.
    folder : str or Path
        Created if it does not exist.
    command, next_command : str
        The command line, and the one that runs the program on the virtual bench.

    Returns
    -------
    list of Path
        ``program.csv`` (rows of inputs over time, SI), ``steps.csv`` (one line for each step, in deg, kPa and km/h),
        ``plan.json`` and ``report.html``.

    Raises
    ------
    PlanError
        If the folder cannot be written.
    """
    folder, steps = path_from(folder, "folder"), result.program.table
    page = page_text(
        "tirefmu.planning", {"percent": _percent, "meaning": meaning}, result=result, figures=figures(result),
        steps=steps.astype(object).where(steps.notna(), "").to_dict("split"), command=command,
        next_command=next_command,
    )  # fmt: skip
    paths = [folder / name for name in (ROWS, STEPS, JSON, PAGE)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_table(result.program.rows, paths[0])
        write_table(result.program.table, paths[1])
        paths[2].write_text(json.dumps(result.to_json(), indent=1, allow_nan=False) + "\n", encoding="utf-8")
        write_page(page, paths[3])
    except OSError as error:
        raise PlanError(f"{folder}: cannot be written ({error.strerror or error})") from None
    return paths


def meaning(name: str) -> str:
    """Return what a target is.

    >>> meaning("friction_y"), meaning("PKY1")
    ('lateral friction', 'PKY1')
    """
    return MEANING.get(name, name)


def figures(result: PlanResult) -> list[Figure]:
    """Return the program over time, and the intervals over bench time."""
    program = Figure("program", "Program", tuple((panel,) for panel in _input_panels(result.program.rows)))
    if result.prediction is None:
        return [program]
    return [program, Figure("intervals", "Predicted intervals", ((_widths_panel(result.prediction, result.today),),))]


def _input_panels(rows: pd.DataFrame) -> list[Panel]:
    """Return one panel for each input that varies; lines are interrupted in pauses."""
    t = rows["t"].to_numpy(float)
    gaps = np.flatnonzero(np.diff(t) > 2.0 * np.median(np.diff(t))) + 1
    panels = []
    for name, (unit, factor) in UNITS.items():
        if name in rows and np.ptp(rows[name]) > 0.0:
            values = np.insert(factor * rows[name].to_numpy(float), gaps, np.nan)
            series = Series("line", np.insert(t, gaps, np.nan), values, BLUE)
            label = f"{name} ({unit})" if unit else name
            panels.append(Panel("t (s)", label, (series,), x_axis="t", width=9.0, height=1.7))
    return panels


def _widths_panel(prediction: Prediction, today: Prediction | None) -> Panel:
    over, styles = prediction.over_time(), level_styles(len(prediction.targets), by="Fz")
    series, upright = [], []
    for target, style in zip(prediction.targets, styles, strict=True):
        minutes = [seconds / 60.0 for seconds, _ in over]
        widths = np.log10([100.0 * min(widths[target.name], 1.0) for _, widths in over])
        series.append(Series("line", minutes, widths, style.color, meaning(target.name), style.dashes))
        if today is not None:
            point = [np.log10(100.0 * today.widths[target.name])]
            series.append(Series("points", [today.seconds / 60.0], point, style.color, meaning(target.name),
                                 marker="x", size=6.0))  # fmt: skip
            upright = [today.seconds / 60.0]
    return Panel(
        "bench time (min)", "log10 of half width (%)", tuple(series), upright=tuple(upright),
        x_limits=(0.0, None), width=9.0,
    )  # fmt: skip


def _percent(width: float) -> str:
    return f"{100.0 * width:.3g} %"


def result_rows(result: PlanResult) -> tuple[list[str], list[list[str]]]:
    """Return header and rows of the table of intervals, or of separations."""
    if result.prediction is None:
        rows = [[one.effect, one.rival, f"{one.evidence:.3g}"] for one in result.separations]
        return ["effect", "fitted instead", "expected evidence (nats)"], rows
    header = ["quantity", "95 % interval, planned"] + ([result.today.name] if result.today is not None else [])
    rows = []
    for name, width in result.prediction.widths.items():
        more = [f"+-{_percent(result.today.widths[name])}"] if result.today is not None else []
        rows.append([meaning(name), f"+-{_percent(width)}", *more])
    return header, rows
