"""Figures and page of a drive: motion over time, forces over slip of each axle, a map of missing force."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...boundary.errors import TirefmuError, path_from
from ...drawing.figure import Figure, Panel, Series, band
from ...drawing.page import page_text, write_page
from ...drawing.style import DASHED, SOLID
from .inputs.car_entries import ENTRIES
from .inputs.unknowns import AXLES
from .interval import OUTPUTS
from .result import Drive
from .simulation import SIGNALS, estimated_motion, horizon

FloatArray = npt.NDArray[np.float64]

RECORDED, BEFORE, AFTER = "#555555", "#a33b00", "#0b4f9c"
#: Panels in a row of beliefs; values below which these are drawn in thousandths.
ROW, SMALL = 4, 2e-3
#: Most points of a series.
MAX_POINTS = 4000


def drive_figures(answer: Drive) -> list[Figure]:
    """Return the figures of an answer."""
    return [_histories(answer), *_left_out(answer), _forces(answer), _map(answer), _beliefs(answer)]


def _some(n: int) -> slice:
    return slice(None, None, max(1, n // MAX_POINTS))


def _histories(answer: Drive) -> Figure:
    grid, recorded = answer.grid, estimated_motion(answer.grid, answer.estimate).T
    labels = ("yaw rate (rad/s)", "ay (m/s²)", "lateral speed (m/s)")
    some = _some(len(grid.t))
    t = np.where(np.diff(grid.segment[some], append=grid.segment[-1]), np.nan, grid.t[some])  # no line over a gap
    panels = []
    for i, (label, course) in enumerate(zip(labels, recorded, strict=True)):
        series = (
            Series("line", t, course[some], RECORDED, "estimated from the log", size=2.0),
            Series("line", t, answer.before.motion[some, i], BEFORE, "simulated, car and tires as given", DASHED),
            Series("line", t, answer.after.motion[some, i], AFTER, "simulated, after"),
        )
        panels.append((Panel("time (s)", label, series, x_axis="time", width=12.0, height=2.6),))
    text = (
        f"The simulation starts every {horizon(answer.car):.2g} s from the estimated state. "
        "Steering and speed are those of the log."
    )
    return Figure("motion", "Motion over time", tuple(panels), text)


def _left_out(answer: Drive) -> list[Figure]:
    """Return the errors in the parts that were left out, if the drive has parts."""
    predicted = answer.verdict.left_out
    if not predicted:
        return []
    first, last, before, after = np.array(predicted.parts).T
    times = np.stack([first, last, np.full_like(first, np.nan)], axis=1).ravel()
    series = tuple(
        Series("line", times, np.repeat(errors, 3), color, label, dashes, size=2.2)
        for errors, color, label, dashes in (
            (before, BEFORE, "tires as given", DASHED),
            (after, AFTER, "new tires", SOLID),
        )
    )
    panel = Panel("time (s)", "rms error (rad/s)", series, width=12.0, height=2.6, y_limits=(0.0, None))
    text = (
        "Root mean square over yaw rate and, over the speed, lateral acceleration and lateral speed, in parts of the "
        "drive that the estimate did not see."
    )
    return [Figure("left_out", "Parts that were left out", ((panel,),), text)]


def _beliefs(answer: Drive) -> Figure:
    """Return what is believed of the entries of the car and of the factors before and after the drive."""
    unknowns, estimate = answer.unknowns, answer.estimate
    deviation = np.sqrt(np.diag(estimate.covariance))
    names = [*unknowns.car, *(f"log {name} {axle}" for axle, name in unknowns.factors)]
    units = [ENTRIES[name].unit for name in unknowns.car] + ["1"] * len(unknowns.factors)
    panels = []
    for i, name in enumerate(names):
        wide = np.linspace(min(-3.0, estimate.z[i] - 3.0), max(3.0, estimate.z[i] + 3.0), 61)
        z = np.sort(np.concatenate([wide, estimate.z[i] + deviation[i] * np.linspace(-4.0, 4.0, 61)]))
        before, after = np.exp(-(z**2) / 2), np.exp(-(((z - estimate.z[i]) / deviation[i]) ** 2) / 2)
        x = unknowns.center[i] + unknowns.spread[i] * z
        small = bool(np.abs(x).max() < SMALL)
        label = " ".join(["0.001"] * small + [units[i]] * (units[i] != "1")) or "value"
        x = 1e3 * x if small else x
        series = (
            Series("line", x, before, BEFORE, "before", DASHED, size=1.5),
            Series("line", x, after, AFTER, "after", size=2.0),
        )
        panels.append(Panel(label, "belief", series, name, width=3.0, height=1.8))
    rows = tuple(tuple(panels[first : first + ROW]) for first in range(0, len(panels), ROW))
    text = "Belief relative to the most probable value: before, that of the car file; after, with the drive."
    return Figure("beliefs", "Car and tires before and after the drive", rows, text)


def _forces(answer: Drive) -> Figure:
    values, deviation = answer.estimate.outputs, answer.wheels["Fy_sd"].to_numpy().reshape(2, -1)
    panels = []
    for i, axle in enumerate(AXLES):
        alpha, Fz, Fy = (values[:, OUTPUTS.index(f"{name}_{axle}")] for name in ("alpha", "Fz", "Fy"))
        some, load = _some(len(alpha)), float(np.median(Fz))
        slips = np.linspace(max(alpha.min(), -np.pi / 2), min(alpha.max(), np.pi / 2), 121)
        degrees = np.degrees(slips)
        curves = [
            tire.forces(alpha=slips, Fz=load, code="numpy")["Fy"] for tire in (answer.tires[axle], answer.scaled[axle])
        ]
        lines = (
            Series("line", degrees, curves[0], BEFORE, "tire as given", DASHED, size=2.2),
            Series("line", degrees, curves[1], AFTER, "tire after", size=2.2),
        )
        spread, after = 1.96 * float(np.median(deviation[i])), curves[1]
        points = Series(
            "points", np.degrees(alpha[some]), Fy[some], RECORDED, "drive", marker="o", size=1.5, opacity=0.5
        )
        panels.append(
            Panel(
                "slip angle (deg)", "Fy (N)", (band(degrees, after - spread, after + spread, AFTER), points, *lines),
                f"{axle} axle, mean wheel, curves at {load:.4g} N", across=(0.0,), upright=(0.0,),
            )
        )  # fmt: skip
    return Figure(
        "forces", "Side force over slip angle", (tuple(panels),), "Band: 95 % of the force of the drive. ISO-W signs."
    )


def _map(answer: Drive) -> Figure:
    x, y = _track(answer)
    panels = []
    for i, axle in enumerate(AXLES):
        size = np.abs(answer.lacking[:, :, i])
        large = size > np.quantile(size[0], 0.9)
        series = tuple(
            Series("points", x[rows], y[rows], color, label, marker="o", size=2.0)
            for rows, color, label in (
                (~large[0], RECORDED, "other places"),
                (large[0] & ~large[1], BEFORE, "largest 10 % before"),
                (large[1], AFTER, "as large after"),
            )
            if rows.any()
        )
        panels.append(Panel("x (m)", "y (m)", series, f"{axle} axle", equal=True))
    text = "Places with the largest side force that the motion requires beyond the tires."
    if not answer.log.has_pose():
        text += " The track follows from speed and yaw rate: it drifts."
    return Figure("map", "Where the drive and the tires disagree", (tuple(panels),), text)


def _track(answer: Drive) -> FloatArray:
    """Return the positions in the middle of the intervals, shape (2, n), m; without a pose they are integrated."""
    states = answer.estimate.states[answer.grid.left]
    if answer.log.has_pose():
        return states[:, 3:5].T
    heading = np.cumsum(states[:, 2]) * answer.grid.step
    speed = (states[:, 0] + 1j * states[:, 1]) * np.exp(1j * heading)
    track = np.cumsum(speed) * answer.grid.step
    return np.stack([track.real, track.imag])


def write_drive(answer: Drive, path: str | Path, *, command: str = "") -> None:
    """Write the page of an answer: verdict, factors, car, simulation, figures.

    `command`: the command line, for the provenance. Raises `TirefmuError` if the file cannot be written.
    """
    path = path_from(path)
    content: dict[str, Any] = answer.to_json()
    page = page_text(
        "tirefmu.applications.driving", {"short": _short}, answer=content, entries=ENTRIES, simulated=SIGNALS,
        horizon=horizon(answer.car), figures=drive_figures(answer),
        origin=[("log", answer.log.source), ("car", answer.car.source), ("command", command or "tirefmu.drive")],
    )  # fmt: skip
    try:
        write_page(page, path)
    except OSError as error:
        raise TirefmuError(f"{path}: cannot be written ({error.strerror or error})") from None


def _short(number: float | None) -> str:
    return "-" if number is None else f"{number:.4g}"
