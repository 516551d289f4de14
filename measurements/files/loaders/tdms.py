"""TDMS files of National Instruments by npTDMS: times of the waveform, or of a channel of times in the group."""

from __future__ import annotations

from typing import Any

_TIME = ("t", "time", "timestamp", "timestamps", "elapsed time", "x_time")


def load(path: str) -> tuple[list[tuple[Any, ...]], list[str]]:
    """Return the channels of all groups; see `loaders`. Times of channels with a date count from the earliest one."""
    from nptdms import TdmsFile

    channels: list[tuple[Any, ...]] = []
    starts, others = [], []
    for group in TdmsFile.read(path).groups():
        members = [(channel, channel[:]) for channel in group.channels()]
        clock = next((values for channel, values in members if _is_clock(channel.name, values, _unit(channel))), None)
        for channel, values in members:
            if getattr(values, "dtype", None) is None or values.dtype.kind not in "fiuM" or values.ndim != 1:
                others.append(str(channel.name))
                continue
            times, start = _times(channel, values, clock)
            starts.append(start)
            channels.append((str(channel.name), _unit(channel), str(group.name), times, values, None, ""))
    first = min((start for start in starts if start is not None), default=None)
    for number, start in enumerate(starts):
        if start is not None:
            *head, times, values, invalid, axis = channels[number]
            channels[number] = (*head, times + _seconds(start - first), values, invalid, axis)
    return channels, others


def _times(channel: Any, values: Any, clock: Any) -> tuple[Any, Any]:
    """Return the times of a channel in s, or None, and the date from which they count, or None."""
    import numpy as np

    properties = channel.properties
    if "wf_increment" in properties:
        start = properties.get("wf_start_time")
        set_by_logger = start is not None and start > np.datetime64(0, "s")  # otherwise it is 1904, or no date
        steps = properties["wf_increment"] * np.arange(len(values))
        return properties.get("wf_start_offset", 0.0) + steps, start if set_by_logger else None
    if clock is None or len(clock) != len(values):
        return None, None
    if clock.dtype.kind == "M":
        start = np.fmin.reduce(clock)  # the earliest that is a date
        return _seconds(clock - start), start
    return None if values is clock else clock, None  # the clock is the column t of the group


def _seconds(durations: Any) -> Any:
    return durations.astype("timedelta64[ns]").astype(float) * 1e-9


def _unit(channel: Any) -> str:
    properties = channel.properties
    return str(properties.get("unit_string") or properties.get("NI_UnitDescription") or "")


def _is_clock(name: str, values: Any, unit: str) -> bool:
    """Return whether a channel has the times of its group in seconds, or as dates."""
    dates = getattr(getattr(values, "dtype", None), "kind", "") == "M"
    return dates or (name.strip().casefold() in _TIME and unit.casefold() in ("", "s", "sec"))
