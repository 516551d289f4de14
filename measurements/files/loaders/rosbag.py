"""Bags of ROS 1 and 2 (``.bag``, ``.db3``, ``.mcap``) by rosbags: numbers of messages; a topic is a group.

Times are the stamps of the headers, otherwise those of the recording. Arrays, large messages and topics of a type that
neither the bag nor ROS 2 describes are not read.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

LARGEST, DEEPEST = 1 << 14, 6


def load(path: str) -> tuple[list[tuple[Any, ...]], list[str]]:
    """Return the numbers of all topics; see `loaders`."""
    import numpy as np
    from rosbags import rosbag1, rosbag2

    first_version = path.endswith(".bag")
    samples: Mapping[tuple[str, str], list[tuple[int, float]]] = defaultdict(list)
    others: set[str] = set()
    with (rosbag1 if first_version else rosbag2).Reader(Path(path)) as reader:
        stores = {connection.id: _types(connection) for connection in reader.connections}
        others.update(connection.topic for connection in reader.connections if stores[connection.id] is None)
        read = [connection for connection in reader.connections if connection.topic not in others]
        for connection, received, raw in reader.messages(connections=read) if read else ():
            if len(raw) > LARGEST or connection.topic in others:
                others.add(connection.topic)
                continue
            store = stores[connection.id]
            decode = store.deserialize_ros1 if first_version else store.deserialize_cdr
            try:
                message = decode(raw, connection.msgtype)
            except Exception:  # bytes of another type: the library raises errors of many types
                others.add(connection.topic)
                continue
            stamp = getattr(getattr(message, "header", None), "stamp", None)
            time = stamp.sec * 10**9 + stamp.nanosec if stamp is not None and stamp.sec else received
            for name, value in _numbers(message, "", DEEPEST):
                samples[connection.topic, name].append((time, value))
    samples = {key: pairs for key, pairs in samples.items() if key[0] not in others}
    if not samples:
        return [], sorted(others)
    first = min(pairs[0][0] for pairs in samples.values())
    channels: list[tuple[Any, ...]] = []
    for (topic, name), pairs in samples.items():
        pairs.sort(key=lambda pair: pair[0])
        times = np.array([time - first for time, _ in pairs]) * 1e-9
        channels.append((name, "", topic.strip("/"), times, np.array([value for _, value in pairs]), None, ""))
    return channels, sorted(others)


def _types(connection: Any) -> Any:
    """Return the types of a topic, as the bag describes them, otherwise as ROS 2 does; None if neither does."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    described = get_typestore(Stores.EMPTY)
    try:
        described.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
    except Exception:  # a service, an interface description, or none: the library raises errors of many types
        described = get_typestore(Stores.LATEST)
    return described if connection.msgtype in described.fielddefs else None


def _numbers(message: Any, prefix: str, depth: int) -> Iterator[tuple[str, float]]:
    """Yield the names and values of the numbers in a message."""
    for name in (entry.name for entry in fields(message) if entry.name != "header"):
        value = getattr(message, name)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            yield f"{prefix}{name}", float(value)
        elif depth and is_dataclass(value):
            yield from _numbers(value, f"{prefix}{name}.", depth - 1)
