"""Figure of the correction of the formula's own form: its share of a force over slip, at loads of the tested range."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ...drawing.figure import Figure, Panel, Series
from ...drawing.labels import axis_label, drawn_unit, per_si
from ...drawing.style import BLUE, DASHED, GRAY, RED, SOLID
from ..explanations.form import without_form
from ..verdict.result import Diagnosis
from .memory_figure import widest_slip

#: Points of a line; loads as quantiles of those of the recording, with their color and dashes. Conventions.
POINTS = 121
LOADS = ((0.1, BLUE, SOLID), (0.5, GRAY, DASHED), (0.9, RED, SOLID))


def form_figure(diagnosis: Diagnosis) -> Figure:
    """Return the change of each corrected channel by the correction over the slip that varies most.

    `diagnosis`: with a correction of the form.
    """
    rows = diagnosis.rows
    slip = widest_slip(rows)
    at = np.linspace(rows[slip].min(), rows[slip].max(), POINTS)
    plain, panels = without_form(diagnosis.tire), dict[str, list[Series]]()
    for quantile, color, dashes in LOADS:
        load = float(np.quantile(np.abs(rows["Fz"]), quantile))
        sign = float(np.sign(rows["Fz"].median()))
        table = pd.DataFrame({slip: at, "Fz": sign * load})
        with_it, without = (tire.evaluate(table, signs=diagnosis.recording_signs) for tire in (diagnosis.tire, plain))
        for channel in diagnosis.form.channels:
            change = (with_it[channel] - without[channel]).to_numpy() * per_si(channel)
            line = Series("line", at * per_si(slip), change, color, f"Fz {load:.0f} N", dashes)
            panels.setdefault(channel, []).append(line)
    drawn = tuple(
        Panel(axis_label(slip), f"correction of {channel} ({drawn_unit(channel)})", tuple(lines), across=(0.0,))
        for channel, lines in panels.items()
    )
    return Figure("form", "Correction of the formula's own form", (drawn,))
