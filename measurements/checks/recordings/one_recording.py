"""What one recording lacks or contradicts in its columns, its rows and the order of its run."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from shlex import quote

import numpy as np
import pandas as pd
from scipy.ndimage import median_filter

from ....symbolic.channels import CHANNELS, OUTPUTS
from ...operating_conditions.levels import held_levels
from ...operating_conditions.time_series import sample_interval
from ...recording import Recording, once
from ...thresholds import (
    COOL_TREAD,
    LATER_TEMPERATURE_QUANTILE,
    LONGEST_WARM_UP,
    MAX_REPEATED_ROWS,
    SERIOUS_REPEATED_ROWS,
    SHORTEST_REPETITION,
    TEMPERATURE_WINDOW,
)
from .finding import DataFinding

#: The outputs that a slip causes.
_CAUSED = {"alpha": ("Fy", "Mz"), "kappa": ("Fx",)}
#: Names of columns in one line; more are counted.
MAX_NAMES = 8
#: Inputs that act on the tire in a similar way as wear and temperature, and the unit of a message.
SLOW_INPUTS = {"p": (1e-3, "kPa"), "V": (1.0, "m/s")}
#: Running medians are computed at this many points.
MAX_POINTS = 2000


def findings_of(recording: Recording, *, alone: bool) -> Iterator[DataFinding]:
    """Yield what a recording lacks or contradicts in its columns, rows and order.

    `alone`: whether it is the only recording; otherwise a suggested selection applies to its file only.
    """
    yield from _missing_slips(recording)
    yield from _missing_load(recording)
    yield from _assumed_camber(recording)
    yield from _unread_channels(recording)
    yield from incomplete_rows(recording)
    yield from _repeated_rows(recording)
    yield from _warm_up(recording, alone=alone)
    yield from _confounded_with_order(recording)


def _missing_slips(recording: Recording) -> Iterator[DataFinding]:
    """Yield a finding for each slip without a column, if an output was measured that it causes."""
    table = recording.table
    for slip, outputs in _CAUSED.items():
        measured = [name for name in outputs if name in table and table[name].notna().any()]
        if slip not in table and measured:
            meaning = "slip angle" if slip == "alpha" else "longitudinal slip"
            yield DataFinding(
                "missing slip",
                f"{recording.source}: NO COLUMN {slip} ({meaning}): {' and '.join(measured)} cannot be fitted, "
                f"and every row counts as {slip} = 0",
                serious=True,
            )


def _missing_load(recording: Recording) -> Iterator[DataFinding]:
    """Yield a finding without a column of the load."""
    if "Fz" not in recording.table:
        yield DataFinding("missing load", f"{recording.source}: NO COLUMN Fz (load): a fit requires it", serious=True)


def _assumed_camber(recording: Recording) -> Iterator[DataFinding]:
    """Yield a finding if an output that camber changes was measured, but no camber; no sensor records exactly 0."""
    table = recording.table
    measured = [name for name in _CAUSED["alpha"] if name in table and table[name].notna().any()]
    if measured and ("gamma" not in table or not table["gamma"].any()):
        state = "gamma is exactly 0 in every row" if "gamma" in table else "no column gamma: 0 deg assumed"
        yield DataFinding(
            "assumed camber",
            f"{recording.source}: {state}; if the tire was cambered, "
            f"{' and '.join(measured)} would be wrong by the effect of camber",
        )


def _unread_channels(recording: Recording) -> Iterator[DataFinding]:
    """Yield a finding if a table has columns that are not channels."""
    names = [name for name in map(str, recording.table) if name not in CHANNELS]
    if names:
        more = f" and {len(names) - MAX_NAMES} more" if len(names) > MAX_NAMES else ""
        yield DataFinding(
            "unread columns",
            f"{recording.source}: columns that are no channels are not fitted: {', '.join(names[:MAX_NAMES])}{more}",
        )


def incomplete_rows(recording: Recording) -> Iterator[DataFinding]:
    """Yield a finding if rows were excluded because an input is NaN.

    Parameters
    ----------
    recording : Recording
        As read.

    Yields
    ------
    DataFinding
    """
    if text := recording.about.get("incomplete"):
        yield DataFinding(
            "incomplete rows", f"{recording.source}: {text}: excluded, and rows are numbered without them"
        )


def _repeated_rows(recording: Recording) -> Iterator[DataFinding]:
    """Yield a finding if a stretch of rows repeats an earlier one in every channel but time.

    Without noise, single rows may be equal, and a return sweep may repeat the first one.
    """
    earlier, _ = pd.factorize(row_keys(recording))  # the first row with the same numbers, as a count of different rows
    repeated = row_keys(recording).duplicated().to_numpy()
    follows = np.diff(earlier, prepend=-1) == 1
    edges = np.flatnonzero(np.diff(np.concatenate([[False], repeated & follows, [False]])))
    stretches = [(start, stop) for start, stop in edges.reshape(-1, 2) if stop - start >= SHORTEST_REPETITION - 1]
    # The first row of a stretch does not continue an earlier row.
    stretches = [(start - (start > 0 and repeated[start - 1]), stop) for start, stop in stretches]
    rows = sum(stop - start for start, stop in stretches)
    if rows > MAX_REPEATED_ROWS * len(recording):
        yield DataFinding(
            "repeated rows",
            f"{recording.source}: {rows} of {len(recording)} rows repeat earlier rows in every channel but t, the "
            f"first at row {stretches[0][0] + 1}",
            serious=rows > SERIOUS_REPEATED_ROWS * len(recording),
        )


@once
def row_keys(recording: Recording) -> pd.Series:
    """Return a hash of each row over all channels but the clock, shape (n,); empty without a measured output.

    Signs are converted, so that a file in two conventions is recognized.
    """
    table = recording.with_signs("iso").table
    names = [name for name in CHANNELS if name in table and name != "t"]
    if not any(name in OUTPUTS and table[name].notna().any() for name in names):
        return pd.Series([], dtype=np.uint64)
    return pd.util.hash_pandas_object(table[names] + 0.0, index=False)  # + 0.0: no -0


def _warm_up(recording: Recording, *, alone: bool) -> Iterator[DataFinding]:
    """Yield a finding if the tread warms during the first part of a recording.

    The running median over sweeps is compared with the later temperatures. `exclude_rows` excludes a warm-up only if
    it starts from a much colder tread.
    """
    if "T" not in recording.table or len(recording) < 2:
        return
    step = max(1, len(recording) // MAX_POINTS)
    temperature = recording.table["T"].to_numpy(dtype=np.float64)[::step]
    window = round(TEMPERATURE_WINDOW / (step * sample_interval(recording, recording.segments()[0])))
    if not 3 <= window < len(temperature) // 2:
        return
    smooth = median_filter(temperature, size=window, mode="nearest")
    later = float(np.quantile(smooth[len(smooth) // 2 :], LATER_TEMPERATURE_QUANTILE))
    end = step * int(np.argmax(smooth >= later - COOL_TREAD))
    if not 0 < end <= LONGEST_WARM_UP * len(recording):
        return
    clock = recording.table["t"].to_numpy(dtype=np.float64) if "t" in recording.table else None
    crop = f"sample > {end}" if clock is None else f"t >= {clock[end]:.6g} s"
    text = f'file != "{recording.source}" or {crop}'
    yield DataFinding(
        "warm-up",
        f"{recording.source}: warm-up: the tread is at {smooth[0]:.0f} deg C at the start, within {COOL_TREAD:g} K of "
        f"the later {later:.0f} deg C only after {end} of {len(recording)} rows",
        command=f"--where {quote(crop if alone else text)}",
    )


def _confounded_with_order(recording: Recording) -> Iterator[DataFinding]:
    """Yield a finding for pressure and speed if each level was run once, one after another."""
    for name, (scale, unit) in SLOW_INPUTS.items():
        if name not in recording.table:
            continue
        levels = np.array(held_levels(recording.table[name]))
        if len(levels) < 2:
            continue
        values = recording.table[name].to_numpy(dtype=np.float64)
        spacing = np.diff(levels).min()
        distance = np.abs(values[:, None] - levels)
        near = distance.min(axis=1) < 0.25 * spacing  # without the rows of a transition
        order = [int(level) for level, _ in groupby(distance.argmin(axis=1)[near])]
        if len(order) == len(levels):
            texts = ", ".join(f"{levels[level] * scale:.3g}" for level in order)
            yield DataFinding(
                "run order",
                f"{recording.source}: the levels of {name} were run one after another ({texts} {unit}): its "
                f"effect is confounded with wear, temperature and drift of the run",
                command=f"measure the first {CHANNELS[name].meaning.split(',')[0]} again at the end of the run",
            )
