"""Figures of what the improved tire adds: the gain of each effect, memories, and the correction of the form.

The gain of an effect is the force that is missing without it, over the input that it acts through. A memory is shown
as force and residual for growing and falling slip, before and after, and as its states. The correction of the form is
shown as its share of a force over slip, at loads of the tested range.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from ...drawing.figure import Figure, Panel, Series, in_rows
from ...drawing.labels import axis_label, drawn_unit, note, per_si
from ...drawing.residual_panels import INPUTS, bins
from ...drawing.style import BLACK, BLUE, DASHED, GRAY, RED, SOLID
from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ...symbolic.quantities import ALPHA, KAPPA
from ...tires.signs import convert_signs
from ..explanations.form import MIN_SLIPS, without_form
from ..signals.signals import FORMULA_SIGNS
from ..verdict.findings import FoundEffect
from ..verdict.residual_location import MIN_ROWS_OF_CELL
from ..verdict.result import Diagnosis
from .residual_figure import coincide

#: Intervals of slip whose means are drawn, and the minimum number of rows of an interval of a force.
INTERVALS, MIN_ROWS_OF_FORCE = 24, 2
#: Distance from the most frequent load of the rows whose force is drawn, as a share of the nominal load.
LOAD_BAND = 0.08
#: Directions of slip: label, sign of the growth, color, marker and dashes.
DIRECTIONS = (("size of slip grows", 1.0, RED, SOLID), ("falls", -1.0, BLUE, DASHED))
#: Seconds over which the direction of slip is determined.
SMOOTHED = 0.1
#: Points of a line; loads as quantiles of those of the recording, with their color and dashes. Conventions.
POINTS = 121
LOADS = ((0.1, BLUE, SOLID), (0.5, GRAY, DASHED), (0.9, RED, SOLID))


def gain_figure(diagnosis: Diagnosis) -> Figure | None:
    """Return a panel for each identified effect: the mean residual in its direction, without and with it.

    None if the improved tire has none of the identified effects: those with a probability of one half, and of a class.
    """
    doubtful = diagnosis.answer.doubtful(finding.effect for finding in diagnosis.found)
    drawn = [
        finding
        for finding in diagnosis.found
        if finding.effect in diagnosis.tire.has and finding.effect not in doubtful
    ]
    panels = [_gain_panel(diagnosis, finding) for finding in drawn]
    text = (
        "measured minus computed, positive in the direction in which the effect acts, mean of rows with similar input "
        "weighted by the effect's force; the offset of the recording is removed"
    )
    under = note(diagnosis.signs, text)
    return Figure("diagnosis_gain", "What each identified effect adds", in_rows(panels), under) if panels else None


def _gain_panel(diagnosis: Diagnosis, finding: FoundEffect) -> Panel:
    """Return the panel of an effect, of the compared rows."""
    rows, error, signs = diagnosis.rows.iloc[diagnosis.run.compared], diagnosis.gap["train"], diagnosis.recording_signs
    channel = min(finding.channels, key=lambda name: graded(error[name]["after"] / max(error[name]["before"], 1e-300)))
    changes = pd.DataFrame(dict(zip(error, diagnosis.evidence[finding.effect].change, strict=True)))
    response = convert_signs(changes, FORMULA_SIGNS, signs)[channel].to_numpy()
    computed = diagnosis.run.computed[1][channel].to_numpy()[diagnosis.run.compared]
    measured = _measured(diagnosis, rows, channel)
    through = _input(diagnosis, finding.effect)
    at = convert_signs(rows[[through]], signs, diagnosis.signs)[through]
    x = at.to_numpy(dtype=np.float64) * per_si(through)
    finite = np.isfinite(x) & np.isfinite(measured) & np.isfinite(response)
    parts = [part for part in bins(x, finite) if np.abs(response[part]).any()]
    lines = []
    for force, label, color, dashes in (
        (computed - response, "without", RED, DASHED), (computed, "with", BLUE, SOLID),
    ):  # fmt: skip
        lacking = (measured - force) * response
        means = [lacking[part].sum() / np.abs(response[part]).sum() for part in parts]
        centers = [float(np.median(x[part])) for part in parts]
        lines.append(Series("line", centers, means, color, label, dashes, marker="o"))
    y = f"{channel} that is missing ({drawn_unit(channel)})"
    return Panel(axis_label(through, diagnosis.signs), y, tuple(lines), f"{finding.effect}: {channel}", across=(0.0,))


def _input(diagnosis: Diagnosis, effect: str) -> str:
    """Return the recorded input that an effect requires; otherwise the slip that varies most."""
    detection = diagnosis.tire.symbolic_model.detections.get(effect)
    required = [name for name in detection.requires if name in INPUTS] if detection else []
    return next((name for name in required if name in diagnosis.rows), "") or _widest_slip(diagnosis.rows)


def _measured(diagnosis: Diagnosis, rows: pd.DataFrame, channel: str) -> FloatArray:
    """Return the measured force in some rows without the offset of the recording, in the signs of the recording."""
    offset = diagnosis.recording["removed"][channel]["offset"]
    signs = diagnosis.signs, diagnosis.recording_signs
    converted = float(convert_signs(pd.DataFrame({channel: [offset]}), *signs)[channel].iloc[0])
    return np.asarray(rows[channel], dtype=np.float64) - converted


def memory_figure(diagnosis: Diagnosis, channel: str) -> Figure:
    """Return force and mean residual over the slip that varies most, by its direction, and states of the improved tire.

    The force is that at the most frequent load, measured and of both tires; the residual is that of all rows.

    `diagnosis`: of a recording with time, whose improved tire has states.
    """
    slip = _widest_slip(diagnosis.rows)
    forces, residuals = [], []
    for of_tire, title in zip(diagnosis.run.computed, ("baseline tire", "improved tire"), strict=True):
        values = of_tire[channel].to_numpy(dtype=np.float64)
        forces.append(_force_panel(diagnosis, values, channel, slip, title))
        residuals.append(_residual_panel(diagnosis, values, channel, slip, title))
    computed, t = diagnosis.run.computed[1], diagnosis.rows["t"]
    declared = diagnosis.tire.symbolic_model.states
    units = {name: "-" if declared[name].unit == "1" else declared[name].unit for name in diagnosis.tire.states}
    states = [
        Panel("t (s)", f"{name} ({units[name]})", (Series("line", t, computed[name], size=0.9),),
              x_axis="time", height=1.5)
        for name in diagnosis.tire.states if np.ptp(computed[name]) > 0.0
    ]  # fmt: skip
    rows = (tuple(forces), tuple(residuals), *((panel,) for panel in states))
    return Figure(f"memory_{channel}", f"{channel} by direction of slip, and states over time", rows)


def _widest_slip(rows: pd.DataFrame) -> str:
    """Return the slip that varies most in the rows of a recording."""
    return max((name for name in (ALPHA.name, KAPPA.name) if name in rows), key=lambda name: graded(np.ptp(rows[name])))


def _force_panel(diagnosis: Diagnosis, computed: FloatArray, channel: str, slip: str, title: str) -> Panel:
    """Return the mean force over slip at the most frequent load by direction, measured and of a tire."""
    rows = diagnosis.rows
    load = np.abs(rows["Fz"].to_numpy(dtype=np.float64))
    width = LOAD_BAND * diagnosis.tire.values["FNOMIN"]
    count, edges = np.histogram(load, np.arange(load.min(), load.max() + 2.0 * width, width))
    frequent = float(edges[count.argmax()]) + width / 2.0
    near = np.abs(load - frequent) <= width
    measured = rows[channel].to_numpy(dtype=np.float64)
    of_tire = np.where(near & np.isfinite(measured), computed, np.nan)
    x, shown = _by_direction(rows, np.where(near, measured, np.nan), slip, MIN_ROWS_OF_FORCE)
    means = _by_direction(rows, of_tire, slip, MIN_ROWS_OF_FORCE)[1]
    points = [
        Series("points", x, mean, color, f"measured, {label}", marker="o", size=4.0)
        for (label, _, color, _), mean in zip(DIRECTIONS, shown, strict=True)
    ]
    lines = [
        Series("line", x, mean, color, f"tire, {label}", dashes, size=1.3)
        for (label, _, color, dashes), mean in zip(DIRECTIONS, means, strict=True)
    ]
    if coincide(*means, *shown):
        mean = np.where(np.isfinite(means[0]), *means)
        lines = [Series("line", x, mean, BLACK, "tire, both directions", size=1.3)]
    return Panel(
        axis_label(slip), axis_label(channel), (*points, *lines), f"{title}, Fz near {frequent:.0f} N", y_axis="force",
        height=2.8,
    )  # fmt: skip


def _residual_panel(diagnosis: Diagnosis, computed: FloatArray, channel: str, slip: str, title: str) -> Panel:
    """Return the mean residual over slip, separately for rising and for falling slip."""
    residual = diagnosis.rows[channel].to_numpy(dtype=np.float64) - computed
    x, means = _by_direction(diagnosis.rows, residual, slip, MIN_ROWS_OF_CELL)
    series = [
        Series("line", x, mean, color, label, dashes, size=1.2)
        for (label, _, color, dashes), mean in zip(DIRECTIONS, means, strict=True)
    ]
    y = f"mean residual of {channel} ({drawn_unit(channel)})"
    return Panel(axis_label(slip), y, tuple(series), title, across=(0.0,), y_axis="residual", height=2.4)


def _by_direction(rows: pd.DataFrame, values: FloatArray, slip: str, least: int) -> tuple[FloatArray, list[FloatArray]]:
    """Return intervals of slip, in the drawn unit, and for each of `DIRECTIONS` the mean value of its rows in them."""
    t, at = (rows[name].to_numpy(dtype=np.float64) for name in ("t", slip))
    later, earlier = (np.interp(t + sign * SMOOTHED / 2.0, t, np.abs(at)) for sign in (1.0, -1.0))
    edges = np.linspace(at.min(), at.max(), INTERVALS + 1)
    place = np.clip(np.digitize(at, edges) - 1, 0, INTERVALS - 1)
    means = []
    for _, direction, *_ in DIRECTIONS:
        averaged = (direction * (later - earlier) > 0.0) & np.isfinite(values)
        count = np.bincount(place[averaged], minlength=INTERVALS)
        total = np.bincount(place[averaged], values[averaged], INTERVALS)
        means.append(np.where(count >= least, total / np.maximum(count, 1), np.nan))
    return 0.5 * (edges[1:] + edges[:-1]) * per_si(slip), means


def form_figure(diagnosis: Diagnosis) -> Figure:
    """Return the change of each channel by the correction over each slip, where it is not zero.

    At no other slip; of a recording of combined slip, also at the other slip that is combined most.

    `diagnosis`: with a correction of the form.
    """
    rows = diagnosis.rows
    tire = replace(diagnosis.tire, added=diagnosis.run.tested)  # its equations are printed already
    plain, sign = without_form(tire), float(np.sign(rows["Fz"].median()))
    panels = dict[tuple[str, str, str], list[Series]]()
    for slip, fixed, title in _slips(rows):
        at = np.linspace(rows[slip].min(), rows[slip].max(), POINTS)
        for quantile, color, dashes in LOADS:
            load = float(np.quantile(np.abs(rows["Fz"]), quantile))
            table = pd.DataFrame({slip: at, "Fz": sign * load, **fixed})
            with_it, without = (either.evaluate(table, signs=diagnosis.recording_signs) for either in (tire, plain))
            for channel in diagnosis.form.channels:
                change = (with_it[channel] - without[channel]).to_numpy() * per_si(channel)
                line = Series("line", at * per_si(slip), change, color, f"Fz {load:.0f} N", dashes)
                panels.setdefault((slip, title, channel), []).append(line)
    shown = {key: lines for key, lines in panels.items() if any(np.any(line.y) for line in lines)} or panels
    drawn = [
        Panel(axis_label(slip), f"correction of {channel} ({drawn_unit(channel)})", tuple(lines), title, across=(0.0,))
        for (slip, title, channel), lines in shown.items()
    ]
    return Figure("form", "Correction of the formula's own form", in_rows(drawn))


def _slips(rows: pd.DataFrame) -> list[tuple[str, dict[str, float], str]]:
    """Return each slip without the other one and, if they are combined, with it; and titles that state the other."""
    recorded = [name for name in (ALPHA.name, KAPPA.name) if name in rows and np.ptp(rows[name]) > 0.0]
    if len(recorded) == 1:
        return [(recorded[0], {}, "")]
    combined = np.minimum(*(rows[name].abs().to_numpy(dtype=np.float64) for name in recorded))
    most = rows[recorded].iloc[int(combined.argmax())].to_dict() if combined.max() > MIN_SLIPS else {}
    return [
        (slip, {other: size}, f"{axis_label(other)}: {size * per_si(other):.3g}")
        for slip, other in (recorded, recorded[::-1])
        for size in dict.fromkeys((0.0, most.get(other, 0.0)))
    ]
