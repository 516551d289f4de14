"""Bags of ROS 1 and 2 (``.bag``, ``.db3``, ``.mcap``) by rosbags: numbers of messages; a topic is a group.

Times are the stamps of the headers, otherwise those of the recording. Arrays and large messages are not read.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

LARGEST, DEEPEST = 1 << 14, 6


def load(path: str) -> tuple[list[tuple[Any, ...]], list[str]]:
    """Return the numbers of all topics; see `loaders`."""
    import numpy as np
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    samples: dict[tuple[str, str], list[tuple[int, float]]] = defaultdict(list)
    others: set[str] = set()
    with AnyReader([Path(path)], default_typestore=get_typestore(Stores.LATEST)) as reader:
        for connection, received, raw in reader.messages():
            if len(raw) > LARGEST or connection.topic in others:
                others.add(connection.topic)
                continue
            message = reader.deserialize(raw, connection.msgtype)
            stamp = getattr(getattr(message, "header", None), "stamp", None)
            time = stamp.sec * 10**9 + stamp.nanosec if stamp is not None and stamp.sec else received
            for name, value in _numbers(message, "", DEEPEST):
                samples[connection.topic, name].append((time, value))
    if not samples:
        return [], sorted(others)
    first = min(pairs[0][0] for pairs in samples.values())
    channels: list[tuple[Any, ...]] = []
    for (topic, name), pairs in samples.items():
        pairs.sort(key=lambda pair: pair[0])
        times = np.array([time - first for time, _ in pairs]) * 1e-9
        channels.append((name, "", topic.strip("/"), times, np.array([value for _, value in pairs]), None, ""))
    return channels, sorted(others)


def _numbers(message: Any, prefix: str, depth: int) -> Iterator[tuple[str, float]]:
    """Yield the names and values of the numbers in a message, and the heading of a quaternion."""
    names = [name for name in getattr(message, "__dataclass_fields__", ()) if name not in ("header", "__msgtype__")]
    for name in names:
        value = getattr(message, name)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            yield f"{prefix}{name}", float(value)
        elif depth and hasattr(value, "__dataclass_fields__"):
            yield from _numbers(value, f"{prefix}{name}.", depth - 1)
    if set(names) == {"x", "y", "z", "w"}:
        x, y, z, w = (float(getattr(message, name)) for name in ("x", "y", "z", "w"))
        yield f"{prefix}yaw", math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
