"""Contents of the log of a drive, and the proposed column, unit and axis of each channel."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
import numpy.typing as npt

from ....boundary.errors import TirefmuError, UnknownName
from ....boundary.escaping import toml_string
from ....measurements.column_names import intended_channel, names_a_wheel
from ....measurements.files.columns.cells import numbers
from ....measurements.files.columns.content import Column, Content, is_unit, name_and_unit
from ....measurements.files.columns.resolution import choices, unit_at_end
from ....measurements.interpretation import NOT_READ
from ....measurements.terms import OWNERS, words_of
from ....measurements.units import GRAVITY, meanings, quantity_of, to_si
from ....symbolic.channels import CHANNELS, OUTPUTS
from .car_entries import example_text
from .clock import TRIED, clock_problem
from .log_channels import (
    LOG_CHANNELS,
    NEAR,
    POSITIONS,
    RADIUS_OF_KMH,
    SHORT,
    TURNED,
    UNITS,
    VERTICAL,
    lacking,
    share_of_lock,
)
from .several import several_cars

FloatArray = npt.NDArray[np.float64]
#: A column, its values, and their times; None if the file has none.
Sampled = tuple[Column, FloatArray, FloatArray | None]

#: Steps between samples, in median steps, from which they are a gap.
GAP = 5.0
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
#: Gravity by the unit that a file does not state: SI, g, mg.
GRAVITIES = {"": GRAVITY, "g": 1.0, "mg": 1000.0}
#: m: radius of a wheel of a car.
RADIUS = 0.3
#: Share by which a mean may differ from gravity, correlations that show a sign and a cause.
GRAVITY_SHARE, CLEAR, STRONG = 0.2, 0.3, 0.7
#: Channels of a turn, in which ay is speed times yaw rate, and limit of their ratio: the factors of units are further
#: apart, roll and bank of a car are within.
TURN, TURN_GAIN = ("speed", "yaw_rate", "ay"), 0.8
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


@dataclass(frozen=True)
class SurveyedColumn:
    """One column of a log.

    - `header`, `group`, `unit`: of the file; the unit is empty if it declares none.
    - `samples`: number of values; NaN and invalid ones are none. `rate`: Hz. `longest_gap`: s; 0 without one.
    - `lowest`, `highest`: in the unit of the file. `nearest`: the channel that its name suggests; empty without one.
    """

    header: str
    group: str
    unit: str
    samples: int
    rate: float
    longest_gap: float
    lowest: float
    highest: float
    nearest: str


@dataclass(frozen=True)
class Survey:
    """The columns of a log, the proposed section [columns] of a car file, and how it was decided."""

    columns: tuple[SurveyedColumn, ...]
    proposal: Mapping[str, str]
    notes: tuple[str, ...]

    @property
    def section(self) -> str:
        """The section [columns] of a car file.

        >>> print(Survey((), {"yaw_rate": "-gz [deg/s]"}, ("z points down",)).section)
        [columns]
        # z points down
        yaw_rate = "-gz [deg/s]"
        """
        lines = [f"{name} = {toml_string(text)}" for name, text in self.proposal.items()]
        return "\n".join(["[columns]", *(f"# {note}" for note in self.notes), *lines])

    def car_text(self) -> str:
        """Return a car file with this section; its numbers are examples and comments."""
        body = example_text().partition("[columns]")[0]
        lines = [f"# {line}" if line and line[0] not in "#[" else line for line in body.splitlines()]
        return "\n".join([*lines, self.section, ""])


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
        or any(_is_named(name, position) for name in names for position in POSITIONS)
    )


def nearest_channel(column: Column) -> str:
    """Return the channel of a drive that the name of a column suggests and its unit allows; empty without one.

    >>> [nearest_channel(Column("Yaw", [], unit)) for unit in ("deg/s", "deg", "bar")]
    ['yaw_rate', 'heading', '']
    >>> [nearest_channel(Column(name, [])) for name in ("AccLat_mps2", "/imu/angular_velocity/z", "field.speed")]
    ['ay', 'yaw_rate', 'speed']
    """
    return _nearest(column).channel


@dataclass(frozen=True, order=True)
class _Nearest:
    """The channel that the name of a column suggests.

    - `rank`: 0 if the name is one of the channel's, 1 if it contains one, 2 without a channel.
    - `shortness`: minus the characters of that name: of several, the longest one is meant.
    - `unit`: without brackets at the end of the name, or g within it ("G Force Lat"); empty without one.
    """

    rank: int = 2
    shortness: int = 0
    channel: str = ""
    unit: str = ""


def _nearest(column: Column) -> _Nearest:
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
                if _is_named(plain, alias) or _is_named(name, alias):
                    candidates.append(_Nearest(int(of_another), -len(alias), channel, unit))
                elif len(alias) >= SHORTEST_CONTAINED and _is_contained(_words(alias), _words(plain)):
                    candidates.append(_Nearest(1, -len(alias), channel, unit))
    return min(candidates, default=_Nearest())


def _is_named(written: str, alias: str) -> bool:
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


def survey(content: Content, source: str, columns: Mapping[str, str] | None = None) -> Survey:
    """Return what a log contains.

    `columns`: by channel, the column that the user names, as for `read_log`. Raises `DataError` if a named column does
    not exist, or the column of time is not one, and `UnknownName` for an unknown channel.
    """
    columns = {name: text for name, text in (columns or {}).items() if text != NOT_READ}
    for name in columns:
        if name not in LOG_CHANNELS:
            raise UnknownName("channel", name, LOG_CHANNELS)
    wanted = choices(content, {name: LOG_CHANNELS[name] for name in columns}, source, columns)
    named = {id(choice.column): name for name, choice in wanted.items()}
    notes: list[str] = []
    clock, clock_text = _clock(content, source, columns.get("t", ""))
    rows: list[SurveyedColumn] = []
    values: dict[str, Sampled] = {}
    best: dict[str, tuple[int, int]] = {}
    for column in content.columns:
        times = column.times if column.times is not None else clock
        data = _numbers(column, content, source)
        if data is None or (times is not None and len(data) != len(times)):
            continue
        near = _Nearest(-2, 0, named[id(column)]) if id(column) in named else _nearest(column)
        rows.append(_surveyed(column, data, times, near))
        present = data[np.isfinite(data)]
        if not len(present) and id(column) not in named:
            continue  # a sensor that the car does not have
        fit = near.rank + (len(present) == 0 or np.ptp(present) == 0.0) + (not present.any()), -len(present)
        if near.channel not in ("", "t") and fit < best.get(near.channel, (2, 0)):
            best[near.channel], values[near.channel] = fit, (column, data, times)
    gravity = _gravity(content, source)
    down = content.down or gravity.down
    if down:
        why = "by the definition of the format" if content.down else "the vertical acceleration is -g"
        notes.append(f"axes forward, right, down ({why}): channels of turning get a minus")
    proposal = {"t": clock_text} if clock_text else {}
    for name in LOG_CHANNELS:
        if name in values:
            column, data, _ = values[name]
            sign = "-" if down and name in TURNED else ""
            text = _text(column, name, data, gravity)
            if name not in columns and (units := meanings(name_and_unit(text)[1] or column.declared_unit)):
                unit, why = _meant_unit(name, units, proposal.get("speed", ""), values)
                text = f"{name_and_unit(text)[0]} [{unit}]"
                notes.append(f"{name}: the unit of {column.header.strip()} is {' or '.join(units)}: {why}")
            proposal[name] = columns.get(name) or f"{sign}{text}"
    read = [(column, data) for column, data, _ in values.values()]
    if clock is not None:
        finite = clock[np.isfinite(clock)]
        notes += filter(None, [several_cars(content, clock, read) or clock_problem(finite, clock_text)])
    copies: dict[bytes, list[str]] = {}
    for name, (_, data, _) in values.items():
        copies.setdefault(data.tobytes() if len(np.unique(data[np.isfinite(data)])) > 1 else name.encode(), []).append(
            name
        )
    notes += [f"{', '.join(names)} have the same numbers: copies of one" for names in copies.values() if len(names) > 1]
    if "steer" in values and "steer" not in columns and not is_unit(values["steer"][0].declared_unit):
        notes += filter(None, [share_of_lock(values["steer"][1])])
    notes += _agreed(proposal, values, columns)
    notes += filter(None, [_turned_as_fast(proposal, values, columns), _speeds_of_rims(proposal, values)])
    notes += [content.about["decimals"]] if "decimals" in content.about else []
    clocks = clock is not None or any(column.times is not None for column in content.columns)
    if lacks := [*([] if clocks else ["t"]), *(channel.name for channel in lacking(proposal))]:
        notes.append(f"not there, and needed for an estimate of the tires: {', '.join(lacks)}")
    changed = {name: text for name, text in proposal.items() if text != name}
    return Survey(tuple(rows), changed, tuple(notes))


def _surveyed(column: Column, values: FloatArray, times: FloatArray | None, near: _Nearest) -> SurveyedColumn:
    present = values[np.isfinite(values)]
    steps = np.diff(times[np.isfinite(values)]) if times is not None else np.empty(0)
    forward = steps[steps > 0.0]
    step = float(np.median(forward)) if len(forward) else 0.0
    gap = float(forward.max()) if len(forward) and forward.max() > GAP * step else 0.0
    low, high = (float(present.min()), float(present.max())) if len(present) else (0.0, 0.0)
    rate = 1.0 / step if step else 0.0
    unit = column.declared_unit or near.unit
    return SurveyedColumn(column.header, column.group, unit, len(present), rate, gap, low, high, near.channel)


def _numbers(column: Column, content: Content, source: str) -> FloatArray | None:
    try:
        return numbers(column.cells, source, column.header, content.location)[0]
    except TirefmuError:  # a column of texts
        return None


def _clock(content: Content, source: str, named: str) -> tuple[FloatArray | None, str]:
    """Return the times in s and how the car file names their column; nothing if each channel has its own.

    `named`: the column that the user names; empty without one.
    """
    if any(column.times is not None for column in content.columns):
        return None, ""
    header = named or next(
        (column.header for column in content.columns if column.meant == "t" or "t" in column.names), ""
    )
    if not header:
        near = next((column for column in content.columns if nearest_channel(column) == "t"), None)
        header = _with_unit(near, "t") if near else ""
    if not header:
        return None, ""
    chosen = choices(content, {"t": LOG_CHANNELS["t"]}, source, {"t": header})["t"]
    times = chosen.values(content, source)
    finite = times[np.isfinite(times)]
    if not chosen.declared and clock_problem(finite, header):
        for unit in TRIED:
            if not clock_problem(np.asarray(to_si(finite, unit)), header):
                return np.asarray(to_si(times, unit)), f"{header} [{unit}]"
    return times, header


@dataclass(frozen=True)
class _Gravity:
    """What the mean of a vertical acceleration shows.

    - `unit`: of the accelerations of its group; empty for SI, and if unknown.
    - `group`: of its column. `down`: whether z points down.
    """

    unit: str = ""
    group: str = ""
    down: bool = False


def _gravity(content: Content, source: str) -> _Gravity:
    for column in content.columns:
        name = name_and_unit(column.header)[0]
        vertical = any(_is_named(name, alias) for alias in VERTICAL)
        values = _numbers(column, content, source) if vertical else None
        if values is not None and np.isfinite(values).any():
            mean = float(np.nanmean(values))
            for unit, size in GRAVITIES.items():
                if abs(abs(mean) / size - 1.0) < GRAVITY_SHARE:
                    return _Gravity(unit, column.group, mean < 0.0)
            return _Gravity()
    return _Gravity()


def _with_unit(column: Column, name: str) -> str:
    """Return how a car file names the column of a channel, with the unit that its name has without brackets."""
    header = f"{column.group}/{column.header}" if column.group and "/" not in column.header else column.header
    if is_unit(column.declared_unit):
        return header
    near = _nearest(column)
    unit = near.unit if near.channel == name else unit_at_end(column.header, LOG_CHANNELS[name].quantity)[1]
    return f"{header} [{unit}]" if unit else header


def _text(column: Column, name: str, values: FloatArray, gravity: _Gravity) -> str:
    """Return how a car file names a column, with the unit that its numbers suggest if the file states none.

    g cannot be distinguished from a gentle drive in m/s^2, except by the vertical acceleration of the same sensor.
    """
    header = _with_unit(column, name)
    if is_unit(name_and_unit(header)[1] or column.declared_unit) or not np.isfinite(values).any():
        return header
    size = float(np.nanquantile(np.abs(values), 0.99))
    if LOG_CHANNELS[name].quantity == "acceleration":
        shown = gravity.unit and gravity.group == column.group and to_si(size, gravity.unit) < LOG_CHANNELS[name].limit
        return f"{header} [{gravity.unit}]" if shown else header
    degrees = {"angle": ("deg", 3.5 if name == "steer" else 1.6), "rotation": ("deg/s", LOG_CHANNELS[name].limit)}
    unit, most = degrees.get(LOG_CHANNELS[name].quantity, ("", np.inf))
    return f"{header} [{unit}]" if size > most and name != "heading" else header


def _meant_unit(name: str, units: Sequence[str], speed: str, values: Mapping[str, Sampled]) -> tuple[str, str]:
    """Return which of the units of an ambiguous spelling a rotation has, and why.

    The first one, but for a wheel whose radius follows from the speed. `speed`: how the car file names its column.
    """
    if name not in OF_A_CAR - {"yaw_rate"} or not speed:
        return units[0], f"{units[0]} in most logs, which its numbers do not show"
    radius = _radius(name, speed, values)
    radii = {unit: radius / float(to_si(1.0, unit)) for unit in units}
    nearest = min(units, key=lambda unit: abs(np.log(radii[unit] / RADIUS)))
    return nearest, "wheels of " + " or ".join(f"{radius:.2g} m ({unit})" for unit, radius in radii.items())


def _radius(name: str, speed: str, values: Mapping[str, Sampled]) -> float:
    """Return the radius of a wheel whose spin is in rad/s, m; infinite if it does not turn."""
    column, data, _ = values["speed"]
    unit = name_and_unit(speed)[1] or column.declared_unit
    forward = float(np.nanmedian(np.abs(to_si(data, unit) if is_unit(unit) else data)))
    spin = float(np.nanmedian(np.abs(values[name][1])))
    return forward / spin if spin else np.inf


def _speeds_of_rims(proposal: Mapping[str, str], values: Mapping[str, Sampled]) -> str:
    """Return that spins without a unit have the numbers of the speed in m/s or km/h; empty if they have not."""
    for unit, radius in (("m/s", 1.0), ("km/h", RADIUS_OF_KMH)):
        like = [
            name
            for name in LOG_CHANNELS
            if name in OF_A_CAR - {"yaw_rate"} and {name, "speed"} <= values.keys()
            if not _stated_unit(name, proposal, values)
            and abs(_radius(name, proposal["speed"], values) / radius - 1.0) < NEAR
        ]
        if like:
            wheels = f"wheels of {radius:.3g} m in rad/s, or speeds in {unit}, which are not read: state the unit"
            return f"{', '.join(like)}: {wheels}"
    return ""


def _stated_unit(name: str, proposal: Mapping[str, str], values: Mapping[str, Sampled]) -> str:
    """Return the unit of a channel that its file or the proposal states; empty without one."""
    stated = name_and_unit(proposal[name])[1] or values[name][0].declared_unit
    return stated if is_unit(stated) else ""


def _turned_as_fast(proposal: dict[str, str], values: Mapping[str, Sampled], named: Collection[str]) -> str:
    """Return that ay is not speed times yaw rate, and propose the units with which it is; empty if it is.

    Units that file or user state are kept. Those of logs differ by factors that the law tells apart.
    """
    if not set(TURN) <= values.keys():
        return ""
    stated = {name: _stated_unit(name, proposal, values) for name in TURN}
    free = {name: ("",) if name in named or stated[name] else UNITS[name] for name in TURN}
    units_read = {name: stated[name] or UNITS[name][0] for name in TURN}
    sampled = _at_the_times(values["yaw_rate"], *(values[name] for name in units_read))
    in_si = {name: to_si(data, unit) for (name, unit), data in zip(units_read.items(), sampled, strict=True)}
    turn, ay = in_si["speed"] * in_si["yaw_rate"], in_si["ay"]
    if abs(turn @ ay) <= STRONG * float(np.sqrt((turn @ turn) * (ay @ ay))):
        return ""
    gain = abs(float(turn @ ay) / float(turn @ turn))
    factors = {}
    for units in product(*free.values()):
        changed = {name: unit for name, unit in zip(free, units, strict=True) if unit and unit != units_read[name]}
        sizes = {name: float(to_si(1.0, changed.get(name, "1"))) for name in TURN}
        factors[sizes["speed"] * sizes["yaw_rate"] / sizes["ay"]] = changed
    factor = min(factors, key=lambda factor: abs(np.log(gain / factor)))
    if not TURN_GAIN < gain / factor < 1.0 / TURN_GAIN:
        return f"ay is {gain:.2g} times speed times yaw rate: another unit of one of them, or another channel?"
    for name, unit in factors[factor].items():
        proposal[name] = f"{proposal[name]} [{unit}]"
    changes = " and ".join(f"{name} in {unit}" for name, unit in factors[factor].items())
    return f"ay is speed times yaw rate with {changes}" if changes else ""


def _agreed(proposal: dict[str, str], values: dict[str, Sampled], named: Collection[str]) -> Sequence[str]:
    """Exchange ax and ay, and turn signs, so that steering, yaw rate and lateral acceleration agree.

    In a turn of a car that moves forward all three have one sign: the one that differs from the two others is turned.
    What the user names stays as it is.
    """
    if "yaw_rate" not in values:
        return ["no yaw rate: signs are not compared"]
    notes = []
    common = {name: _correlation(values["yaw_rate"], values[name]) for name in ("steer", "ax", "ay") if name in values}
    swapped = abs(common.get("ax", 0.0)) > STRONG and abs(common.get("ay", 1.0)) < CLEAR
    if swapped and not {"ax", "ay"} & set(named):
        proposal["ax"], proposal["ay"] = proposal["ay"], proposal["ax"]
        common["ax"], common["ay"] = common["ay"], common["ax"]
        notes.append("ax follows the yaw rate and ay does not: they are exchanged")
    signs = {name: -1.0 if proposal[name].startswith("-") else 1.0 for name in ("yaw_rate", *common)}
    agree = {name: np.sign(common[name] * signs[name] * signs["yaw_rate"]) for name in ("steer", "ay")
             if abs(common.get(name, 0.0)) > CLEAR}  # fmt: skip
    wrong = [name for name, sign in agree.items() if sign < 0.0]
    for name in ["yaw_rate"] if len(wrong) == 2 else wrong:
        if name not in named:
            proposal[name] = proposal[name][1:] if signs[name] < 0.0 else f"-{proposal[name]}"
        notes.append(f"{name} has the other sign than the rest{'' if name in named else ': it is turned'}")
    return notes


def _correlation(first: Sampled, second: Sampled) -> float:
    """Return the correlation of two channels about zero; 0 if their samples cannot be compared."""
    x, y = _at_the_times(first, first, second)
    size = float(np.sqrt((x @ x) * (y @ y)))
    return float(x @ y) / size if size else 0.0


def _at_the_times(of: Sampled, *channels: Sampled) -> list[FloatArray]:
    """Return the values of channels at the times of one where all are there; none if they cannot be compared."""
    (_, reference, times) = of
    rows = []
    for _, values, sampled in channels:
        usable = np.isfinite(values)
        if sampled is not None and times is not None and usable.any():
            values = np.interp(times, sampled[usable], values[usable])
        rows.append(values if len(values) == len(reference) else np.full(len(reference), np.nan))
    there = np.isfinite(rows).all(axis=0)
    return [values[there] for values in rows]


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
