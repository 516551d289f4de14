"""A program: maneuvers in an order with pauses, starting sides and repeats, as rows over time and as steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, inf

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...measurements import INPUTS as RECORDED_INPUTS
from ...measurements import Program, TableLike, recording_from
from ...numerics.ties import graded
from .bench_file import INPUTS, Bench
from .maneuvers import Maneuver

FloatArray = npt.NDArray[np.float64]
#: Number of maneuvers that follow each other at a level with a long change, about.
GROUPED = 4
#: Units of the list of steps, and factors from SI.
UNITS = {
    "kappa": ("", 1.0), "alpha": ("deg", 180.0 / np.pi), "gamma": ("deg", 180.0 / np.pi), "Fz": ("N", 1.0),
    "p": ("kPa", 1e-3), "V": ("km/h", 3.6),
}  # fmt: skip


@dataclass(frozen=True)
class PlannedManeuver:
    """A maneuver of a program.

    - `number`: index among the maneuvers from which the program is made.
    - `start`: s, of its first row.
    - `pause`: s before it, in which the bench changes levels and the tread cools.
    - `reason`: why it is in the program: "" or "repeat", to see drift.
    """

    number: int
    maneuver: Maneuver
    start: float
    pause: float
    reason: str = ""

    @property
    def end(self) -> float:
        """Time of its last row, s."""
        return self.start + self.maneuver.duration


@dataclass(frozen=True, eq=False)
class TestProgram:
    """The steps of a bench in their order."""

    bench: Bench
    steps: tuple[PlannedManeuver, ...]

    @property
    def seconds(self) -> float:
        """Bench time with the warm-up and all pauses."""
        return self.steps[-1].end

    @property
    def times(self) -> FloatArray:
        """The middle of each step, s."""
        return np.array([0.5 * (step.start + step.end) for step in self.steps])

    @cached_property
    def tables(self) -> list[pd.DataFrame]:
        """``t`` from 0 and the inputs of each step."""
        return [step.maneuver.table(self.bench.sample_rate) for step in self.steps]

    @cached_property
    def rows(self) -> pd.DataFrame:
        """``t`` and the inputs of all recorded rows; pauses are not recorded."""
        shifted = (table.assign(t=table["t"] + step.start) for table, step in zip(self.tables, self.steps, strict=True))
        return pd.concat(shifted, ignore_index=True)

    @property
    def virtual(self) -> Program:
        """The program of the virtual bench."""
        return Program(self.bench.name, self.rows)

    @property
    def table(self) -> pd.DataFrame:
        """One line for each step in the units of a bench: deg, kPa, km/h."""
        return pd.DataFrame([_line(number, step) for number, step in enumerate(self.steps, 1)])


def program_from(table: TableLike) -> Program:
    """Return the inputs of a table over time as a program of the virtual bench; other columns are ignored.

    Raises `DataError` if the table cannot be read, or is no program.

    >>> len(program_from(pd.DataFrame({"t": [0.0, 0.1], "alpha": 0.05, "Fz": 700.0})))
    2
    """
    recording = recording_from(table)
    inputs = recording.with_signs("iso").table
    return Program(recording.source, inputs[[name for name in RECORDED_INPUTS if name in inputs]])


def cost(maneuver: Maneuver, bench: Bench, energy: float, nominal: Mapping[str, float]) -> float:
    """Return the seconds of a maneuver with the change before it and the pause in which the tread cools.

    `nominal`: the levels of most maneuvers. `GROUPED` maneuvers share the change to another level, except that of the
    load.
    """
    shortest = bench.limits[maneuver.swept].change
    other = [name for name, value in maneuver.held if name in bench.limits and value != nominal[name] and name != "Fz"]
    longest = max([shortest, *(bench.limits[name].change for name in other)])
    load = bench.limits["Fz"].change if "Fz" in bench.limits else 0.0
    return maneuver.duration + max(shortest, load, _cooling(maneuver, bench, energy)) + (longest - shortest) / GROUPED


def _cooling(maneuver: Maneuver, bench: Bench, energy: float) -> float:
    return max(0.0, energy / bench.heat.cooling - maneuver.duration) if bench.heat.cooling < inf else 0.0


def change_time(first: Maneuver, second: Maneuver, bench: Bench) -> float:
    """Return the seconds in which a bench gets from the end of a maneuver to the start of another one.

    The swept input starts at rest, so its time for a change is the least pause.
    """
    before, after = first.start, second.start
    changed = [name for name in INPUTS if name in bench.limits and before.get(name, 0.0) != after.get(name, 0.0)]
    return max(bench.limits[name].change for name in (*changed, second.swept))


def nearest_order(maneuvers: Sequence[Maneuver], bench: Bench) -> list[int]:
    """Return the order in which the nearest maneuver follows, so that changes are short."""
    left, order = list(range(len(maneuvers))), list[int]()
    while left:
        # Ties alternate between low and high loads, so that drift is not confounded with the load.
        sign = 1.0 if len(order) % 2 else -1.0
        order.append(min(left, key=lambda i: (
            change_time(maneuvers[order[-1]], maneuvers[i], bench) if order else 0.0,
            sign * dict(maneuvers[i].held).get("Fz", 0.0), i,
        )))  # fmt: skip
        left.remove(order[-1])
    return order


def timed(
    maneuvers: Sequence[Maneuver], energies: Sequence[float], bench: Bench, *, alternate: bool = True
) -> TestProgram:
    """Return the program of maneuvers in their order.

    The first one is repeated at intervals of the bench and at the end. `alternate`: whether starting sides alternate.
    """
    steps: list[PlannedManeuver] = []
    repeated, shortest = bench.warm_up, 1.0 / bench.sample_rate  # no two rows at one time

    def add(number: int, *, turned: bool = False, reason: str = "") -> None:
        pause, start = 0.0, bench.warm_up
        if steps:
            last = steps[-1].number
            cooling = _cooling(maneuvers[last], bench, energies[last])
            pause = max(change_time(maneuvers[last], maneuvers[number], bench), cooling, shortest)
            start = steps[-1].end + pause
        maneuver = maneuvers[number].turned if turned else maneuvers[number]
        steps.append(PlannedManeuver(number, maneuver, ceil(1e3 * start - 1e-6) / 1e3, pause, reason))

    for number in range(len(maneuvers)):
        if bench.repeat_every and steps and steps[-1].end - repeated >= bench.repeat_every:
            add(0, reason="repeat")
            repeated = steps[-1].end
        add(number, turned=alternate and number % 2 == 1)
    if bench.repeat_every and len(maneuvers) > 1:
        add(0, reason="repeat")
    return TestProgram(bench, tuple(steps))


def _line(number: int, step: PlannedManeuver) -> dict[str, object]:
    maneuver, (unit, factor) = step.maneuver, UNITS[step.maneuver.swept]
    held = {
        f"{name} ({UNITS[name][0]})" if UNITS[name][0] else name: round(value * UNITS[name][1], 4)
        for name, value in maneuver.held
    }
    first = next(value for value in maneuver.values if value)
    second = max(maneuver.values, key=lambda value: graded(abs(value - first)))
    return {
        "step": number, "start (s)": round(step.start, 2), "pause before (s)": round(step.pause, 2),
        "duration (s)": round(maneuver.duration, 2), "maneuver": f"{maneuver.swept} {maneuver.kind}", "unit": unit,
        "first side": round(first * factor, 4), "second side": round(second * factor, 4),
        "rate (1/s)": round(maneuver.rate * factor, 4),
        **held, "reason": step.reason,
    }  # fmt: skip
