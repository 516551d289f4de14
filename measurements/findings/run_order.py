"""Effects of the order of a run: warm-up, and inputs whose levels were run one after another."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from shlex import quote

import numpy as np
from scipy.ndimage import median_filter

from ..channels import CHANNELS
from ..operating_conditions.held_levels import held_levels
from ..operating_conditions.time_series import sample_interval
from ..recording import Recording
from ..thresholds import COOL_TREAD, LATER_TEMPERATURE_QUANTILE, LONGEST_WARM_UP, TEMPERATURE_WINDOW
from .finding import Finding

#: Inputs that act on the tire in a similar way as wear and temperature, and the unit of a message.
SLOW_INPUTS = {"p": (1e-3, "kPa"), "V": (1.0, "m/s")}
#: Running medians are computed at this many points.
MOST_POINTS = 2000


def warm_up(recording: Recording, *, alone: bool = True) -> Iterator[Finding]:
    """Yield a finding if the tread warms during the first part of a recording.

    The running median over sweeps is compared with the later temperatures. `exclude_rows` excludes a warm-up only if
    it starts from a much colder tread.

    Parameters
    ----------
    recording : Recording
    alone : bool
        Whether it is the only recording; otherwise the suggested selection applies to its file only.

    Yields
    ------
    Finding
    """
    if "T" not in recording.table or len(recording) < 2:
        return
    step = max(1, len(recording) // MOST_POINTS)
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
    yield Finding(
        "warm-up",
        f"{recording.source}: warm-up: the tread is at {smooth[0]:.0f} deg C at the start, within {COOL_TREAD:g} K of "
        f"the later {later:.0f} deg C only after {end} of {len(recording)} rows",
        command=f"--where {quote(crop if alone else text)}",
    )


def confounded_with_order(recording: Recording) -> Iterator[Finding]:
    """Yield a finding for pressure and speed if each level was run once, one after another.

    Parameters
    ----------
    recording : Recording

    Yields
    ------
    Finding

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"p": np.repeat([83e3, 70e3], 200), "Fz": np.tile([500.0, 900.0], 200), "Fy": 1.0})
    >>> print(*confounded_with_order(Recording(rows, "iso", "a.csv")))  # doctest: +ELLIPSIS
    a.csv: the levels of p were run one after another (83, 70 kPa): its effect is confounded with wear, ...
    """
    for name, (scale, unit) in SLOW_INPUTS.items():
        if name not in recording.table:
            continue
        found = np.array(held_levels(recording.table[name]))
        if len(found) < 2:
            continue
        values = recording.table[name].to_numpy(dtype=np.float64)
        spacing = np.diff(found).min()
        distance = np.abs(values[:, None] - found)
        near = distance.min(axis=1) < 0.25 * spacing  # without the rows of a transition
        order = [int(level) for level, _ in groupby(distance.argmin(axis=1)[near])]
        if len(order) == len(found):
            texts = ", ".join(f"{found[level] * scale:.3g}" for level in order)
            yield Finding(
                "run order",
                f"{recording.source}: the levels of {name} were run one after another ({texts} {unit}): its "
                f"effect is confounded with wear, temperature and drift of the run",
                command=f"measure the first {CHANNELS[name].meaning.split(',')[0]} again at the end of the run",
            )
