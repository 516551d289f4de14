"""Figures of a drive: the motion over time, forces over slip of each axle, a map of the force that the tires lack."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ...drawing.figure import Figure, Panel, Series, band
from ...drawing.style import DASHED
from .inputs.unknowns import AXLES
from .interval import OUTPUTS
from .simulation import estimated_motion

if TYPE_CHECKING:
    from .result import Drive

FloatArray = npt.NDArray[np.float64]

RECORDED, BEFORE, AFTER = "#555555", "#a33b00", "#0b4f9c"
#: Most points of a series.
MAX_POINTS = 4000


def drive_figures(answer: Drive) -> list[Figure]:
    """Return the figures of an answer."""
    return [_histories(answer), _forces(answer), _map(answer)]


def _some(n: int) -> slice:
    return slice(None, None, max(1, n // MAX_POINTS))


def _histories(answer: Drive) -> Figure:
    grid, recorded = answer.grid, estimated_motion(answer.grid, answer.estimate).T
    labels = ("yaw rate (rad/s)", "ay (m/s²)", "lateral speed (m/s)")
    some = _some(len(grid.t))
    panels = []
    for i, (label, course) in enumerate(zip(labels, recorded, strict=True)):
        series = (
            Series("line", grid.t[some], course[some], RECORDED, "estimated from the log", size=2.0),
            Series(
                "line", grid.t[some], answer.before.motion[some, i], BEFORE, "simulated, car and tires as given", DASHED
            ),
            Series("line", grid.t[some], answer.after.motion[some, i], AFTER, "simulated, after"),
        )
        panels.append((Panel("time (s)", label, series, x_axis="time", width=12.0, height=2.6),))
    text = "The simulation starts every 2 s from the estimated state. Steering and speed are those of the log."
    return Figure("motion", "Motion over time", tuple(panels), text)


def _forces(answer: Drive) -> Figure:
    values, deviation = answer.estimate.outputs.values, answer.wheels["Fy_sd"].to_numpy().reshape(2, -1)
    panels = []
    for i, axle in enumerate(AXLES):
        alpha, Fz, Fy = (values[:, OUTPUTS.index(f"{name}_{axle}")] for name in ("alpha", "Fz", "Fy"))
        some, load = _some(len(alpha)), float(np.median(Fz))
        slips = np.linspace(alpha.min(), alpha.max(), 121)
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
            "points", np.degrees(alpha[some]), Fy[some], RECORDED, "drive", marker=".", size=1.5, opacity=0.5
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
            Series("points", x[rows], y[rows], color, label, marker=".", size=2.0)
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
