"""Figure of what identified effects improve: the force that is missing without each, over the input it acts through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from ...drawing.figure import Figure, Panel, Series, in_rows
from ...drawing.labels import axis_label, drawn_unit, note, per_si
from ...drawing.residual_panels import INPUTS, bins
from ...drawing.style import BLUE, DASHED, RED
from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ...tires.signs import convert_signs
from ..verdict.findings import FoundEffect
from ..verdict.result import Diagnosis
from .memory_figure import evaluated, widest_slip


def gain_figure(diagnosis: Diagnosis) -> Figure | None:
    """Return a panel for each identified effect: the mean residual in its direction, without and with it.

    None if the improved tire has none of the identified effects.
    """
    panels = [_panel(diagnosis, finding) for finding in diagnosis.found if finding.effect in diagnosis.tire.has]
    text = (
        "measured minus computed, positive in the direction in which the effect acts, mean of rows with similar input "
        "weighted by the effect's force; the offset of the recording is removed"
    )
    under = note(diagnosis.signs, text)
    return Figure("diagnosis_gain", "What each identified effect adds", in_rows(panels), under) if panels else None


def _panel(diagnosis: Diagnosis, finding: FoundEffect) -> Panel:
    tire, rows = diagnosis.tire, diagnosis.rows
    without = replace(tire, effects=tire.has - {finding.effect})
    error = diagnosis.gap["train"]
    channel = min(finding.channels, key=lambda name: graded(error[name]["after"] / max(error[name]["before"], 1e-300)))
    forces = [evaluated(diagnosis, shown)[channel].to_numpy(dtype=np.float64) for shown in (without, tire)]
    response = forces[1] - forces[0]
    measured = _measured(diagnosis, channel)
    through = _input(diagnosis, finding.effect)
    at = convert_signs(rows[[through]], diagnosis.recording_signs, diagnosis.signs)[through]
    x = at.to_numpy(dtype=np.float64) * per_si(through)
    finite = np.isfinite(x) & np.isfinite(measured) & np.isfinite(response)
    parts = [part for part in bins(x, finite) if np.abs(response[part]).any()]
    lines = []
    for force, label, color, dashes in zip(forces, ("without", "with"), (RED, BLUE), (DASHED, ()), strict=True):
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
    return next((name for name in required if name in diagnosis.rows), widest_slip(diagnosis.rows))


def _measured(diagnosis: Diagnosis, channel: str) -> FloatArray:
    """Return the measured force without the offset of the recording, in the signs of the recording."""
    offset = diagnosis.recording["removed"][channel]["offset"]
    signs = diagnosis.signs, diagnosis.recording_signs
    converted = float(convert_signs(pd.DataFrame({channel: [offset]}), *signs)[channel].iloc[0])
    return np.asarray(diagnosis.rows[channel], dtype=np.float64) - converted
