"""Whether rows of a recording are a time series, and their sample interval."""

from __future__ import annotations

import numpy as np

from ..channels import CONTROLLED_INPUTS
from ..recording import Recording
from ..thresholds import (
    DEFAULT_SAMPLE_INTERVAL,
    FEWEST_SERIES_ROWS,
    JUMP_TOLERANCES,
    LONGEST_SAMPLE_INTERVAL,
    MOST_JUMPS,
)
from .levels import level_tolerance


def is_time_series(recording: Recording, segment: slice) -> bool:
    """Return whether the rows of a segment are a time series rather than separate steady points.

    Parameters
    ----------
    recording : Recording
    segment : slice

    Returns
    -------
    bool

    Examples
    --------
    >>> import pandas as pd
    >>> steps = Recording(pd.DataFrame({"kappa": np.tile([0.0, 0.2, -0.2], 20)}), "iso", "points.csv")
    >>> is_time_series(steps, slice(0, 60))
    False
    """
    if segment.stop - segment.start < FEWEST_SERIES_ROWS:
        return False
    if sample_interval(recording, segment) > LONGEST_SAMPLE_INTERVAL:
        return False
    for name in CONTROLLED_INPUTS:
        if name in recording.table:
            values = recording.table[name].to_numpy(dtype=np.float64)
            jumps = np.abs(np.diff(values[segment])) > JUMP_TOLERANCES * level_tolerance(values, name)
            if jumps.mean() > MOST_JUMPS:
                return False
    return True


def sample_interval(recording: Recording, segment: slice) -> float:
    """Return the median step of the clock in a segment.

    Parameters
    ----------
    recording : Recording
    segment : slice

    Returns
    -------
    float, s
        0.01 s (100 Hz) if no clock was recorded.
    """
    if "t" not in recording.table or segment.stop - segment.start < 2:
        return DEFAULT_SAMPLE_INTERVAL
    steps = np.diff(recording.table["t"].to_numpy(dtype=np.float64)[segment])
    forward = steps[steps > 0.0]
    return float(np.median(forward)) if len(forward) else DEFAULT_SAMPLE_INTERVAL
