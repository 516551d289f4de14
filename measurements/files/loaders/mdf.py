"""MDF logs (``.mf4``, ``.mdf``, ``.dat``) by asammdf: groups of channels, each with its own times."""

from __future__ import annotations

from typing import Any


def load(path: str) -> tuple[list[tuple[Any, ...]], list[str]]:
    """Return the channels of all groups; see `loaders`."""
    from asammdf import MDF

    numbers, others = [], []
    with MDF(path) as file:
        groups: list[Any] = list(file.groups)
        labels = [_mdf_group(group) for group in groups]
        for number, group in enumerate(groups):
            label = labels[number] if labels.count(labels[number]) == 1 else ""
            master = file.masters_db.get(number)
            channel = None if master is None else group.channels[master]
            kind = 1 if channel is None else int(getattr(channel, "sync_type", 1) or 1)
            axis = "" if kind == 1 or channel is None else f"{channel.name} ({channel.unit or 'no unit'})"
            signals = file.select([(None, number, i) for i in range(len(group.channels)) if i != master])
            for signal in signals:
                if signal.samples.ndim == 1 and signal.samples.dtype.kind in "fiu":
                    unit, samples = str(signal.unit or ""), (signal.timestamps, signal.samples)
                    named = str(signal.name), unit, label or f"group {number + 1}"
                    numbers.append((*named, *samples, signal.invalidation_bits, axis))
                else:
                    others.append(str(signal.name))
    return numbers, others


def _mdf_group(group: Any) -> str:
    """Return the name of a group of channels, of its acquisition or its comment; empty without one."""
    named = getattr(group.channel_group, "acq_name", "") or getattr(group.channel_group, "comment", "") or ""
    name = " ".join(str(named).split())
    return name if len(name) <= 60 and "<" not in name else ""
