"""What a reader returns: the columns of a file as it stores them, with units and times, before any conversion."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ....boundary.escaping import quoted
from ....numerics.arrays import FloatArray
from ...units import UNITS, find_unit
from .cells import is_number

#: Upper limits: columns of a table, characters of a header that may declare a unit.
MAX_COLUMNS, LONGEST_HEADER = 20_000, 200
#: Metadata of a file whose numbers have decimal commas.
DECIMAL_COMMAS: Mapping[str, str] = {"decimals": "commas in numbers are read as decimal points"}
#: Where a last word of a header may begin: ``wheel_deg``, ``Yaw deg/s``, ``SlipDeg``.
WORD_BEGINS = re.compile(r"(?:(?<=[\s_.,:;])|(?<=[a-z])(?=[A-Z]))(?=[^\W\d_]|°)")
#: Ignored parts of one kind that are listed by name.
MAX_LISTED = 8
_HEADER = re.compile(r"(?P<name>.*\S)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))")

_INDEX = re.compile(r"\S\[\d+\]$")
#: A unit behind a name: "Fz/N", "alpha / deg", "Fz, N", "Fz in N".
_BEHIND = re.compile(r"(?P<name>[^/,\s\[({][^/,\[({]*?)(?:\s*[/,]\s*|\s+in\s+)(?P<unit>\S.*)")
#: A unit at another place of a header.
_ELSEWHERE = re.compile(r"\[(?P<square>[^\[\]]*[^\[\]\d]+)\]|\{(?P<curly>[^{}]*[^{}\d]+)\}")


@dataclass(frozen=True, eq=False)
class Column:
    """One column of a file.

    - `header`: its name in the file; it may contain a unit (``alpha [deg]``).
    - `cells`, shape (n,): array or Series of any type; what the file marks as invalid is NaN.
    - `unit`: unit that the file declares elsewhere: row of units, metadata; empty without one.
    - `meant`: channel that the format defines the column to be.
    - `group`: what distinguishes columns of one name: group of channels, structure, topic.
    - `times`, shape (n,): its own times, s; None if the column t has them.
    - `axis`: what its times are if they are not times, such as "angle (deg)".
    - `place`: of its declaration, for messages: "line 15: channel FZW".
    """

    header: str
    cells: Any
    unit: str = ""
    meant: str = ""
    group: str = ""
    times: FloatArray | None = None
    axis: str = ""
    place: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """The header, and without the unit that it declares; each also behind its group."""
        plain = dict.fromkeys((self.header, name_and_unit(self.header)[0]))
        return (*plain, *(f"{self.group}/{name}" for name in plain if self.group))

    @property
    def declared_unit(self) -> str:
        """The unit that the file declares; empty without one."""
        return self.unit or name_and_unit(self.header)[1] or ""


def row_number(row: int) -> str:
    """Return the place of a row in a table without lines.

    >>> row_number(0)
    'row 1'
    """
    return f"row {row + 1}"


@dataclass(frozen=True, eq=False)
class Content:
    """The columns of a file.

    - `location`: from the number of a row, counted from 0, to "line 12" or "row 12" for messages.
    - `format`: "" for a table, whose other columns are passed through; "ttc", "tydex", or that of a log.
    - `signs`: convention that the file states or its names imply; empty without one.
    - `units`: by channel, the unit of a column that declares none; SI for others.
    - `about`: metadata of a recording (`Recording.about`).
    - `lacking`: by channel, why the format cannot give it.
    - `ignored`: what of the file is not read: sheets, groups, rows, texts.
    - `down`: whether the axes of a log are forward, right, down by the definition of its format.
    """

    columns: tuple[Column, ...]
    location: Callable[[int], str] = row_number
    format: str = ""
    signs: str = ""
    units: Mapping[str, str] = field(default_factory=dict)
    about: Mapping[str, str] = field(default_factory=dict)
    lacking: Mapping[str, str] = field(default_factory=dict)
    ignored: tuple[str, ...] = ()
    down: bool = False


def name_and_unit(header: str) -> tuple[str, str | None]:
    """Return the name of a header, and the unit behind it: in brackets, or behind a slash, a comma or "in".

    Only square brackets at the end declare a unit that is not known; a number without a blank before its bracket is an
    index.

    >>> name_and_unit("alpha [deg]"), name_and_unit("V (km/h)"), name_and_unit("W (IMU)"), name_and_unit("gyro[2]")
    (('alpha', 'deg'), ('V', 'km/h'), ('W (IMU)', None), ('gyro[2]', None))
    >>> name_and_unit("[km/h] V"), name_and_unit("V [km/h] CAN1"), name_and_unit("p {kPa}")
    (('V', 'km/h'), ('V CAN1', 'km/h'), ('p', 'kPa'))
    >>> name_and_unit("Fz/N"), name_and_unit("V / (km/h)"), name_and_unit("alpha in deg"), name_and_unit("run2/FZ")
    (('Fz', 'N'), ('V', 'km/h'), ('alpha', 'deg'), ('run2/FZ', None))
    """
    header = header.strip()
    behind = _BEHIND.fullmatch(header) if len(header) <= LONGEST_HEADER else None
    if behind is not None and is_unit(behind["unit"]) and not is_number(behind["unit"]):
        begins = (0, *(begin.start() for begin in WORD_BEGINS.finditer(behind["name"])))
        if not any(is_unit(header[begin:]) for begin in begins):  # the slash of speed_km/h is one of its unit
            return behind["name"], behind["unit"].strip(" ()[]")
    match = _HEADER.fullmatch(header) if len(header) <= LONGEST_HEADER else None
    if match is None or (match["square"] is None and not is_unit(match["round"])) or _INDEX.search(header):
        units = [unit for unit in _ELSEWHERE.finditer(header[:LONGEST_HEADER]) if is_unit(unit[0][1:-1])]
        if len(units) != 1 or _INDEX.search(header):
            return header, None
        (unit,) = units
        name = " ".join(f"{header[: unit.start()]} {header[unit.end() :]}".split())
        return (name, unit[0][1:-1].strip()) if name else (header, None)
    return match["name"], (match["square"] if match["square"] is not None else match["round"]).strip()


def names_of(content: Content) -> str:
    """Return in words what the columns of a file are named, for a message that none of them is meant.

    A first row of numbers in the place of the names, but for one date, is none.
    """
    headers = [column.header.strip() for column in content.columns]
    if not headers:
        return "it has no columns of numbers"
    if sum(map(is_number, headers)) >= max(1, len(headers) - 1):
        return "its first row has numbers and no names: write a row of names above it"
    only = ": columns are separated by commas, semicolons or tabs" if len(headers) == 1 else ""
    return f"it has {quoted(listed(headers))}{only}"


def is_unit(spelling: str) -> bool:
    """Return whether a text is the spelling of a unit.

    >>> is_unit("deg/s"), is_unit("IMU"), is_unit("")
    (True, False, False)
    """
    unit = find_unit(spelling)
    return unit is not None and unit is not UNITS[""]


def listed(names: list[str]) -> str:
    """Return names in one line, the number of further ones in place of them.

    >>> listed(["a", "b"])
    'a, b'
    """
    more = f" and {len(names) - MAX_LISTED} more" if len(names) > MAX_LISTED else ""
    return ", ".join(names[:MAX_LISTED]) + more


def masked(values: Any, invalid: Any) -> FloatArray:
    """Return numbers with NaN where they are invalid."""
    return np.where(invalid, np.nan, np.asarray(values, dtype=np.float64))
