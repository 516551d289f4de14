"""A program: maneuvers in an order with pauses, starting sides and repeats, as rows over time and as steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, inf

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.measurements import INPUTS as RECORDED_INPUTS
from tirefmu.measurements import Program, TableLike, recording_from

from .bench_file import INPUTS, Bench
from .maneuvers import Maneuver

FloatArray = npt.NDArray[np.float64]
#: Number of maneuvers that follow each other at a level with a long change, about.
GROUPED = 4


@dataclass(frozen=True)
class Step:
    """A maneuver of a program.

    - `start`: s, of its first row.
    - `pause`: s before it, in which the bench changes levels and the tread cools.
    - `reason`: why it is in the program: "" or "repeat", to see drift.
    """

    maneuver: Maneuver
    start: float
    pause: float
    reason: str = ""

    @property
    def middle(self) -> float:
        """Time of its middle, s."""
        return self.start + 0.5 * self.maneuver.duration


@dataclass(frozen=True, eq=False)
class TestProgram:
    """The steps of a bench in their order."""

    bench: Bench
    steps: tuple[Step, ...]

    @property
    def seconds(self) -> float:
        """Bench time with the warm-up and all pauses."""
        return self.steps[-1].start + self.steps[-1].maneuver.duration

    @property
    def times(self) -> FloatArray:
        """The middle of each step, s."""
        return np.array([step.middle for step in self.steps])

    @cached_property
    def rows(self) -> pd.DataFrame:
        """``t`` and the inputs of all recorded rows; pauses are not recorded."""
        tables = [step.maneuver.table(self.bench.sample_rate) for step in self.steps]
        shifted = [table.assign(t=table["t"] + step.start) for table, step in zip(tables, self.steps, strict=True)]
        return pd.concat(shifted, ignore_index=True)

    @property
    def virtual(self) -> Program:
        """The program of the virtual bench."""
        return Program(self.bench.name, self.rows)

    @property
    def table(self) -> pd.DataFrame:
        """One line for each step in the units of a bench: deg, kPa, km/h."""
        lines = [_line(number, step) for number, step in enumerate(self.steps, 1)]
        return pd.DataFrame(lines)


def program_from(table: TableLike) -> Program:
    """Return the inputs of a table over time as a program of the virtual bench.

    Parameters
    ----------
    table : path, DataFrame or Recording
        With a column ``t``; columns that are not inputs are ignored.

    Returns
    -------
    Program

    Raises
    ------
    DataError
        If the table cannot be read, or is no program (`Program`).

    Examples
    --------
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
    least = bench.limits[maneuver.swept].change
    other = [name for name, value in maneuver.held if name in bench.limits and value != nominal[name] and name != "Fz"]
    longest = max([least, *(bench.limits[name].change for name in other)])
    pause = max(least, bench.limits["Fz"].change if "Fz" in bench.limits else 0.0, _cooling(maneuver, bench, energy))
    return maneuver.duration + pause + (longest - least) / GROUPED


def _cooling(maneuver: Maneuver, bench: Bench, energy: float) -> float:
    return max(0.0, energy / bench.heat.cooling - maneuver.duration) if bench.heat.cooling < inf else 0.0


def change_time(first: Maneuver, second: Maneuver, bench: Bench) -> float:
    """Return the seconds in which a bench gets from the end of a maneuver to the start of another one.

    The swept input starts at rest, so its time for a change is the least pause.
    """
    before, after = first.start, second.start
    changed = [name for name in INPUTS if name in bench.limits and before.get(name, 0.0) != after.get(name, 0.0)]
    return max(bench.limits[name].change for name in (*changed, second.swept))


def ordered(
    maneuvers: Sequence[Maneuver], energies: Sequence[float], bench: Bench, *, alternate: bool = True
) -> TestProgram:
    """Return the program with the shortest changes: the nearest maneuver follows.

    The first sweep is repeated at intervals of the bench and at the end. `alternate`: whether starting sides alternate.
    """
    left, order = list(range(len(maneuvers))), list[int]()
    while left:
        last = maneuvers[order[-1]] if order else None
        # Ties alternate between low and high loads, so that drift is not confounded with the load.
        sign = 1.0 if len(order) % 2 else -1.0
        nearest = min(left, key=lambda i: (
            change_time(last, maneuvers[i], bench) if last else 0.0, sign * dict(maneuvers[i].held).get("Fz", 0.0), i,
        ))  # fmt: skip
        left.remove(nearest)
        order.append(nearest)
    return _timed([maneuvers[i] for i in order], [energies[i] for i in order], bench, alternate)


def _timed(maneuvers: Sequence[Maneuver], energies: Sequence[float], bench: Bench, alternate: bool) -> TestProgram:
    steps: list[Step] = []
    end, repeated, cooling = bench.warm_up, bench.warm_up, 0.0

    def add(maneuver: Maneuver, energy: float, reason: str = "") -> None:
        nonlocal end, cooling
        row = 1.0 / bench.sample_rate  # no two rows at one time
        pause = max(change_time(steps[-1].maneuver, maneuver, bench), cooling, row) if steps else 0.0
        steps.append(Step(maneuver, ceil(1e3 * (end + pause) - 1e-6) / 1e3, pause, reason))
        end, cooling = steps[-1].start + maneuver.duration, _cooling(maneuver, bench, energy)

    for number, (maneuver, energy) in enumerate(zip(maneuvers, energies, strict=True)):
        if bench.repeat_every and end - repeated >= bench.repeat_every:
            add(maneuvers[0], energies[0], "repeat")
            repeated = end
        turned = alternate and number % 2 and maneuver.kind == "sweep"
        add(replace(maneuver, first=maneuver.second, second=maneuver.first) if turned else maneuver, energy)
    if bench.repeat_every and len(maneuvers) > 1:
        add(maneuvers[0], energies[0], "repeat")
    return TestProgram(bench, tuple(steps))


#: Columns of the list of steps: unit and factor from SI.
UNITS = {
    "kappa": ("", 1.0), "alpha": ("deg", 180.0 / np.pi), "gamma": ("deg", 180.0 / np.pi), "Fz": ("N", 1.0),
    "p": ("kPa", 1e-3), "V": ("km/h", 3.6),
}  # fmt: skip


def _line(number: int, step: Step) -> dict[str, object]:
    maneuver, (unit, factor) = step.maneuver, UNITS[step.maneuver.swept]
    duration = maneuver.duration
    held = {
        f"{name} ({UNITS[name][0]})" if UNITS[name][0] else name: round(value * UNITS[name][1], 4)
        for name, value in maneuver.held
    }
    return {
        "step": number, "start (s)": round(step.start, 2), "pause before (s)": round(step.pause, 2),
        "duration (s)": round(duration, 2), "maneuver": f"{maneuver.swept} {maneuver.kind}", "unit": unit,
        "first side": round(maneuver.first * factor, 4), "second side": round(maneuver.second * factor, 4),
        "rate (1/s)": 0.0 if maneuver.kind == "step" else round(maneuver.rate * factor, 4),
        **held, "reason": step.reason,
    }  # fmt: skip
