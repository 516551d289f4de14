"""The log of a drive: channels with their own times, in SI units."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from ....boundary.errors import DataError, UnknownName, WrongType, nearest
from ....boundary.escaping import quoted
from ....measurements.files import native_reader
from ....measurements.files.columns import in_si, numbers
from ....measurements.files.csv_table import csv_cells
from ....measurements.files.parquet_table import parquet_cells
from ....measurements.files.ttc_mat import matlab_vectors
from .log_channels import LOG_CHANNELS, WHEEL_SPEEDS

FloatArray = npt.NDArray[np.float64]
#: Times and values of a channel.
Samples = tuple[FloatArray, FloatArray]
#: Types that are accepted as a log.
LogLike = pd.DataFrame | str | os.PathLike[str]

_UNIT = re.compile(r"(?P<name>.*?)\s*[\[(](?P<unit>[^\[\]()]*)[\])]")
EXTENSIONS = (".csv", ".parquet", ".mat", ".mf4", ".mdf", ".dat")
#: Fewest samples of a channel, and of the whole drive in seconds.
MIN_SAMPLES, MIN_SECONDS = 50, 5.0


@dataclass(frozen=True)
class Log:
    """A log in SI units.

    - `source`: name of the file.
    - `channels`: times (rising, from 0) and values of each channel; missing values are left out.
    """

    source: str
    channels: Mapping[str, Samples]

    def values(self, name: str) -> FloatArray:
        """Return the values of a channel."""
        return self.channels[name][1]

    def has_pose(self) -> bool:
        """Return whether position and heading are logged."""
        return {"x", "y", "heading"} <= self.channels.keys()

    def has_wheel_speeds(self) -> bool:
        """Return whether the spin of a wheel of each axle is logged."""
        return all(set(names) & self.channels.keys() for names in WHEEL_SPEEDS.values())


def read_log(log: LogLike, columns: Mapping[str, str] | None = None) -> Log:
    """Return the log of a file or a table.

    Parameters
    ----------
    log : pandas.DataFrame, str or path-like
        Columns with the names of `log_channels`; a header may declare a unit (``steer [deg]``). CSV, Parquet, MATLAB
        or MDF (``.mf4``, ``.mdf``, ``.dat``). Empty cells are times at which a channel was not sampled.
    columns : mapping of str to str, optional
        Header of a channel that has another name in the log, with a unit if the header has none.

    Returns
    -------
    Log
        In SI units.

    Raises
    ------
    DataError
        If the file cannot be read, a channel is not numeric, time decreases, a channel that is needed is missing or
        beyond any plausible value.
    UnknownName
        If `columns` has an unknown channel or unit.
    WrongType
        If the log is neither a table nor a path.
    """
    if isinstance(log, pd.DataFrame):
        source, cells = (
            "log",
            _from_table([str(name) for name in log.columns], log, "log", lambda row: f"row {row + 1}"),
        )
    elif isinstance(log, (str, os.PathLike)):
        source, cells = str(log), _from_file(Path(log))
    else:
        raise WrongType("log", log, "a DataFrame or the path of a file")
    channels = {}
    for name, header, unit in _matched(list(cells), columns or {}, source):
        t, values = cells[header]()
        declared = LOG_CHANNELS[name]
        place = f"{source}: column {header}"
        values = in_si(values, unit, declared.quantity, place) if unit else values
        channels[name] = _clean(t, values, name, place)
    _check(channels, source, list(cells))
    start = min(t[0] for t, _ in channels.values())
    return Log(source, {name: (t - start, values) for name, (t, values) in channels.items()})


Cells = Mapping[str, Callable[[], Samples]]


def _from_file(path: Path) -> Cells:
    kind = path.suffix.lower()
    if kind == ".csv":
        header, table, location = csv_cells(path)
        return _from_table(header, table, str(path), location)
    if kind == ".parquet":
        table = parquet_cells(path)
        return _from_table([str(name) for name in table.columns], table, str(path), lambda row: f"row {row + 1}")
    if kind == ".mat":
        vectors = matlab_vectors(path)
        size = max(map(len, vectors.values()), default=0)
        table = pd.DataFrame({name: values for name, values in vectors.items() if len(values) == size})
        return _from_table(list(table.columns), table, str(path), lambda row: f"row {row + 1}")
    if kind in EXTENSIONS:
        return _from_mdf(path)
    raise DataError(f"{path}: unknown kind of log {kind!r}: known are {', '.join(EXTENSIONS)}")


def _from_table(header: list[str], table: pd.DataFrame, source: str, location: Callable[[int], str]) -> Cells:
    repeated = {name for name in header if header.count(name) > 1}
    if repeated & {"t", *LOG_CHANNELS}:
        raise DataError(f"{source}: column {min(repeated)!r} occurs more than once")

    def column(number: int) -> Callable[[], Samples]:
        def samples() -> Samples:
            return np.empty(0), numbers(table.iloc[:, number].rename(header[number]), source, location)

        return samples

    return {name.strip(): column(number) for number, name in enumerate(header)}


def _from_mdf(path: Path) -> Cells:
    try:
        signals = native_reader.load("mdf", path)
    except native_reader.MissingPackage:
        raise DataError(f"{path}: MDF needs asammdf: pip install 'tirefmu[mdf]'") from None

    def samples(t: FloatArray, values: FloatArray) -> Callable[[], Samples]:
        return lambda: (np.asarray(t, dtype=np.float64), values)

    return {f"{name} [{unit}]" if unit else name: samples(t, values) for name, unit, t, values in signals}


def _matched(headers: list[str], columns: Mapping[str, str], source: str) -> Iterator[tuple[str, str, str]]:
    """Yield channel, header and declared unit of each channel that the log has; time is first."""
    plain = {(match["name"] if (match := _UNIT.fullmatch(header)) else header): header for header in headers}
    for name in columns:
        if name not in LOG_CHANNELS:
            raise UnknownName("channel of a log", name, LOG_CHANNELS)
    for name in LOG_CHANNELS:
        wanted = columns.get(name, name)
        match = _UNIT.fullmatch(wanted)
        if wanted in headers:
            header, unit = wanted, ""
        elif match and match["name"] in headers:
            header, unit = match["name"], match["unit"]
        elif wanted in plain:
            header, unit = plain[wanted], ""
        elif name in columns:
            raise DataError(f"{source}: no column {quoted(wanted)} for {name}{nearest(wanted, headers)}")
        else:
            continue
        declared = _UNIT.fullmatch(header)
        yield name, header, unit or (declared["unit"] if declared else "")


def _clean(t: FloatArray, values: FloatArray, name: str, place: str) -> Samples:
    if np.isinf(values).any():
        raise DataError(f"{place}: {name} is infinite in row {int(np.flatnonzero(np.isinf(values))[0]) + 1}")
    limit = LOG_CHANNELS[name].limit
    if (np.abs(values) > limit).any():
        unit = LOG_CHANNELS[name].unit
        raise DataError(
            f"{place}: {name} reaches {np.nanmax(np.abs(values)):g} {unit}, more than {limit:g}: another unit?"
        )
    return t, values


def _check(channels: dict[str, Samples], source: str, headers: list[str]) -> None:
    """Give each channel its times without gaps of its own, and raise if what an estimate needs is missing."""
    empty = [name for name, (t, _) in channels.items() if not len(t)]
    if empty and "t" not in channels:
        raise DataError(f"{source}: no channel t (time, s){_hint('t', headers)}")
    clock = channels.pop("t", (np.empty(0), np.empty(0)))[1]
    for name, (t, values) in channels.items():
        times = t if len(t) else clock
        usable = np.isfinite(values) & np.isfinite(times)
        times, values = times[usable], values[usable]
        steps = np.diff(times)
        if (steps < 0.0).any():
            row = int(np.flatnonzero(steps < 0.0)[0]) + 2
            raise DataError(
                f"{source}: time decreases at {name}, sample {row}: {times[row - 2]:g} to {times[row - 1]:g} s"
            )
        fresh = np.concatenate([[True], steps > 0.0]) if len(times) else usable[:0]
        channels[name] = times[fresh], values[fresh]
        if fresh.sum() < MIN_SAMPLES:
            raise DataError(f"{source}: {name} has {int(fresh.sum())} samples, fewer than {MIN_SAMPLES}")
    log = Log(source, channels)
    needed = {
        "steer": "steer" in channels,
        "yaw_rate": "yaw_rate" in channels or log.has_pose(),
        "ay": "ay" in channels or log.has_pose(),
        "speed": "speed" in channels or log.has_wheel_speeds() or log.has_pose(),
    }
    for name, present in needed.items():
        if not present:
            instead = "" if name == "steer" else ", or x, y and heading"
            raise DataError(
                f"{source}: no channel {name} ({LOG_CHANNELS[name].meaning}{instead}){_hint(name, headers)}"
            )
    duration = channels["steer"][0][-1] - channels["steer"][0][0]
    if duration < MIN_SECONDS:
        raise DataError(f"{source}: {duration:.3g} s are recorded, fewer than {MIN_SECONDS:g}")


def _hint(name: str, headers: list[str]) -> str:
    aliases = LOG_CHANNELS[name].aliases
    similar = [header for header in headers if header.casefold().replace(" ", "_").startswith(aliases)]
    meant = f"is it {quoted(similar[0])}? " if similar else ""
    return f": {meant}Name its column in [columns] of the car file or by --columns {name}=HEADER"
