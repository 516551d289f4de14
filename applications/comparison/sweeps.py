"""Sweeps of one slip of the upright tire in recordings: at which inputs the compared curves are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from ...measurements import CHANNELS, Recording, exclude_rows, group_by_condition, level_tolerance
from ...tires import Tire
from ...tires.definition import default_loads
from ...tires.drawing.tire_figures import WIDEST

#: Curves of a figure; of more sweeps, those with the most rows.
MAX_SWEEPS = 6
#: Sweeps with fewer rows are not drawn.
MIN_ROWS = 10
#: Inputs in addition to load and camber that a program may set to several levels: one of each is drawn.
FURTHER = ("p", "V")


@dataclass(frozen=True)
class Sweep:
    """A sweep of a slip with all other inputs constant.

    - `held`: the other inputs, SI units, in the signs of the figure.
    - `low`, `high`: range of the slip.
    - `rows`: measured rows; empty without a recording.
    """

    slip: str
    held: dict[str, float]
    low: float
    high: float
    rows: pd.DataFrame

    @property
    def load(self) -> float:
        """The load, N."""
        return self.held["Fz"]


def sweeps(tires: Sequence[Tire], slip: str, recordings: Sequence[Recording]) -> list[Sweep]:
    """Return the measured sweeps of a slip at zero of the other slip and of camber, by load.

    They are at the pressure and the speed with the most rows. Sweeps at one load are one.

    `tires`: determine loads and range, those that all of them have, if no recording has such a sweep. `slip`: "kappa"
    or "alpha". `recordings`: all in the same convention.
    """
    all_sweeps = [sweep for recording in recordings for sweep in _measured(recording, slip)]
    for name in FURTHER:
        all_sweeps = _at_main_level(all_sweeps, name)
    most = sorted(_merged(all_sweeps), key=lambda sweep: -len(sweep.rows))[:MAX_SWEEPS]
    if most:
        return sorted(most, key=lambda sweep: abs(sweep.load))
    low, high = _common(tires, slip)
    low, high = max(low, WIDEST[slip][0]), min(high, WIDEST[slip][1])
    lightest, heaviest = _common(tires, "Fz")
    suited = [loads for loads in map(default_loads, tires) if lightest <= loads[0] <= loads[-1] <= heaviest]
    loads = suited[-1] if suited else tuple(np.linspace(max(lightest, 0.25 * heaviest), heaviest, 3).tolist())
    return [Sweep(slip, {"Fz": load}, low, high, pd.DataFrame()) for load in loads]


def _common(tires: Sequence[Tire], name: str) -> tuple[float, float]:
    """Return the range of an input that all tires have; that of the last one if they have none in common."""
    last = WIDEST.get(name) or (0.0, 2.0 * tires[-1].values["FNOMIN"])
    ranges = [tire.ranges[name] for tire in tires if name in tire.ranges] or [last]
    low, high = max(low for low, _ in ranges), min(high for _, high in ranges)
    return (low, high) if low < high else ranges[-1]


def _at_main_level(candidates: list[Sweep], name: str) -> list[Sweep]:
    """Return the sweeps at the level of an input with the most rows; all if it is held in none."""
    levels = [sweep.held[name] for sweep in candidates if name in sweep.held]
    if not levels:
        return candidates
    tolerance = level_tolerance(levels, name)

    def near(level: float) -> list[Sweep]:
        return [sweep for sweep in candidates if name in sweep.held and abs(sweep.held[name] - level) <= tolerance]

    return near(max(levels, key=lambda level: sum(len(sweep.rows) for sweep in near(level))))


def _merged(measured: Sequence[Sweep]) -> list[Sweep]:
    """Return one sweep for each load, with the rows of all sweeps there, held as the longest of them."""
    tolerance = level_tolerance([sweep.load for sweep in measured], "Fz")
    merged: list[Sweep] = []
    for sweep in sorted(measured, key=lambda sweep: -len(sweep.rows)):
        same = next((i for i, other in enumerate(merged) if abs(other.load - sweep.load) <= tolerance), None)
        if same is None:
            merged.append(sweep)
            continue
        before = merged[same]
        low, high = min(before.low, sweep.low), max(before.high, sweep.high)
        merged[same] = Sweep(
            before.slip, before.held, low, high, pd.concat([before.rows, sweep.rows], ignore_index=True)
        )
    return merged


def _measured(recording: Recording, slip: str) -> list[Sweep]:
    included = exclude_rows(recording).included
    grouping = group_by_condition(recording)
    measured = []
    for label, (held, moving) in enumerate(zip(grouping.conditions, grouping.moving, strict=True)):
        levels = dict(held)
        rows = recording.table[included & (grouping.labels == label)]
        upright = all(
            abs(level) <= (CHANNELS[name].tolerance or np.inf)
            for name, level in levels.items()
            if name in ("kappa", "alpha", "gamma", "phit")
        )
        if moving == (slip,) and upright and "Fz" in levels and len(rows) >= MIN_ROWS:
            measured.append(Sweep(slip, levels, float(rows[slip].min()), float(rows[slip].max()), rows))
    return measured
