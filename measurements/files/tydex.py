"""Recordings in TYDEX, the tire data exchange format (TYDEX Workshop, release 1.3, 1997)."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...boundary.errors import DataError
from ...numerics.arrays import FloatArray
from .columns.cells import has_decimal_commas, is_number, number_of, numbers, rows_of_cells, with_point
from .columns.content import DECIMAL_COMMAS, Column, Content, is_unit
from .columns.layout import SAMPLED
from .encoding import encoding_of

#: TYDEX names by contract name, the preferred one first. H axes are parallel to the W axes (contact point) on a flat
#: road: their forces are equal. Their moments need the loaded radius and are not read.
NAMES: Mapping[str, tuple[str, ...]] = {
    "t": ("RUNTIME",),
    "kappa": ("LONGSLIP",),
    "alpha": ("SLIPANGL",),
    "gamma": ("INCLANGL",),
    "Fz": ("FZW", "FZH"),
    "p": ("INFLPRES",),
    "V": ("TRAJVELW", "TRAJVELH", "LONGVEL"),
    "Fx": ("FXW", "FXH"),
    "Fy": ("FYW", "FYH"),
    "Mz": ("MZW",),
    "Mx": ("MXW",),
    "My": ("MYW",),
}
#: Characters of a field: its keyword and each number; where the unit of a quantity is, by the definition of the format.
FIELD, UNIT = 10, slice(40, 50)


@dataclass(frozen=True)
class _Quantity:
    """One line of a TYDEX section: a channel, or a constant with its value."""

    name: str
    unit: str
    numbers: tuple[float, ...]
    line: int

    def physical(self, raw: FloatArray) -> FloatArray:
        """Return the measured numbers in the declared unit: (raw + offset) * factor + physical offset."""
        factor, offset, shift = (*self.numbers, *(1.0, 0.0, 0.0)[len(self.numbers) :])
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused with its line
            return (raw + offset) * factor + shift


def read_tydex(path: Path) -> Content:
    """Return the content of a TYDEX file; a constant of the file is a channel with the same value in every row.

    TYDEX defines its axes as iso. Raises `DataError` if a section is missing, a channel occurs twice, or a row has more
    or fewer cells than there are channels (with the line).
    """
    source = str(path)
    with path.open(encoding=encoding_of(path)) as file:
        sections, count = _sections(file.read().splitlines())
    for name in ("MEASURCHANNELS", "MEASURDATA"):
        if name not in sections:
            raise DataError(f"{source}: no section **{name}: not a TYDEX file")
    rows, declared = sections["MEASURDATA"], [*sections["MEASURCHANNELS"], *sections.get("CONSTANTS", ())]
    commas = has_decimal_commas(text.split() for _, text in (*declared, *rows[:SAMPLED]))
    channels = [_quantity(number, text, 3, commas) for number, text in sections["MEASURCHANNELS"]]
    constants = [_quantity(number, text, 1, commas) for number, text in sections.get("CONSTANTS", ())]
    for given in (channels, constants):
        for name, occurrences in Counter(quantity.name for quantity in given).items():
            if occurrences > 1 and any(name in spelled for spelled in NAMES.values()):
                raise DataError(f"{source}: {name} occurs {occurrences} times")
    names = [quantity.name for quantity in channels]
    cells = rows_of_cells(((line, _cells(text, len(names))) for line, text in rows), names, source, commas=commas)

    def location(row: int) -> str:
        return f"line {rows[row][0]}"

    columns = list(_columns(channels, constants, cells, source, location))
    present = {column.header for column in columns}
    axes = "; forces in the axes C are not read" if "FZC" in present else ""
    moments = sorted(present & {"MXH", "MYH", "MZH", "MXC", "MYC", "MZC"})
    ignored = [f"moments {', '.join(moments)}, of other axes than W"] if moments else []
    if count not in (None, len(rows)):
        ignored.append(f"the number of rows {count} behind **MEASURDATA: the file has {len(rows)}")
    header = dict(text.split(maxsplit=1) for _, text in sections.get("HEADER", ()) if len(text.split()) > 1)
    about = {"units": "declared in the file", "tireid": "", "credit": "", "testid": header.get("MEASID", "").strip()}
    about |= DECIMAL_COMMAS if commas else {}
    lacking = {"Fz": f"no channel FZW (Fz){axes}"}
    return Content(tuple(columns), location, "tydex", "iso", about=about, lacking=lacking, ignored=tuple(ignored))


def _columns(
    channels: Sequence[_Quantity], constants: Sequence[_Quantity], cells: Any, source: str, location: Any
) -> Iterator[Column]:
    """Yield the measured channels, and the constants that no channel measures."""
    held = {quantity.name: quantity for quantity in constants if quantity.numbers}
    measured = {quantity.name for quantity in channels}
    meant: dict[str, str] = {}
    for name, spelled in NAMES.items():
        for given in (measured, held):
            for spelling in spelled:
                if spelling in given and name not in meant.values():
                    meant[spelling] = name
    for i, quantity in enumerate(channels):
        label = f"channel {quantity.name}"
        column = cells[:, i]
        if quantity.numbers not in ((), (1.0,), (1.0, 0.0), (1.0, 0.0, 0.0)) and quantity.name in meant:
            column = quantity.physical(numbers(column, source, label, location)[0])
        place = f"line {quantity.line}: {label}"
        yield Column(quantity.name, column, quantity.unit, meant.get(quantity.name, ""), place=place)
    for name, quantity in held.items():
        if name not in measured:
            column, place = np.full(len(cells), quantity.numbers[0]), f"line {quantity.line}: channel {name}"
            yield Column(name, column, quantity.unit, meant.get(name, ""), place=place)


def _sections(lines: Sequence[str]) -> tuple[dict[str, list[tuple[int, str]]], int | None]:
    """Return line numbers and texts by section without comments and blank lines, and the declared number of rows."""
    sections: dict[str, list[tuple[int, str]]] = {}
    current: list[tuple[int, str]] = []
    count = None
    for number, line in enumerate(lines, start=1):
        if line.startswith("**"):
            name, *rest = line.strip("* ").upper().split() or [""]
            current = sections.setdefault(name, [])
            if name == "MEASURDATA" and rest and rest[0].isdigit():
                count = int(rest[0])
        elif line.strip() and not line.startswith("!"):
            current.append((number, line.rstrip()))
    return sections, count


def _cells(text: str, count: int) -> list[str]:
    """Return the cells of a row: separated by blanks, or in fields of ten characters, which may touch or be blank."""
    cells = text.split()
    if len(cells) != count and FIELD * (count - 1) < len(text) <= FIELD * count:
        cells = [text[i : i + FIELD].strip() for i in range(0, FIELD * count, FIELD)]
    return cells


def _quantity(line: int, text: str, most: int, commas: bool) -> _Quantity:
    """Read name, description, unit and up to ``most`` numbers. The unit is in its field, or follows the description.

    `commas`: whether numbers have decimal commas.
    """
    if commas:
        text = re.sub(r"\S+", lambda word: with_point(word[0]), text)  # the fields keep their places
    fixed = text[UNIT].strip()
    if len(text) > UNIT.start and text[FIELD - 1 : FIELD].isspace() and (not fixed or fixed == "-" or is_unit(fixed)):
        behind = text[UNIT.stop :].split()
        if behind and all(map(is_number, behind)) and np.isfinite(list(map(number_of, behind))).all():
            return _Quantity(text[:FIELD].strip(), fixed, tuple(map(number_of, behind[:most])), line)
    name, *words = text.split()
    given: list[float] = []
    while words and len(given) < most and is_number(words[-1]) and np.isfinite(number_of(words[-1])):
        given.insert(0, number_of(words.pop()))
    # A description may end in a word like "N". Only units of temperature have two words.
    two = " ".join(words[-2:])
    unit = two if len(words) > 1 and words[-2].casefold() == "deg" and is_unit(two) else words[-1] if words else "-"
    return _Quantity(name, unit, tuple(given), line)
