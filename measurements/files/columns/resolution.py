"""Which column of a file is which channel, in which unit and with which sign, for all files and commands."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ....boundary.errors import DataError, TirefmuError, UnknownName, nearest
from ....boundary.escaping import quoted
from ....numerics.arrays import FloatArray
from ...interpretation import NOT_READ
from ...terms import without_qualifiers
from ...units import meanings, quantity_of, to_si, unit_named
from .cells import numbers
from .content import LONGEST_HEADER, MAX_COLUMNS, WORD_BEGINS, Column, Content, is_unit, listed, name_and_unit

#: Formats that define what their columns are; the names of others count.
DEFINED = ("ttc", "tydex")
#: Quantities that benches do not measure in SI units: without a declared unit a name of theirs may be meant either way.
_BENCH_UNITS = ("angle", "pressure", "speed")


class Declared(Protocol):
    """The declaration of a channel: of a bench (`Channel`) or of a drive."""

    @property
    def name(self) -> str:
        """The name of the channel."""

    @property
    def quantity(self) -> str:
        """Its physical quantity."""


@dataclass(frozen=True, eq=False)
class ColumnChoice:
    """The column of a channel.

    - `name`, `quantity`: of the channel.
    - `column`, `sign`: the column, and -1 if its numbers have the other sign.
    - `unit`: of its numbers; empty for SI. `declared`, `stated`: whether file or user, or the user, declares it.
    """

    name: str
    quantity: str
    column: Column
    sign: float
    unit: str
    declared: bool
    stated: bool

    def place(self, source: str) -> str:
        """Return file and column, for a message."""
        return f"{source}: {self.column.place or f'column {name_and_unit(self.column.header)[0]}'}"

    def values(self, content: Content, source: str) -> FloatArray:
        """Return the numbers in SI units; raises `DataError` if a cell is no number, or the unit is another one's."""
        if self.column.axis:
            raise DataError(f"{self.place(source)}: its samples are at values of {self.column.axis}, not of time")
        label = self.place(source).rpartition(": ")[2]
        clock = self.quantity == "time"
        cells, seconds = numbers(self.column.cells, source, label, content.location, clock=clock)
        unit = "s" if seconds else self.unit
        values = _in_si(cells, unit, self.quantity, self.place(source)) if unit else cells
        return -values if self.sign < 0.0 else values


