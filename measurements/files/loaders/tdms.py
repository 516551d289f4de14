"""TDMS files of National Instruments by npTDMS: times of the waveform, or of a channel of times in the group."""

from __future__ import annotations

from typing import Any

_TIME = ("t", "time", "timestamp", "timestamps", "elapsed time", "x_time")


def load(path: str) -> tuple[list[tuple[Any, ...]], list[str]]:
    """Return the channels of all groups; see `loaders`."""
    from nptdms import TdmsFile

    channels, others = [], []
    for group in TdmsFile.read(path).groups():
        members = [(channel, channel[:]) for channel in group.channels()]
        clock = next((values for channel, values in members if _is_clock(channel.name, values, _unit(channel))), None)
        for channel, values in members:
            if getattr(values, "dtype", None) is None or values.dtype.kind not in "fiuM" or values.ndim != 1:
                others.append(str(channel.name))
                continue
            times = clock if clock is not None and len(clock) == len(values) else None
            if {"wf_increment", "wf_start_offset"} <= channel.properties.keys():
                times = channel.time_track()
            elif times is not None and times.dtype.kind == "M":
                times = (times - times[0]).astype("timedelta64[ns]").astype(float) * 1e-9
            elif values is clock:
                times = None  # the column t of the group
            channels.append((str(channel.name), _unit(channel), str(group.name), times, values, None, ""))
    return channels, others


def _unit(channel: Any) -> str:
    properties = channel.properties
    return str(properties.get("unit_string") or properties.get("NI_UnitDescription") or "")


def _is_clock(name: str, values: Any, unit: str) -> bool:
    """Return whether a channel has the times of its group in seconds, or as dates."""
    dates = getattr(getattr(values, "dtype", None), "kind", "") == "M"
    return dates or (name.strip().casefold() in _TIME and unit.casefold() in ("", "s", "sec"))
