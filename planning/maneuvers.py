"""The library of maneuvers of a bench: sweeps, steps and holds at levels of the other inputs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pandas as pd

from tirefmu.tires import Tire

from .bench_file import INPUTS, SWEPT, Bench, Limits

#: Shares of the range of a slip that are swept, and of its largest rate. Held slips of combined sweeps, as shares.
AMPLITUDES, RATES, HELD_SLIPS = (1.0, 0.4), (1.0, 0.5, 0.25), (-0.5, -0.2, 0.2, 0.5, 1.0)
#: Shortest half of a sweep, s: what is faster has too few rows on a slow bench.
SHORTEST = 1.0
#: Seconds of a step and of a hold, and the shares of the range to which they go.
HELD_FOR, STEPS = (3.0, 12.0), (-0.25, 0.25, 0.7)


@dataclass(frozen=True)
class Maneuver:
    """A part of a program during which rows are recorded.

    - `kind`: "sweep" (0, first side, other side, 0), "step" (0, then a constant value, then 0) or "swing" (first side,
      other side, first side, as a load that varies at a constant slip).
    - `swept`: the input that changes.
    - `first`, `second`: the two turning points, the first side first; equal for a step.
    - `rate`: of a sweep, per second; for a step the seconds at the value.
    - `held`: the levels of all other inputs.
    """

    kind: str
    swept: str
    first: float
    second: float
    rate: float
    held: tuple[tuple[str, float], ...]

    @property
    def start(self) -> dict[str, float]:
        """The inputs at its start."""
        return {**dict(self.held), self.swept: self.first if self.kind == "swing" else 0.0}

    @property
    def corners(self) -> tuple[list[float], list[float]]:
        """Times, s, and values of the swept input, between which it is linear.

        >>> Maneuver("sweep", "alpha", 0.2, -0.2, 0.1, ()).corners
        ([0.0, 2.0, 6.0, 8.0], [0.0, 0.2, -0.2, 0.0])
        """
        if self.kind == "step":
            return [0.0, 0.5, 0.6, 0.6 + self.rate, 0.7 + self.rate, 1.2 + self.rate], [
                0.0, 0.0, self.first, self.first, 0.0, 0.0,
            ]  # fmt: skip
        middle = [self.first, self.second]
        values = [*middle, self.first] if self.kind == "swing" else [0.0, *middle, 0.0]
        times = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(values)))]) / self.rate
        return np.round(times, 9).tolist(), values

    @property
    def duration(self) -> float:
        """Seconds from its first to its last row."""
        return self.corners[0][-1]

    def table(self, sample_rate: float) -> pd.DataFrame:
        """Return ``t`` from 0 and the inputs of its rows.

        >>> Maneuver("sweep", "alpha", 0.2, -0.2, 0.1, (("Fz", 700.0),)).table(0.5)["alpha"].tolist()
        [0.0, 0.2, 0.0, -0.2, 0.0]
        """
        t = np.arange(int(np.floor(round(self.duration * sample_rate, 6))) + 1) / sample_rate
        columns = {**dict(self.held), self.swept: np.interp(t, *self.corners)}
        return pd.DataFrame({"t": t, **{name: columns[name] for name in INPUTS if name in columns}})


def held_levels(bench: Bench, tire: Tire) -> dict[str, float]:
    """Return the levels of inputs that a program holds unless it varies them: the nominal ones, or the nearest.

    Raises `PlanError` if the tire has no nominal value of an input that the bench does not have.
    """
    levels = {"kappa": 0.0, "alpha": 0.0}
    for name in INPUTS[2:]:
        nominal = tire.nominal(name) if name in tire.inputs else None
        if name in bench.limits:
            limits = bench.limits[name]
            middle = 0.5 * (limits.low + limits.high) if nominal is None else nominal
            levels[name] = min(max(middle, limits.low), limits.high)
        elif nominal is not None:
            levels[name] = nominal
    return levels


def library(bench: Bench, tire: Tire) -> list[Maneuver]:
    """Return the sweeps of a bench that determine a tire without memory.

    Pure and combined sweeps at all levels of the load and either all levels of the inclination or all levels of the
    pressure and the speed, with two amplitudes and two rates.
    """
    return list(dict.fromkeys(
        maneuver
        for levels in _levels(bench, tire)
        for swept in SWEPT
        if swept in bench.limits and bench.limits[swept].rate > 0.0 and swept in tire.inputs
        for maneuver in _sweeps(bench, swept, levels)
    ))  # fmt: skip


def library_with_memory(bench: Bench, tire: Tire) -> list[Maneuver]:
    """Return maneuvers that separate effects, also those with memory.

    At the lowest, the middle and the highest load: sweeps with both starting sides and two rates, pure and at another
    inclination, pressure or slip; steps, long holds, and a load that swings at a constant slip.
    """
    nominal = held_levels(bench, tire)
    few = replace(bench, limits={name: replace(one, levels=3) for name, one in bench.limits.items()})
    maneuvers: list[Maneuver] = []
    for levels in _levels(few, tire):
        other = [name for name in ("gamma", "p", "V") if levels.get(name) != nominal.get(name)]
        for swept in SWEPT:
            if swept in bench.limits and bench.limits[swept].rate > 0.0 and swept in tire.inputs:
                maneuvers += _separating(bench.limits[swept], swept, levels, pure=not other)
                if not other and (crossing := _crossing(bench, swept, levels)):
                    maneuvers.append(crossing)
    load = bench.limits.get("Fz")
    if load is not None and load.high > load.low:
        rate = (load.high - load.low) / max(load.change, 0.5)
        for swept, share in product([name for name in SWEPT if name in bench.limits], (0.0, 0.3)):
            held = _others({**nominal, swept: share * bench.limits[swept].high}, "Fz")
            maneuvers.append(Maneuver("swing", "Fz", load.low, load.high, rate, held))
    return list(dict.fromkeys(maneuvers))


def _separating(limits: Limits, swept: str, levels: Mapping[str, float], *, pure: bool) -> list[Maneuver]:
    """Return maneuvers of a slip at levels; steps and slow sweeps in pure slip at nominal levels only."""
    held, width = _others(levels, swept), limits.high - limits.low
    fast, slow = (_possible_rate(share * limits.rate, limits, width) for share in (1.0, 0.25))
    sweep = Maneuver("sweep", swept, limits.high, limits.low, fast, held)
    if not pure:
        return [sweep]
    turned = replace(sweep, first=sweep.second, second=sweep.first)
    values = [share * (limits.high if share > 0.0 else -limits.low) for share in STEPS]
    steps = [Maneuver("step", swept, value, value, seconds, held) for value in values if value for seconds in HELD_FOR]
    return [sweep, turned, replace(sweep, rate=slow), *steps]


def _crossing(bench: Bench, swept: str, levels: Mapping[str, float]) -> Maneuver | None:
    """Return the sweep of a slip at half of the other slip."""
    limits = bench.limits[swept]
    (other,) = (name for name in SWEPT if name != swept)
    if other not in bench.limits or not bench.limits[other].high:
        return None
    held = _others({**levels, other: 0.5 * bench.limits[other].high}, swept)
    return Maneuver("sweep", swept, limits.high, limits.low, limits.rate, held)


def neighbors(maneuver: Maneuver, bench: Bench, tire: Tire) -> Iterator[Maneuver]:
    """Yield variants of a sweep: other amplitudes and rates, and levels between those of the library."""
    limits = bench.limits[maneuver.swept]
    for share in (0.8, 1.25):
        first, second = (min(max(share * end, limits.low), limits.high) for end in (maneuver.first, maneuver.second))
        yield replace(maneuver, first=first, second=second)
        yield replace(maneuver, rate=_possible_rate(share * maneuver.rate, limits, maneuver.second - maneuver.first))
    for name, value in maneuver.held:
        other = bench.limits.get(name)
        if other is None or other.low == other.high or name not in tire.inputs:
            continue
        step = 0.4 * (other.high - other.low) / (other.levels - 1)
        for level in (value - step, value + step):
            if other.low <= level <= other.high:
                held = tuple((key, level if key == name else old) for key, old in maneuver.held)
                yield replace(maneuver, held=held)


def _levels(bench: Bench, tire: Tire) -> Iterator[dict[str, float]]:
    """Yield the levels of the held inputs."""
    nominal = held_levels(bench, tire)
    varied = [name for name in ("gamma", "p", "V") if name in bench.limits and name in tire.inputs]
    loads = bench.limits["Fz"].level_values() if "Fz" in bench.limits else [nominal["Fz"]]
    for load in loads:
        yield {**nominal, "Fz": load}
        for name in varied:
            for level in bench.limits[name].level_values():
                yield {**nominal, "Fz": load, name: level}


def _sweeps(bench: Bench, swept: str, levels: Mapping[str, float]) -> Iterator[Maneuver]:
    """Yield the pure sweeps of a slip at levels, and those at a constant other slip."""
    limits = bench.limits[swept]
    (other,) = (name for name in SWEPT if name != swept)
    for share, rate_share in product(AMPLITUDES, RATES):
        low, high = share * limits.low, share * limits.high
        rate = _possible_rate(rate_share * limits.rate, limits, high - low)
        yield Maneuver("sweep", swept, high, low, rate, _others(levels, swept))
    if other in bench.limits:
        width = bench.limits[other]
        for share in HELD_SLIPS:
            slip = share * (width.high if share > 0.0 else -width.low)
            if slip:
                held = _others({**levels, other: slip}, swept)
                yield Maneuver("sweep", swept, limits.high, limits.low, limits.rate, held)


def _possible_rate(rate: float, limits: Limits, width: float) -> float:
    """Return a rate within the limits of the bench at which a half of a sweep is not too short."""
    return min(rate, limits.rate, abs(width) / SHORTEST)


def _others(levels: Mapping[str, float], swept: str) -> tuple[tuple[str, float], ...]:
    return tuple((name, value) for name, value in levels.items() if name != swept)