def choices(
    content: Content,
    declarations: Mapping[str, Declared],
    source: str,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> dict[str, ColumnChoice]:
    """Return the column of each channel that a file has.

    `declarations`: by name. `columns`: by channel, what the user names: ``HEADER``, ``-HEADER``, ``HEADER [unit]``,
    ``GROUP/HEADER``, another channel, or ``none``. `units`: by channel, units that replace those of the file. Raises
    `UnknownName` for an unknown channel, and `DataError` if a named column does not exist or several are meant.
    """
    if len(content.columns) > MAX_COLUMNS:
        raise DataError(f"{source}: {len(content.columns)} columns: at most {MAX_COLUMNS} are read")
    columns, units = columns or {}, units or {}
    for name in (*columns, *units):
        if name not in declarations:
            raise UnknownName("channel", name, declarations)
    chosen: dict[str, ColumnChoice] = {}
    for name, declared in declarations.items():
        wanted = columns.get(name)
        if wanted == NOT_READ:
            continue
        sign, unit = 1.0, units.get(name, "")
        if wanted is None:
            matches = _by_default(content, declared)
        else:
            matches, sign, written = _named(content, declarations, wanted)
            unit = unit or written
            if not matches:
                headers = [column.header for column in content.columns]
                raise DataError(f"{source}: no column {quoted(wanted)} ({name}){nearest(wanted, headers)}")
        if len(matches) > 1:
            raise DataError(_several(matches, name, source))
        if matches:
            column = matches[0]
            stated = bool(unit) or wanted == name
            text_of_unit = unit or column.declared_unit
            if wanted is not None and not unit and not column.unit and not is_unit(text_of_unit):
                text_of_unit = ""  # the brackets of a header that is named whole may be an index
            if wanted is not None and not text_of_unit and name not in content.units:
                _refuse_unit_in_name(column.header, declared, source)
            chosen[name] = ColumnChoice(
                name,
                declared.quantity,
                column,
                sign,
                text_of_unit or content.units.get(name, ""),
                bool(text_of_unit),
                stated,
            )
    for name in units:
        if name not in chosen:
            raise DataError(f"{source}: no column {name!r}, whose unit is given as {units[name]}")
    return chosen


def unit_at_end(header: str, quantity: str = "") -> tuple[str, str]:
    """Return name and unit of a header that ends in a unit of a quantity without brackets; otherwise the header and "".

    `quantity`: empty for a unit of any.

    Words of a sensor or of a filter may be behind the unit.

    >>> unit_at_end("wheel_deg", "angle"), unit_at_end("ay_m_s2_raw", "acceleration"), unit_at_end("steer_in", "angle")
    (('wheel', 'deg'), ('ay', 'm_s2'), ('steer_in', ''))
    """
    core = without_qualifiers(header[:LONGEST_HEADER])
    for begin in WORD_BEGINS.finditer(core):
        written = core[begin.start() :]
        for unit in (written, written.replace("_", "/")):
            if is_unit(unit) and quantity in ("", quantity_of(unit)):
                return core[: begin.start()].rstrip(" _.,:;"), unit
    return header, ""


def _refuse_unit_in_name(header: str, declared: Declared, source: str) -> None:
    """Refuse a header that is named without a unit and ends in one, such as ``wheel_deg``: its numbers count as SI."""
    name = header.strip()
    written = unit_at_end(name, declared.quantity)[1]
    units = meanings(written) or ((written,) if written else ())
    if any((unit_named(unit).factor, unit_named(unit).offset) != (1.0, 0.0) for unit in units):
        options = " or ".join(quoted(f"{declared.name}={name} [{unit}]") for unit in units)
        raise DataError(
            f"{source}: column {quoted(name)} ({declared.name}): the unit in its name is not read: state it: "
            f"--columns {options}"
        )


def _by_default(content: Content, declared: Declared) -> Sequence[Column]:
    """Return the columns that are a channel by the format, its name, or its name at benches if its unit is clear."""
    meant = [column for column in content.columns if column.meant == declared.name]
    if meant or content.format in DEFINED:
        return meant
    if named := [column for column in content.columns if declared.name in column.names]:
        return named
    bench = getattr(declared, "bench_names", ()) if getattr(declared, "role", "") == "input" else ()
    clear = declared.quantity not in _BENCH_UNITS
    return [
        column
        for column in content.columns
        if name_and_unit(column.header)[0] in bench and (clear or column.declared_unit)
    ]


def _named(content: Content, declarations: Mapping[str, Declared], wanted: str) -> tuple[Sequence[Column], float, str]:
    """Return the columns that the text of a user names, the sign, and the unit in the text."""
    for text, sign in ((wanted, 1.0), (wanted[1:].strip(), -1.0)) if wanted.startswith("-") else ((wanted, 1.0),):
        name, unit = name_and_unit(text)
        for written, declared in ((text, ""), (name, unit or "")):
            for fold in (str, str.casefold):
                if matches := _with_name(content, written, fold):
                    return matches, sign, declared
            if written in declarations and (matches := _by_default(content, declarations[written])):
                return matches, sign, declared
    return (), 1.0, ""


def _with_name(content: Content, written: str, fold: Callable[[str], str]) -> Sequence[Column]:
    """Return the columns with a whole header, otherwise those with a name without unit."""
    wanted = fold(written)
    whole = [column for column in content.columns if fold(column.header.strip()) == wanted]
    return whole or [column for column in content.columns if wanted in map(fold, column.names)]


def _several(matches: Sequence[Column], name: str, source: str) -> str:
    header = name_and_unit(matches[0].header)[0]
    options = [f"{name}={column.group}/{header}" for column in matches if column.group]
    choose = f": name one: --columns {' or '.join(map(quoted, options[:3]))}" if len(set(options)) > 1 else ""
    return f"{source}: column {name!r} occurs {len(matches)} times{choose}"


def _in_si(values: FloatArray, unit: str, quantity: str, place: str) -> FloatArray:
    try:
        return to_si(values, unit, quantity)
    except TirefmuError as error:
        raise DataError(f"{place}: {error}") from None


def common_clock(chosen: Mapping[str, ColumnChoice], source: str) -> FloatArray | None:
    """Return the times that all chosen columns share; None if they have none of their own.

    Raises `DataError` if they have different ones: the rows of a table belong together.
    """
    clocks = {name: choice.column.times for name, choice in chosen.items() if choice.column.times is not None}
    if not clocks:
        return None
    first, times = next(iter(clocks.items()))
    for name, other in clocks.items():
        if not np.array_equal(times, other):
            raise DataError(
                f"{source}: {first} has {len(times)} samples and {name} {len(other)}, at other times: "
                "export the channels with one time base"
            )
    return times


def ignored_columns(content: Content, chosen: Mapping[str, ColumnChoice]) -> str:
    """Return what of a file is not read, in one line; empty if all of it is."""
    used = {id(choice.column) for choice in chosen.values()}
    others = sorted(column.header for column in content.columns if id(column) not in used and column.header.strip())
    parts = [f"columns {listed(others)}"] if others else []
    return "; ".join([*parts, *content.ignored])
