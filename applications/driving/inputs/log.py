"""The log of a drive: channels with their own times, in SI units."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
import pandas as pd

from ....boundary.errors import DataError, WrongType
from ....boundary.escaping import quoted
from ....measurements.files.columns.content import Content, names_of
from ....measurements.files.columns.frames import frame_content
from ....measurements.files.columns.resolution import ColumnChoice, choices, ignored_columns
from ....measurements.files.reading import read_content
from .clock import clock_problem
from .log_channels import LOG_CHANNELS, POSE, WHEEL_SPEEDS, LogChannel, lacking
from .nearest_channel import nearest_column
from .several import several_cars

FloatArray = npt.NDArray[np.float64]
#: Times and values of a channel.
Samples = tuple[FloatArray, FloatArray]
#: Types that are accepted as a log.
LogLike = pd.DataFrame | str | os.PathLike[str]

#: Fewest samples of a channel, and of the whole drive in seconds.
MIN_SAMPLES, MIN_SECONDS = 50, 5.0


@dataclass(frozen=True)
class Log:
    """A log in SI units.

    - `source`: name of the file.
    - `channels`: times (rising, from 0) and values of each channel; missing values are left out.
    - `ignored`: what of the file is not read, in one line.
    - `units`: by channel, the unit of its numbers in the file; empty for SI.
    - `exchanged`: axles whose wheel speeds have the sides of the other wheel in the file.
    """

    source: str
    channels: Mapping[str, Samples]
    ignored: str = ""
    units: Mapping[str, str] = field(default_factory=dict)
    exchanged: tuple[str, ...] = ()

    def with_exchanged(self, axles: tuple[str, ...]) -> Log:
        """Return the log with left and right wheel speeds of axles exchanged."""
        pairs = [WHEEL_SPEEDS[axle] for axle in axles]
        other = {name: other for left, right in pairs for name, other in ((left, right), (right, left))}
        channels = {name: self.channels[other.get(name, name)] for name in self.channels}
        return replace(self, channels=channels, exchanged=axles)

    def values(self, name: str) -> FloatArray:
        """Return the values of a channel."""
        return self.channels[name][1]

    def has_pose(self) -> bool:
        """Return whether position and heading are logged."""
        return set(POSE) <= self.channels.keys()

    def has_wheel_speeds(self) -> bool:
        """Return whether the spin of a wheel of each axle is logged."""
        return all(set(names) & self.channels.keys() for names in WHEEL_SPEEDS.values())


def read_log(log: LogLike, columns: Mapping[str, str] | None = None) -> Log:
    """Return the log of a file or a table.

    Parameters
    ----------
    log : pandas.DataFrame, str or path-like
        Columns with the names of `log_channels`; a header may declare a unit (``steer [deg]``). A file is of any format
        of docs/files.md. Empty cells are times at which a channel was not sampled.
    columns : mapping of str to str, optional
        By channel, the column of another name: ``HEADER``, ``-HEADER`` for the other sign, ``HEADER [unit]`` for
        another unit than the file declares.

    Returns
    -------
    Log
        In SI units. Positions and heading are read if all three are there.

    Raises
    ------
    DataError
        If the file cannot be read, a channel is not numeric, time decreases or is implausible, a channel that is needed
        is missing or beyond any plausible value.
    UnknownName
        If `columns` has an unknown channel or unit.
    WrongType
        If the log is neither a table nor a path.
    """
    if isinstance(log, pd.DataFrame):
        source, content = "log", frame_content(log, "log")
    elif isinstance(log, (str, os.PathLike)):
        source, content = str(log), read_content(log)
    else:
        raise WrongType("log", log, "a DataFrame or the path of a file")
    chosen = choices(content, LOG_CHANNELS, source, columns)
    if not set(POSE) <= chosen.keys():
        chosen = {name: choice for name, choice in chosen.items() if name not in POSE}
    channels = samples_of(content, chosen, source)
    _check(channels, chosen, content, source)
    start = min(t[0] for t, _ in channels.values())
    moved = {name: (t - start, values) for name, (t, values) in channels.items()}
    units = {name: choice.unit for name, choice in chosen.items()}
    return Log(source, moved, ignored_columns(content, chosen), units)


def samples_of(content: Content, chosen: Mapping[str, ColumnChoice], source: str) -> dict[str, Samples]:
    """Return the times and the values of channels in SI units, without samples that have no value.

    Raises `DataError` if a channel has no times, is not numeric or beyond any plausible value, or time decreases.
    """
    clock = chosen["t"].values(content, source) if "t" in chosen else None
    samples = dict[str, Samples]()
    for name, choice in chosen.items():
        times = choice.column.times if choice.column.times is not None else clock
        if name == "t" or times is None:
            continue
        values, place = choice.values(content, source), choice.place(source)
        _check_size(values, name, place)
        if len(values) != len(times):
            raise DataError(f"{place}: {name} has {len(values)} samples, the time has {len(times)}")
        samples[name] = np.asarray(times, dtype=np.float64), values
    read = [(chosen[name].column, values) for name, (_, values) in samples.items()]
    if clock is not None and (several := several_cars(content, clock, read)):
        raise DataError(f"{source}: {several}")
    channels = {}
    for name, (times, values) in samples.items():
        usable = np.isfinite(values) & np.isfinite(times)
        times, values = times[usable], values[usable]
        if problem := clock_problem(times, "" if "t" not in chosen else chosen["t"].column.header):
            raise DataError(f"{source}: {problem}")
        fresh = np.diff(times, prepend=-np.inf) > 0.0
        channels[name] = times[fresh], values[fresh]
    return channels


def _check_size(values: FloatArray, name: str, place: str) -> None:
    if np.isinf(values).any():
        raise DataError(f"{place}: {name} is infinite in row {int(np.flatnonzero(np.isinf(values))[0]) + 1}")
    limit = LOG_CHANNELS[name].limit
    if (np.abs(values) > limit).any():
        unit = LOG_CHANNELS[name].unit
        raise DataError(
            f"{place}: {name} reaches {np.nanmax(np.abs(values)):g} {unit}, more than {limit:g}: another unit? "
            f"State it: --columns '{name}=HEADER [unit]'"
        )


def _check(channels: Mapping[str, Samples], chosen: Mapping[str, ColumnChoice], content: Content, source: str) -> None:
    """Raise if what an estimate needs is missing."""
    if "t" not in chosen and all(column.times is None for column in content.columns):
        has = "" if chosen else f": {names_of(content)}"
        raise DataError(f"{source}: no channel {_lacks(LOG_CHANNELS['t'], content)}{has}; {_naming('t', content)}")
    for name, (t, _) in channels.items():
        if len(t) < MIN_SAMPLES:
            raise DataError(f"{source}: {name} has {len(t)} samples, fewer than {MIN_SAMPLES}")
    if lacks := lacking(channels):
        texts = (_lacks(channel, content) for channel in lacks)
        raise DataError(f"{source}: no channel {'; no channel '.join(texts)}; {_naming(lacks[0].name, content)}")
    duration = channels["steer"][0][-1] - channels["steer"][0][0]
    if duration < MIN_SECONDS:
        raise DataError(f"{source}: {duration:.3g} s are recorded, fewer than {MIN_SECONDS:g}")


def _lacks(channel: LogChannel, content: Content) -> str:
    """Return name and meaning of a channel that a log lacks, and its probable column or where it comes from."""
    instead = ", or x, y and heading" if channel.instead else ""
    similar = nearest_column(channel.name, content)
    remedy = f"perhaps {quoted(similar)}" if similar else f"it comes from {channel.source}" if channel.source else ""
    return f"{channel.name} ({channel.meaning}{instead}){': ' if remedy else ''}{remedy}"


def _naming(name: str, content: Content) -> str:
    ignored = f" (not read: {'; '.join(content.ignored)})" if content.ignored else ""
    return f"name its column by --columns {name}=HEADER, or in [columns], which tirefmu inspect proposes{ignored}"
