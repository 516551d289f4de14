"""Turn slip of a bench that turns the plane of the wheel about the vertical, from the rate of the slip angle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..boundary.errors import DataError
from ..numerics.smoothing import smoothed
from ..tires.signs import reversed_columns
from .recording import Recording

#: Longest step in time of a sweep, in median steps; and lowest speed with a turn slip, m/s.
GAP, LOWEST_SPEED = 5.0, 0.5


def with_turn_slip(recording: Recording) -> Recording:
    """Return a recording with the column phit = -(d alpha/dt)/V; one that has phit is returned unchanged.

    The contact point moves straight ahead and the wheel plane turns by the yaw angle psi. In ISO signs alpha = -psi,
    and the turn slip is psi'/V. The slip angle is smoothed before. Across a gap in time, and at standstill, phit is 0.

    Raises `DataError` if t, alpha or V is missing.

    Source: Pacejka, Tire and Vehicle Dynamics (2012), section 4.3.3: turn slip, the yaw rate over the speed.

    >>> import pandas as pd
    >>> table = pd.DataFrame({"t": [0.0, 0.1, 0.2], "alpha": [0.0, 0.02, 0.04], "V": 10.0})
    >>> with_turn_slip(Recording(table, "iso", "sweep")).table["phit"].round(4).tolist()
    [-0.02, -0.02, -0.02]
    """
    table = recording.table
    if "phit" in table:
        return recording
    for name in ("t", "alpha", "V"):
        if name not in table:
            raise DataError(f"{recording.source}: turn slip from the rate of the slip angle: column {name} is missing")
    t, alpha, speed = (table[name].to_numpy(dtype=np.float64) for name in ("t", "alpha", "V"))
    step = np.diff(t)
    forward = step[step > 0.0]
    longest = GAP * float(np.median(forward)) if len(forward) else 0.0
    rate = np.zeros(len(t))
    for part in np.split(np.arange(len(t)), np.flatnonzero((step <= 0.0) | (step > longest)) + 1):
        if len(part) > 1:
            rate[part] = np.gradient(smoothed(alpha[part])[0], t[part])
    sense = -1.0 if "alpha" not in reversed_columns(recording.signs, "iso") else 1.0
    rolls = np.abs(speed) > LOWEST_SPEED
    phit = np.where(rolls, sense * rate / np.where(rolls, np.abs(speed), 1.0), 0.0)
    return replace(recording, table=table.assign(phit=phit))
