"""The forces at the wheels as a recording: for each axle the wheel that is the mean of its two."""

from __future__ import annotations

import numpy as np
import pandas as pd

from .estimate import Estimate
from .inputs.grid import Grid
from .interval import OUTPUTS
from .unknowns import AXLES

#: Time between the last row of the front axle and the first one of the rear axle: a gap, so that they are two segments.
GAP = 10.0


def wheel_table(grid: Grid, estimate: Estimate) -> pd.DataFrame:
    """Return the recording in ISO-W signs: rows of the front axle, then of the rear axle, whose time goes on.

    Columns: ``t kappa alpha gamma Fz V Fy``; the standard deviations ``Fy_sd`` (N) and ``alpha_sd`` (rad); ``axle`` 1
    for front and 2 for rear; ``t_log``, the time in the log, s. There is no Fx: kappa is the slip at which the tire has
    the force that the motion requires.
    """
    deviation = np.sqrt(np.maximum(estimate.variances(estimate.outputs.jacobian), 0.0))
    parts = []
    for number, axle in enumerate(AXLES):
        columns = {
            name: estimate.outputs.values[:, OUTPUTS.index(f"{name}_{axle}")]
            for name in ("kappa", "alpha", "Fz", "V", "Fy")
        }
        spread = {f"{name}_sd": deviation[:, OUTPUTS.index(f"{name}_{axle}")] for name in ("Fy", "alpha")}
        start = number * (grid.t[-1] - grid.t[0] + GAP)
        table = pd.DataFrame(
            {"t": grid.t + start, **columns, "gamma": 0.0, **spread, "axle": number + 1, "t_log": grid.t}
        )
        parts.append(table[["t", "kappa", "alpha", "gamma", "Fz", "V", "Fy", "Fy_sd", "alpha_sd", "axle", "t_log"]])
    return pd.concat(parts, ignore_index=True)
