"""Which channel of a drive the name of a column suggests."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from functools import lru_cache

from ....measurements.column_names import intended_channel, names_a_wheel
from ....measurements.files.columns.content import Column, Content, is_unit, name_and_unit
from ....measurements.files.columns.resolution import unit_at_end
from ....measurements.terms import OWNERS, words_of
from ....measurements.units import quantity_of
from ....symbolic.channels import CHANNELS, OUTPUTS
from .log_channels import LOG_CHANNELS, POSITIONS, SHORT

#: Characters of a name that the name of a column may contain among others.
SHORTEST_CONTAINED = 8
#: Characters of a name that the end of a path may be ("x" may be that of anything), and of one without separators
#: ("G(z)" is not gz); of the end behind the car or a sensor ("imu/x" may be anything).
SHORTEST_END, SHORTEST_JOINED, SHORTEST_OWNED = 5, 4, 2
#: Characters of a unit at the end of a name that makes another quantity of it ("in", "f", "c" may be anything); units
#: that names of channels have within.
SHORTEST_UNIT, IN_NAMES = 3, frozenset({"g", "rpm"})
#: Characters of a word to which an axis is joined.
SHORTEST_STEM = 3
#: Words of a name that make another quantity of it, in the words of `SHORT`; those of a wheel.
OTHERS = frozenset((
    "angular", "vert", "wind", "air", "motor", "engine", "target", "desired", "command", "cmd", "reference",
    "limit", "max", "min", "error", "accuracy", "variance", "covariance", "std", "torque", "moment", "power",
    "rate", "velocity", "speed", "acc", "jerk", "dot", "derivative", "steer",
))  # fmt: skip
WHEELS = frozenset({"fl", "fr", "rl", "rr"})
#: Channels that a bench has not.
OF_A_CAR = frozenset({"yaw_rate", *(f"omega_{wheel}" for wheel in WHEELS)})
_PATH = re.compile("[/.]")


def is_drive_log(content: Content, named: Collection[str] = ()) -> bool:
    """Return whether a file is the log of a drive: no force but of wheels, and two channels, a yaw rate or positions.

    `named`: channels that the user names; one that only a drive has decides.
    """
    if set(named) & (LOG_CHANNELS.keys() - CHANNELS.keys()):
        return True
    names = [name_and_unit(column.header)[0] for column in content.columns]
    if content.format in ("ttc", "tydex") or any(
        intended_channel(name) in OUTPUTS and not names_a_wheel(name) for name in names
    ):
        return False
    near = {nearest_channel(column) for column in content.columns} - {"", "t", "speed"}
    return (
        len(near) >= 2
        or bool(near & OF_A_CAR)
        or any(is_named(name, position) for name in names for position in POSITIONS)
    )


def nearest_channel(column: Column) -> str:
    """Return the channel of a drive that the name of a column suggests and its unit allows; empty without one.

    >>> [nearest_channel(Column("Yaw", [], unit)) for unit in ("deg/s", "deg", "bar")]
    ['yaw_rate', 'heading', '']
    >>> [nearest_channel(Column(name, [])) for name in ("AccLat_mps2", "/imu/angular_velocity/z", "field.speed")]
    ['ay', 'yaw_rate', 'speed']
    """
    return nearest(column).channel


@dataclass(frozen=True, order=True)
class Nearest:
    """The channel that the name of a column suggests.

    - `rank`: 0 if the name is one of the channel's, 1 if it contains one, 2 without a channel.
    - `shortness`: minus the characters of that name: of several, the longest one is meant.
    - `unit`: without brackets at the end of the name, or g within it ("G Force Lat"); empty without one.
    """

    rank: int = 2
    shortness: int = 0
    channel: str = ""
    unit: str = ""


def nearest(column: Column) -> Nearest:
    """Return the channel that the name of a column suggests, and how well it does."""
    name, unit = name_and_unit(column.header)[0], column.declared_unit
    quantity = quantity_of(unit) if is_unit(unit) else ""
    candidates = []
    wheel = WHEELS & set(_words(name).split("_"))
    for channel, declared in LOG_CHANNELS.items():
        if quantity in ("", declared.quantity):
            plain, ending = (name, "") if quantity else unit_at_end(name, declared.quantity)
            for alias in (channel, *declared.aliases, *(declared.with_unit if quantity or ending else ())):
                of_another = bool(wheel - set(alias.split("_")))
                if of_another and channel != "steer":
                    continue  # the slip or the acceleration of a wheel is not that of the car
                unit = ending or next((word for word in alias.split("_") if word in IN_NAMES and not quantity), "")
                if is_named(plain, alias) or is_named(name, alias):
                    candidates.append(Nearest(int(of_another), -len(alias), channel, unit))
                elif len(alias) >= SHORTEST_CONTAINED and _is_contained(_words(alias), _words(plain)):
                    candidates.append(Nearest(1, -len(alias), channel, unit))
    return min(candidates, default=Nearest())


def is_named(written: str, alias: str) -> bool:
    """Return whether a name, or the end of a path such as ``imu/angular_velocity/z``, has the words of an alias.

    Words of the car, of a sensor or of a filter do not count: ``Car.ay``, ``imu_gz``, ``ay_filtered``.
    """
    return not _forms_of_ends(written).isdisjoint(_forms(alias))


@lru_cache(maxsize=8192)
def _forms_of_ends(written: str) -> frozenset[tuple[str, ...]]:
    parts, words = _PATH.split(written), words_of(written)
    core = tuple(word for word in words if word not in OWNERS)
    ends = [("_".join(parts[first:]), SHORTEST_END if first else 0) for first in range(len(parts))]
    if core != words:
        ends.append(("_".join(core), SHORTEST_OWNED))
    forms = set[tuple[str, ...]]()
    for end, shortest in ends:
        length = len(_words(end).replace("_", ""))
        if length >= shortest:
            forms |= _forms(end) if length >= SHORTEST_JOINED else {form for form in _forms(end) if form[0] == "words"}
    return frozenset(forms)


@lru_cache(maxsize=8192)
def _forms(name: str) -> frozenset[tuple[str, ...]]:
    """Return the forms of a name of which two names of one thing share one: its words in any order, and joined."""
    words = _words(name).split("_")
    return frozenset((("words", *sorted(words)), ("joined", "".join(words)), ("plain", "".join(words_of(name)))))


def _is_contained(alias: str, name: str) -> bool:
    """Return whether a name has the words of an alias, and none or no unit that makes another quantity of it."""
    others = set(name.split("_")) - set(alias.split("_"))
    other_unit = len(unit_at_end(name)[1]) >= SHORTEST_UNIT
    return f"_{alias}_" in f"_{name}_" and not OTHERS & others and not other_unit


def nearest_column(name: str, content: Content) -> str:
    """Return the header of the first column whose nearest channel is a given one; empty without one."""
    return next((column.header for column in content.columns if nearest_channel(column) == name), "")


def _with_axis(word: str) -> tuple[str, ...]:
    """Return a word and the axis that is joined to it.

    >>> _with_axis("accelx"), _with_axis("gz")
    (('accel', 'x'), ('gz',))
    """
    stem, axis = word[:-1], word[-1:]
    joined = axis in ("x", "y", "z") and len(stem) >= SHORTEST_STEM and stem in {*SHORT, *SHORT.values()}
    return (stem, axis) if joined else (word,)


@lru_cache(maxsize=8192)
def _words(name: str) -> str:
    words = [SHORT.get(word, word) for written in words_of(name) for word in _with_axis(written)]
    axle, side = ([word for word in words if word in either] for either in (("front", "rear"), ("left", "right")))
    if len(axle) == len(side) == 1:  # front_left is fl
        words[words.index(axle[0])] = axle[0][0] + side[0][0]
        words.remove(side[0])
    return "_".join(words).replace("angle_velocity", "angular_velocity").replace("angle_speed", "angular_speed")
