"""Maneuvers: one input that goes from point to point while the others are held, and the library of a bench."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pandas as pd

from ...tires import Tire
from .bench_file import INPUTS, SWEPT, Bench, Limits

#: Shapes of a slip: name, points as shares of its range, share of its largest rate, seconds at each inner point.
Shape = tuple[str, tuple[float, ...], float, float]
SWEEP: Shape = ("sweep", (0.0, 1.0, -1.0, 0.0), 1.0, 0.0)
SWEEPS: tuple[Shape, ...] = tuple(
    ("sweep", (0.0, share, -share, 0.0), rate, 0.0) for share in (1.0, 0.4, 0.15) for rate in (1.0, 0.5, 0.25)
)
#: Shapes that separate effects with memory: both starting sides, two rates, steps and long holds.
MEMORY: tuple[Shape, ...] = (
    SWEEP, ("sweep", (0.0, -1.0, 1.0, 0.0), 1.0, 0.0), ("sweep", SWEEP[1], 0.25, 0.0),
    *(("step", (0.0, share, 0.0), 1.0, seconds) for share in (-0.25, 0.25, 0.7) for seconds in (3.0, 12.0)),
)  # fmt: skip
#: A load that swings, and the slips at which it does, as shares.
SWING: Shape = ("swing", (0.0, 1.0, 0.0), 1.0, 0.0)
SWING_SLIPS = (0.0, 0.3)
#: Held slips of combined sweeps, as shares.
HELD_SLIPS = (-0.5, -0.2, 0.2, 0.5, 1.0)
#: Shortest half of a sweep, s: what is faster has too few rows on a slow bench.
SHORTEST = 1.0


@dataclass(frozen=True)
class Maneuver:
    """A part of a program during which rows are recorded.

    - `kind`: "sweep", "step" or "swing".
    - `swept`: the input that changes.
    - `times`, `values`: s, and values of the swept input, between which it is linear.
    - `held`: the levels of all other inputs.

    >>> Maneuver("sweep", "alpha", (0.0, 2.0, 6.0, 8.0), (0.0, 0.2, -0.2, 0.0), ()).turned.values
    (0.0, -0.2, 0.2, 0.0)
    """

    kind: str
    swept: str
    times: tuple[float, ...]
    values: tuple[float, ...]
    held: tuple[tuple[str, float], ...]

    @property
    def start(self) -> dict[str, float]:
        """The inputs at its start."""
        return {**dict(self.held), self.swept: self.values[0]}

    @property
    def duration(self) -> float:
        """Seconds from its first to its last row."""
        return self.times[-1]

    @property
    def rate(self) -> float:
        """The largest rate, per second."""
        return float(np.abs(np.diff(self.values) / np.diff(self.times)).max())

    @property
    def turned(self) -> Maneuver:
        """The maneuver from its end to its start: the other side first."""
        times = tuple(self.duration - t for t in reversed(self.times))
        return replace(self, times=times, values=tuple(reversed(self.values)))

    def table(self, sample_rate: float) -> pd.DataFrame:
        """Return ``t`` from 0 and the inputs of its rows.

        >>> Maneuver("step", "alpha", (0.0, 2.0, 4.0), (0.0, 0.2, 0.2), ()).table(1.0)["alpha"].tolist()
        [0.0, 0.1, 0.2, 0.2, 0.2]
        """
        t = np.arange(int(np.floor(round(self.duration * sample_rate, 6))) + 1) / sample_rate
        columns = {**dict(self.held), self.swept: np.interp(t, self.times, self.values)}
        return pd.DataFrame({"t": t, **{name: columns[name] for name in INPUTS if name in columns}})


def held_levels(bench: Bench, tire: Tire) -> dict[str, float]:
    """Return the levels of inputs that a program holds unless it varies them: the nominal ones, or the nearest."""
    levels = {"kappa": 0.0, "alpha": 0.0}
    for name in INPUTS[2:]:
        nominal, limits = tire.nominal(name) if name in tire.inputs else None, bench.limits.get(name)
        if limits is not None:
            middle = 0.5 * (limits.low + limits.high) if nominal is None else nominal
            levels[name] = min(max(middle, limits.low), limits.high)
        elif nominal is not None:
            levels[name] = nominal
    return levels


def library(bench: Bench, tire: Tire, *, memory: bool = False) -> list[Maneuver]:
    """Return the maneuvers of a bench at all levels of the load and one other input.

    `memory`: maneuvers that separate effects, also those with memory, at three levels at most; otherwise sweeps that
    determine the tire without memory.
    """
    levels_of = {name: limits.level_values(3 if memory else limits.levels) for name, limits in bench.limits.items()}
    slips = [name for name in SWEPT if name in bench.limits and name in tire.inputs]
    varied = [name for name in ("gamma", "p", "V") if name in bench.limits and name in tire.inputs]
    nominal, maneuvers = held_levels(bench, tire), list[Maneuver]()
    changes: list[dict[str, float]] = [{}]
    changes += [{name: level} for name in varied for level in levels_of[name]]
    for load, change in product(levels_of.get("Fz", [nominal["Fz"]]), changes):
        levels, pure = {**nominal, "Fz": load, **change}, {**nominal, **change} == nominal
        for swept in (name for name in slips if bench.limits[name].sweeps):
            shapes = (MEMORY if pure else (SWEEP,)) if memory else SWEEPS
            maneuvers += [_maneuver(bench, shape, swept, levels) for shape in shapes]
            for other, share in product(slips, HELD_SLIPS if pure or not memory else ()):
                if other != swept:
                    held = {**levels, other: _value(bench.limits[other], share)}
                    maneuvers.append(_maneuver(bench, SWEEP, swept, held))
    if memory and "Fz" in bench.limits:
        for slip, share in product(slips, SWING_SLIPS):
            held = {**nominal, slip: _value(bench.limits[slip], share)}
            maneuvers.append(_maneuver(bench, SWING, "Fz", held))
    return [maneuver for maneuver in dict.fromkeys(maneuvers) if np.ptp(maneuver.values)]


def _maneuver(bench: Bench, shape: Shape, swept: str, levels: dict[str, float]) -> Maneuver:
    """Return a shape in the units of the bench; no half of a sweep is too short."""
    kind, shares, rate_share, hold = shape
    limits = bench.limits[swept]
    values = [_value(limits, share) for share in shares]
    largest = limits.rate or (limits.high - limits.low) / max(limits.change, 0.5)
    rate = min(rate_share * largest, float(np.ptp(values)) / SHORTEST)
    times, points = [0.0], [values[0]]
    for value in values[1:]:
        if value != points[-1]:
            times.append(times[-1] + abs(value - points[-1]) / rate)
            points.append(value)
        if hold and value != values[-1]:
            times.append(times[-1] + hold)
            points.append(value)
    held = tuple((name, level) for name, level in levels.items() if name != swept)
    return Maneuver(kind, swept, tuple(np.round(times, 9).tolist()), tuple(points), held)


def _value(limits: Limits, share: float) -> float:
    """Return a share of a range that contains 0; of another one, from its low end to its high end."""
    if limits.low > 0.0:
        return limits.low + share * (limits.high - limits.low)
    return share * (limits.high if share > 0.0 else -limits.low)
