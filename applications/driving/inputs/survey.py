"""Contents of the log of a drive, and the proposed column, unit and axis of each channel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ....boundary.errors import UnknownName
from ....boundary.escaping import toml_string
from ....measurements.files.columns.content import Column, Content, is_unit, name_and_unit
from ....measurements.files.columns.resolution import choices
from ....measurements.interpretation import NOT_READ
from ....measurements.units import meanings, to_si
from .car_entries import example_text
from .clock import TRIED, clock_problem
from .log_channels import LOG_CHANNELS, TURNED, lacking, share_of_lock
from .nearest_channel import Nearest, nearest, nearest_channel
from .several import several_cars
from .shown_units import (
    FloatArray,
    Sampled,
    agreed,
    gravity_of,
    meant_unit,
    numbers_of,
    proposed_text,
    speeds_of_rims,
    turned_as_fast,
    with_unit,
)

#: Steps between samples, in median steps, from which they are a gap.
GAP = 5.0


@dataclass(frozen=True)
class SurveyedColumn:
    """One column of a log.

    - `header`, `group`, `unit`: of the file; the unit is empty if it declares none.
    - `samples`: number of values; NaN and invalid ones are none. `rate`: Hz. `longest_gap`: s; 0 without one.
    - `lowest`, `highest`: in the unit of the file. `nearest`: the channel that its name suggests; empty without one.
    """

    header: str
    group: str
    unit: str
    samples: int
    rate: float
    longest_gap: float
    lowest: float
    highest: float
    nearest: str


@dataclass(frozen=True)
class Survey:
    """The columns of a log, the proposed section [columns] of a car file, and how it was decided."""

    columns: tuple[SurveyedColumn, ...]
    proposal: Mapping[str, str]
    notes: tuple[str, ...]

    @property
    def section(self) -> str:
        """The section [columns] of a car file.

        >>> print(Survey((), {"yaw_rate": "-gz [deg/s]"}, ("z points down",)).section)
        [columns]
        # z points down
        yaw_rate = "-gz [deg/s]"
        """
        lines = [f"{name} = {toml_string(text)}" for name, text in self.proposal.items()]
        return "\n".join(["[columns]", *(f"# {note}" for note in self.notes), *lines])

    def car_text(self) -> str:
        """Return a car file with this section; its numbers are examples and comments."""
        body = example_text().partition("[columns]")[0]
        lines = [f"# {line}" if line and line[0] not in "#[" else line for line in body.splitlines()]
        return "\n".join([*lines, self.section, ""])


def survey(content: Content, source: str, columns: Mapping[str, str] | None = None) -> Survey:
    """Return what a log contains.

    `columns`: by channel, the column that the user names, as for `read_log`. Raises `DataError` if a named column does
    not exist, or the column of time is not one, and `UnknownName` for an unknown channel.
    """
    columns = {name: text for name, text in (columns or {}).items() if text != NOT_READ}
    for name in columns:
        if name not in LOG_CHANNELS:
            raise UnknownName("channel", name, LOG_CHANNELS)
    wanted = choices(content, {name: LOG_CHANNELS[name] for name in columns}, source, columns)
    named = {id(choice.column): name for name, choice in wanted.items()}
    notes: list[str] = []
    clock, clock_text = _clock(content, source, columns.get("t", ""))
    rows: list[SurveyedColumn] = []
    values: dict[str, Sampled] = {}
    best: dict[str, tuple[int, int]] = {}
    for column in content.columns:
        times = column.times if column.times is not None else clock
        data = numbers_of(column, content, source)
        if data is None or (times is not None and len(data) != len(times)):
            continue
        near = Nearest(-2, 0, named[id(column)]) if id(column) in named else nearest(column)
        rows.append(_surveyed(column, data, times, near))
        present = data[np.isfinite(data)]
        if not len(present) and id(column) not in named:
            continue  # a sensor that the car does not have
        fit = near.rank + (len(present) == 0 or np.ptp(present) == 0.0) + (not present.any()), -len(present)
        if near.channel not in ("", "t") and fit < best.get(near.channel, (2, 0)):
            best[near.channel], values[near.channel] = fit, (column, data, times)
    gravity = gravity_of(content, source)
    down = content.down or gravity.down
    if down:
        why = "by the definition of the format" if content.down else "the vertical acceleration is -g"
        notes.append(f"axes forward, right, down ({why}): channels of turning get a minus")
    proposal = {"t": clock_text} if clock_text else {}
    for name in LOG_CHANNELS:
        if name in values:
            column, data, _ = values[name]
            sign = "-" if down and name in TURNED else ""
            text = proposed_text(column, name, data, gravity)
            if name not in columns and (units := meanings(name_and_unit(text)[1] or column.declared_unit)):
                unit, why = meant_unit(name, units, proposal.get("speed", ""), values)
                text = f"{name_and_unit(text)[0]} [{unit}]"
                notes.append(f"{name}: the unit of {column.header.strip()} is {' or '.join(units)}: {why}")
            proposal[name] = columns.get(name) or f"{sign}{text}"
    read = [(column, data) for column, data, _ in values.values()]
    if clock is not None:
        finite = clock[np.isfinite(clock)]
        notes += filter(None, [several_cars(content, clock, read) or clock_problem(finite, clock_text)])
    copies: dict[bytes, list[str]] = {}
    for name, (_, data, _) in values.items():
        copies.setdefault(data.tobytes() if len(np.unique(data[np.isfinite(data)])) > 1 else name.encode(), []).append(
            name
        )
    notes += [f"{', '.join(names)} have the same numbers: copies of one" for names in copies.values() if len(names) > 1]
    if "steer" in values and "steer" not in columns and not is_unit(values["steer"][0].declared_unit):
        notes += filter(None, [share_of_lock(values["steer"][1])])
    notes += agreed(proposal, values, columns)
    notes += filter(None, [turned_as_fast(proposal, values, columns), speeds_of_rims(proposal, values)])
    notes += [content.about["decimals"]] if "decimals" in content.about else []
    clocks = clock is not None or any(column.times is not None for column in content.columns)
    if lacks := [*([] if clocks else ["t"]), *(channel.name for channel in lacking(proposal))]:
        notes.append(f"not there, and needed for an estimate of the tires: {', '.join(lacks)}")
    changed = {name: text for name, text in proposal.items() if text != name}
    return Survey(tuple(rows), changed, tuple(notes))


def _surveyed(column: Column, values: FloatArray, times: FloatArray | None, near: Nearest) -> SurveyedColumn:
    present = values[np.isfinite(values)]
    steps = np.diff(times[np.isfinite(values)]) if times is not None else np.empty(0)
    forward = steps[steps > 0.0]
    step = float(np.median(forward)) if len(forward) else 0.0
    gap = float(forward.max()) if len(forward) and forward.max() > GAP * step else 0.0
    low, high = (float(present.min()), float(present.max())) if len(present) else (0.0, 0.0)
    rate = 1.0 / step if step else 0.0
    unit = column.declared_unit or near.unit
    return SurveyedColumn(column.header, column.group, unit, len(present), rate, gap, low, high, near.channel)


def _clock(content: Content, source: str, named: str) -> tuple[FloatArray | None, str]:
    """Return the times in s and how the car file names their column; nothing if each channel has its own.

    `named`: the column that the user names; empty without one.
    """
    if any(column.times is not None for column in content.columns):
        return None, ""
    header = named or next(
        (column.header for column in content.columns if column.meant == "t" or "t" in column.names), ""
    )
    if not header:
        near = next((column for column in content.columns if nearest_channel(column) == "t"), None)
        header = with_unit(near, "t") if near else ""
    if not header:
        return None, ""
    chosen = choices(content, {"t": LOG_CHANNELS["t"]}, source, {"t": header})["t"]
    times = chosen.values(content, source)
    finite = times[np.isfinite(times)]
    if not chosen.declared and clock_problem(finite, header):
        for unit in TRIED:
            if not clock_problem(np.asarray(to_si(finite, unit)), header):
                return np.asarray(to_si(times, unit)), f"{header} [{unit}]"
    return times, header
