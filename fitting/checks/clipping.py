"""Measured channels that are cut off at the end of a sensor's range."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan

import numpy as np

from .residuals import Residuals

#: Fewest rows, and their least share, that are equal to the largest or smallest value of a channel with noise. A noisy
#: channel reaches its extreme value once; a tire that slides at one load has equal forces only without noise.
MIN_ROWS, MIN_SHARE = 10, 0.005
#: Width within which values are equal, and the least median step from row to row of a noisy channel, as shares of the
#: channel's range.
EQUAL, NOISY = 1e-6, 1e-5


@dataclass(frozen=True)
class Clipped:
    """A channel of a recording that is cut off.

    - `lower`, `upper`: the values at which it is cut off; NaN on a side where it is not.
    - `share`: share of the rows.
    """

    recording: str
    channel: str
    unit: str
    lower: float
    upper: float
    share: float


def clipped_channels(residuals: Residuals) -> tuple[Clipped, ...]:
    """Return the fitted channels of each recording in which many rows have the same extreme value."""
    clipped = []
    for number, source in enumerate(residuals.sources):
        for channel in residuals.channels:
            values = residuals.table[channel].to_numpy(dtype=float)[residuals.recording == number]
            values = residuals.sign(channel) * values[np.isfinite(values)]
            extent = float(np.ptp(values)) if len(values) else 0.0
            if extent == 0.0 or float(np.median(np.abs(np.diff(values)))) < NOISY * extent:
                continue
            ends = float(values.min()), float(values.max())
            shares = [float(np.mean(np.abs(values - end) <= EQUAL * extent)) for end in ends]
            enough = max(MIN_SHARE, MIN_ROWS / len(values))
            if max(shares) >= enough:
                low, high = (end if share >= enough else nan for end, share in zip(ends, shares, strict=True))
                clipped.append(Clipped(source, channel, residuals.units[channel], low, high, sum(shares)))
    return tuple(clipped)
