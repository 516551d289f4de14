"""Logs that libraries read: MDF, TDMS, PX4 and ROS. Each group of channels, topic or message has its own times."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from ....boundary.errors import DataError
from .. import native_reader
from ..columns.content import Column, Content, listed, masked

#: By loader: what it reads, the package that it needs, and the extra that installs it.
PACKAGES = {
    "mdf": ("MDF", "asammdf", "mdf"),
    "tdms": ("TDMS", "npTDMS", "tdms"),
    "ulog": ("PX4 logs", "pyulog", "px4"),
    "rosbag": ("bags of ROS", "rosbags", "ros"),
}
#: Formats whose axes are forward, right, down by definition.
DOWN = ("ulog",)


def _read(format_name: str, path: Path) -> Content:
    """Return the content of a log; samples that it marks as invalid are none.

    Raises `DataError` if the package that reads it is not installed, or the file has another format.
    """
    try:
        channels, others = native_reader.load("log", path, format_name)
    except native_reader.MissingPackage:
        kind, package, extra = PACKAGES[format_name]
        raise DataError(f"{path}: {kind}: {package} is needed: pip install 'tirefmu[{extra}]'") from None
    columns = tuple(
        Column(name, samples if invalid is None else masked(samples, invalid), unit, "", group, times, axis)
        for name, unit, group, times, samples, invalid, axis in channels
    )
    if not any(len(column.cells) for column in columns):
        raise DataError(f"{path}: no numbers{f': it has {listed(others)}' if others else ''}")
    ignored = (f"channels without numbers {listed(others)}",) if others else ()
    return Content(columns, format=format_name, ignored=ignored, down=format_name in DOWN)


read_mdf = partial(_read, "mdf")
read_tdms = partial(_read, "tdms")
read_ulog = partial(_read, "ulog")
read_rosbag = partial(_read, "rosbag")
