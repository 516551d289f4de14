"""Recordings in TYDEX, the tire data exchange format (TYDEX Workshop, release 1.3, 1997)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from ...boundary.errors import DataError, UnknownName, nearest
from ...numerics.arrays import FloatArray
from ..channels import CHANNELS
from ..interpretation import Interpretation
from ..recording import Recording
from ..units import unit_named
from .columns import check_finite, in_si, is_number, rows_of_numbers

#: TYDEX names by contract name, the preferred one first. Only forces in the W axes (contact point) are read.
NAMES: Mapping[str, tuple[str, ...]] = {
    "t": ("RUNTIME",),
    "kappa": ("LONGSLIP",),
    "alpha": ("SLIPANGL",),
    "gamma": ("INCLANGL",),
    "Fz": ("FZW",),
    "p": ("INFLPRES",),
    "V": ("TRAJVELW", "TRAJVELH", "LONGVEL"),
    "Fx": ("FXW",),
    "Fy": ("FYW",),
    "Mz": ("MZW",),
    "Mx": ("MXW",),
    "My": ("MYW",),
}
_OTHER_AXES = {"FZH": "H", "FZC": "C"}


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


def read_tydex(path: Path, signs: str, interpretation: Interpretation) -> Recording:
    """Read a TYDEX file.

    TYDEX defines its W axes as iso. A constant of the file is a channel with the same value in every row. Raises
    `DataError` if a section or the load in the W axes is missing, a channel occurs twice, a row has more or fewer cells
    than there are channels, a cell is not a number, or a unit is unknown (with the line).
    """
    source = str(path)
    with path.open(encoding="latin-1") as file:
        sections = _sections(file.read().splitlines())
    for name in ("MEASURCHANNELS", "MEASURDATA"):
        if name not in sections:
            raise DataError(f"{source}: no section **{name}: not a TYDEX file")
    channels = [_quantity(number, text, 3) for number, text in sections["MEASURCHANNELS"]]
    constants = [_quantity(number, text, 1) for number, text in sections.get("CONSTANTS", ())]
    for given in (channels, constants):
        for name, count in Counter(quantity.name for quantity in given).items():
            if count > 1 and any(name in spelled for spelled in NAMES.values()):
                raise DataError(f"{source}: {name} occurs {count} times")
    rows = sections["MEASURDATA"]
    cells = ((line, text.split()) for line, text in rows)
    table = rows_of_numbers(cells, [quantity.name for quantity in channels], source)
    measured = {quantity.name: (quantity, column) for quantity, column in zip(channels, table.T, strict=True)}
    held = {quantity.name: quantity for quantity in constants if quantity.numbers}
    columns: dict[str, FloatArray] = {}
    about: dict[str, str] = {}
    replaced = {channel: (name,) for name, channel in interpretation.renamed.items()}
    for name, spelled in {**NAMES, **replaced}.items():
        spelling = next((spelling for given in (measured, held) for spelling in spelled if spelling in given), "")
        if spelling:
            about[f"unit of {name}"] = (measured[spelling][0] if spelling in measured else held[spelling]).unit
        if spelling in measured:
            quantity, raw = measured[spelling]
            columns[name] = _converted(name, quantity, quantity.physical(raw), rows, source)
        elif spelling:
            quantity = held[spelling]
            columns[name] = _converted(name, quantity, np.full(len(rows), quantity.numbers[0]), rows, source)
        elif name in replaced:
            raise DataError(f"{source}: no channel {spelled[0]} ({name}){nearest(spelled[0], [*measured, *held])}")
    if "Fz" not in columns:
        axes = next((axes for name, axes in _OTHER_AXES.items() if name in measured or name in held), None)
        raise DataError(f"{source}: no channel FZW (Fz){f': forces in the axes {axes} are not read' if axes else ''}")
    header = dict(text.split(maxsplit=1) for _, text in sections.get("HEADER", ()) if len(text.split()) > 1)
    about |= {"units": "declared in the file", "declared": " ".join(columns), "tireid": "", "credit": ""}
    return Recording(pd.DataFrame(columns), signs, path.name, {**about, "testid": header.get("MEASID", "").strip()})


def _sections(lines: Sequence[str]) -> dict[str, list[tuple[int, str]]]:
    """Return line numbers and texts by section, without comments and blank lines."""
    sections: dict[str, list[tuple[int, str]]] = {}
    current: list[tuple[int, str]] = []
    for number, line in enumerate(lines, start=1):
        text = line.strip()
        if text.startswith("**"):
            current = sections.setdefault(text.strip("* ").upper(), [])
        elif text and not text.startswith("!"):
            current.append((number, text))
    return sections


def _quantity(line: int, text: str, most: int) -> _Quantity:
    """Read name, description, unit and up to ``most`` numbers. The unit follows the description."""
    name, *words = text.split()
    numbers: list[float] = []
    while words and len(numbers) < most and is_number(words[-1]) and np.isfinite(float(words[-1])):
        numbers.insert(0, float(words.pop()))
    # A description may end in a word like "N". Only units of temperature have two words.
    two = " ".join(words[-2:])
    unit = two if len(words) > 1 and words[-2].casefold() == "deg" and _is_unit(two) else words[-1] if words else "-"
    return _Quantity(name, unit, tuple(numbers), line)


def _converted(
    name: str, quantity: _Quantity, values: FloatArray, rows: Sequence[tuple[int, str]], source: str
) -> FloatArray:
    check_finite(values, name, source, lambda row: f"line {rows[row][0]}: {quantity.name}")
    place = f"{source}: line {quantity.line}: channel {quantity.name}"
    return in_si(values, quantity.unit, CHANNELS[name].quantity, place)


def _is_unit(spelling: str) -> bool:
    try:
        unit_named(spelling)
    except UnknownName:
        return False
    return True
