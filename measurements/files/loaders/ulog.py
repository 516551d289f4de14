"""PX4 logs (``.ulg``) by pyulog: SI units; a topic is a group. Topics of several instances have their numbers."""

from __future__ import annotations

from collections import Counter
from typing import Any


def load(path: str) -> tuple[list[tuple[Any, ...]], list[str]]:
    """Return the fields of all topics; see `loaders`."""
    from pyulog import ULog

    topics = ULog(path).data_list
    counts = Counter(topic.name for topic in topics)
    channels = []
    for topic in topics:
        group = topic.name if counts[topic.name] == 1 else f"{topic.name}_{topic.multi_id}"
        start = topic.data["timestamp"][0] if len(topic.data["timestamp"]) else 0
        times = (topic.data["timestamp"] - start) * 1e-6 + int(start) * 1e-6
        for name, samples in topic.data.items():
            if name != "timestamp" and samples.dtype.kind in "fiu":
                channels.append((name, "", group, times, samples, None, ""))
    return channels, []
