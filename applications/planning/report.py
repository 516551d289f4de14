"""A planned program as files: rows over time, list of steps, plan.json, and a page with figures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd

from ...boundary.errors import path_from, writing
from ...drawing.figure import Figure, Panel, Series
from ...drawing.page import page_text, write_page
from ...drawing.style import level_colors
from ...measurements import write_table
from .bench_file import PlanError
from .plan import PlanResult
from .program import UNITS

#: What a target is in a text, by its name.
MEANING = {
    "Fx": "longitudinal force", "Fy": "side force", "Mz": "aligning moment", "friction_x": "longitudinal friction",
    "friction_y": "lateral friction", "stiffness_x": "longitudinal slip stiffness",
    "stiffness_y": "cornering stiffness",
}  # fmt: skip


def write_plan(result: PlanResult, folder: str | Path, *, command: str = "", next_command: str = "") -> list[Path]:
    """Write the program and its page; returns their paths, the page last.

    `command`, `next_command`: the command line, and the one that runs the program on the virtual bench. Written are
    ``program.csv`` (rows of inputs over time, SI), ``steps.csv`` (one line for each step, in deg, kPa and km/h),
    ``plan.json`` and ``report.html``. Raises `PlanError` if the folder cannot be written.
    """
    folder, steps = path_from(folder, "folder"), result.program.table
    page = page_text(
        "tirefmu.applications.planning", {}, result=result, figures=figures(result), tables=tables(result),
        compared=comparison(result), command=command, next_command=next_command,
    )  # fmt: skip
    paths = [folder / name for name in ("program.csv", "steps.csv", "plan.json", "report.html")]
    with writing(folder, PlanError):
        folder.mkdir(parents=True, exist_ok=True)
        write_table(result.program.rows, paths[0])
        write_table(steps, paths[1])
        paths[2].write_text(json.dumps(result.to_json(), indent=1, allow_nan=False) + "\n", encoding="utf-8")
        write_page(page, paths[3])
    return paths


def comparison(result: PlanResult) -> str:
    """Return how a program compares with today's; empty without one."""
    if result.today is None:
        return ""
    equal, name, whole = result.equal_after, result.today.name, result.today.seconds / 60.0
    if equal is None:
        return f"At least one interval is wider than that of {name} after {whole:.1f} min."
    return f"After {equal / 60.0:.1f} min every interval is as narrow as that of {name} after {whole:.1f} min."


def tables(result: PlanResult) -> dict[str, tuple[list[str], list[list[str]]]]:
    """Return header and rows of the tables of the page by their titles: what the program determines comes first."""
    steps = result.program.table
    shown = {"Steps": (list(steps.columns), steps.astype(object).where(steps.notna(), "").to_numpy().tolist())}
    reasons = [[name, reason] for name, reason in result.undetermined.items()]
    if result.prediction is None:
        rows = [[pair.effect, pair.rival, f"{pair.evidence:.3g}"] for pair in result.separations]
        return {
            "Expected evidence": (["effect", "fitted instead", "expected evidence (nats)"], rows),
            **({"Not separated": (["effects", "why"], reasons)} if reasons else {}),
            **shown,
        }
    programs = [result.prediction, *([result.today] if result.today else [])]
    names = ["95 % interval, planned", *(program.name for program in programs[1:])]
    widths = [
        [MEANING.get(name, name), *(f"+-{100.0 * program.widths[name]:.3g} %" for program in programs)]
        for name in result.prediction.widths
    ]
    return {
        "Predicted intervals": (["quantity", *names], widths),
        "Not determined": (["coefficient", "why"], reasons or [["none", "the program determines every coefficient"]]),
        **shown,
    }


def figures(result: PlanResult) -> list[Figure]:
    """Return the program over time, and the intervals over bench time."""
    program = Figure("program", "Program", tuple((panel,) for panel in _input_panels(result.program.rows)))
    return [program, *([_widths(result)] if result.prediction else [])]


def _input_panels(rows: pd.DataFrame) -> list[Panel]:
    """Return one panel for each input that varies; lines are interrupted in pauses."""
    t = rows["t"].to_numpy(float)
    gaps = np.flatnonzero(np.diff(t) > 2.0 * np.median(np.diff(t))) + 1
    panels = []
    for name, (unit, factor) in UNITS.items():
        if name in rows and np.ptp(rows[name]) > 0.0:
            values = np.insert(factor * rows[name].to_numpy(float), gaps, np.nan)
            series = Series("line", np.insert(t, gaps, np.nan), values)
            label = f"{name} ({unit})" if unit else name
            panels.append(Panel("t (s)", label, (series,), x_axis="t", width=9.0, height=1.7))
    return panels


def _widths(result: PlanResult) -> Figure:
    """Return the intervals over bench time; points are those of the program to which it is compared."""
    minutes, series = [at["seconds"] / 60.0 for at in result.over_time], []
    end = [result.today.seconds / 60.0] if result.today else []
    names = [target.name for target in result.prediction.targets] if result.prediction else []
    for name, color in zip(names, level_colors(len(names), by="Fz"), strict=True):
        label, values = MEANING.get(name, name), [min(at["intervals"][name], 1.0) for at in result.over_time]
        series.append(Series("line", minutes, np.log10(values) + 2.0, color, label))
        if result.today:
            point = [np.log10(result.today.widths[name]) + 2.0]
            series.append(Series("points", end, point, color, label, marker="o", size=6.0))
    panel = Panel("bench time (min)", "log10 of half width (%)", tuple(series), upright=tuple(end),
                  x_limits=(0.0, None), width=9.0)  # fmt: skip
    return Figure("intervals", "Predicted intervals", ((panel,),))
