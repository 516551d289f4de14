"""The units of figures, tables and messages: SI units, but degrees for angles and kPa for pressures."""

from __future__ import annotations

from math import degrees

from tirefmu.symbolic import quantities
from tirefmu.symbolic.declarations import Quantity

_UNITS = {"t": "s"} | {each.name: each.unit for each in vars(quantities).values() if isinstance(each, Quantity)}
_WRITTEN = {"1": "-", "degC": "deg C"}
_DRAWN = {"rad": ("deg", degrees(1.0)), "Pa": ("kPa", 1e-3)}


def drawn_unit(channel: str) -> str:
    """Return the unit in which a channel is drawn: its SI unit, but degrees and kPa."""
    unit = _UNITS[channel]
    return _DRAWN[unit][0] if unit in _DRAWN else _WRITTEN.get(unit, unit)


def per_si(channel: str) -> float:
    """Return what turns a channel's SI value into the drawn one."""
    unit = _UNITS[channel]
    return _DRAWN[unit][1] if unit in _DRAWN else 1.0
