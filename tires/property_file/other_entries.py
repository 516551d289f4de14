"""Entries of a .tir file beyond its model: retained, in SI where their unit is known, with notes on similar keys."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from pathlib import Path

from ...boundary.errors import LISTED_BY, TirError
from ...symbolic.model import Model
from .names import HEADER, KEPT_UNITS, MAX_SEARCHED, OtherEntry, aliases, model_lines, near_miss, unit_of
from .text import Entry, Row, number_and_rest
from .unit_system import UnitSystem


def other_entries(
    lines: Iterable[Entry | Row], model: Model, units: UnitSystem, path: Path
) -> tuple[tuple[OtherEntry, ...], list[str]]:
    """Return the lines of a file that its model does not read, in the form in which they are written again.

    `lines`: what remains of the file. `units`: of the file. `path`: for messages. Returns: the lines in the order of
    the file, and notes about them. Raises `TirError` if a key resembles a coefficient in a file that only tirefmu
    writes.

    >>> from tirefmu.symbolic.models import model_named
    >>> inches = UnitSystem({"LENGTH": 0.0254}, {"LENGTH": "'inch'"})
    >>> other_entries([Entry("DIMENSION", "RIM_WIDTH", "10.0", 8)], model_named("mf61"), inches, Path("x.tir"))
    ((('DIMENSION', 'RIM_WIDTH', '0.254'),), [])
    """
    lines = sorted(lines, key=lambda line: line.line)
    entries: list[OtherEntry] = []
    informative: list[Entry] = []
    for line in lines:
        if isinstance(line, Row):
            entries.append((line.section, "", line.text))
        elif _is_informative(line, model):
            entries.append((line.section, line.key, _in_si(line, units)))
            informative.append(line)
    notes = _notes_on_similar_keys(informative, model, path)
    if units.other_units and any(_has_unknown_unit(line) for line in lines):
        entries += [(KEPT_UNITS, key, unit) for key, unit in units.other_units.items()]
        notes.append("other entries and tables without a known unit stay in the file's units")
    return tuple(entries), notes


def _is_informative(entry: Entry, model: Model) -> bool:
    expected = {"MDI_HEADER": HEADER, "MODEL": model_lines(model)}.get(entry.section, {})
    return expected.get(entry.key, "").casefold() != entry.value.casefold() and entry.key != "FITTYP"


def _in_si(entry: Entry, units: UnitSystem) -> str:
    unit = unit_of(entry.key)
    factor = units.factor(unit, "") if unit else 1.0
    number, rest = number_and_rest(entry.value)
    return entry.value if factor == 1.0 or math.isnan(number) or rest else repr(number * factor)


def _has_unknown_unit(line: Entry | Row) -> bool:
    """Return whether a line holds numbers of unknown unit."""
    if isinstance(line, Row):
        return line.section != "SHAPE" and any(not math.isnan(number_and_rest(w)[0]) for w in line.text.split())
    return unit_of(line.key) is None and not math.isnan(number_and_rest(line.value)[0])


def _notes_on_similar_keys(entries: Iterable[Entry], model: Model, path: Path) -> list[str]:
    """Return a note for each key that resembles a coefficient, or refuse it."""
    titles = {section.title for section in model.sections}
    notes: list[str] = []
    for searched, entry in enumerate(entry for entry in entries if _may_be_similar(entry, titles)):
        if searched == MAX_SEARCHED:
            notes.append(f"line {entry.line}: no similar coefficients are looked for from here on")
            break
        near = near_miss(entry.key, model.coefficients)
        if near and (model.property_file.strict or entry.section.startswith("TIREFMU")):
            raise TirError(
                f"{path}:{entry.line}: unknown key {entry.key} of {model.name}: did you mean {near}? "
                f"{LISTED_BY['coefficient']} lists all coefficients"
            )
        if near:
            notes.append(f"line {entry.line}: unknown key {entry.key} (near {near}) is stored, not used")
    return notes


def _may_be_similar(entry: Entry, titles: Collection[str]) -> bool:
    return entry.section in titles and unit_of(entry.key) is None and entry.key not in aliases()
