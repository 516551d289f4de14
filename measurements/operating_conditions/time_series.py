"""Whether rows of a recording are a time series, and their sample interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...numerics.arrays import FloatArray
from ...symbolic.channels import CONTROLLED_INPUTS
from ..recording import Recording
from ..thresholds import DEFAULT_SAMPLE_INTERVAL, JUMP_TOLERANCES, LONGEST_SAMPLE_INTERVAL, MAX_JUMPS, MIN_SERIES_ROWS
from .levels import level_tolerance


@dataclass(frozen=True)
class Segment:
    """Consecutive rows that were logged without interruption.

    `is_series`: whether the rows are a time series rather than separate steady points. `interval`: sample interval, s.
    """

    rows: slice
    is_series: bool
    interval: float


def segments_of(recording: Recording) -> list[Segment]:
    """Return the segments of a recording with their kind and sample interval.

    They are in the order of the rows and contain every row once. A recording has hundreds of segments: each channel is
    compared with its tolerance once, for all of them.
    """
    pieces = recording.segments()
    clock = _clock(recording)
    intervals = [_interval(clock, piece) for piece in pieces]
    jumping = _jumping(recording, pieces)
    return [
        Segment(
            piece,
            piece.stop - piece.start >= MIN_SERIES_ROWS and interval <= LONGEST_SAMPLE_INTERVAL and not jumps,
            interval,
        )
        for piece, interval, jumps in zip(pieces, intervals, jumping, strict=True)
    ]


def sample_interval(recording: Recording, rows: slice) -> float:
    """Return the median step of the clock in consecutive rows, s; 0.01 s (100 Hz) if no clock was recorded."""
    return _interval(_clock(recording), rows)


def _clock(recording: Recording) -> FloatArray | None:
    return recording.table["t"].to_numpy(dtype=np.float64) if "t" in recording.table else None


def _interval(clock: FloatArray | None, rows: slice) -> float:
    if clock is None or rows.stop - rows.start < 2:
        return DEFAULT_SAMPLE_INTERVAL
    steps = np.diff(clock[rows])
    forward = steps[steps > 0.0]
    return float(np.median(forward)) if len(forward) else DEFAULT_SAMPLE_INTERVAL


def _jumping(recording: Recording, pieces: Sequence[slice]) -> list[bool]:
    """Return for each segment whether an input jumps too often from one row to the next for a time series."""
    first = np.array([piece.start for piece in pieces], dtype=np.intp)
    last = np.array([piece.stop for piece in pieces], dtype=np.intp) - 1
    jumping = np.zeros(len(pieces), dtype=np.bool_)
    for name in CONTROLLED_INPUTS:
        if name in recording.table and len(pieces):
            values = recording.table[name].to_numpy(dtype=np.float64)
            jumps = np.abs(np.diff(values)) > JUMP_TOLERANCES * level_tolerance(values, name)
            counted = np.concatenate([[0], np.cumsum(jumps)])  # jumps before each row
            jumping |= (counted[last] - counted[first]) / np.maximum(last - first, 1) > MAX_JUMPS
    return jumping.tolist()
