"""The units that one .tir file declares."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from dataclasses import dataclass
from pathlib import Path

from ...boundary.errors import TirError, nearest
from ...boundary.escaping import quoted
from .names import IDLE_UNITS
from .text import Entry, unquoted
from .units import UNITS, factor_of, unit_factor


@dataclass(frozen=True)
class UnitSystem:
    """The units of a file.

    - `factors`: to SI, by LENGTH, FORCE, ...; absent ones are SI.
    - `other_units`: those that are not SI, as the file writes them.

    >>> inches = UnitSystem({"LENGTH": 0.0254}, {"LENGTH": "'inch'"})
    >>> inches.factor("m", "DIMENSION"), inches.factor("m", "LATERAL_COEFFICIENTS")
    (0.0254, 1.0)
    """

    factors: Mapping[str, float]
    other_units: Mapping[str, str]

    def factor(self, unit: str, section: str, *, per_angle: bool = False) -> float:
        """Return the factor to SI of a value with an SI unit in a section; `per_angle` as in `factor_of`."""
        if section.endswith("_COEFFICIENTS") or section.startswith("TIREFMU"):  # tirefmu's are always in SI
            return 1.0
        return factor_of(unit, self.factors, per_angle=per_angle)


def unit_system(entries: MutableMapping[tuple[str, str], Entry], path: Path) -> tuple[UnitSystem, list[str]]:
    """Remove the units from a file's entries.

    `entries`: those that declare units are removed. `path`: for messages. Returns: the units, and notes about them.
    Raises `TirError` if a unit, or a key of [UNITS], is not known.
    """
    declared = [key for key in entries if key[0] == "UNITS" or _names_unit(entries[key])]
    declared.sort(key=lambda key: key[0] == "UNITS")  # [UNITS] overrides a header
    factors: dict[str, float] = {}
    other_units: dict[str, str] = {}
    notes: list[str] = []
    for key in declared:
        entry = entries.pop(key)
        where = f"{path}:{entry.line}"
        if entry.key not in UNITS:
            if entry.key in IDLE_UNITS:
                continue
            raise TirError(f"{where}: unknown key {entry.key} in [UNITS]{nearest(entry.key, UNITS)}")
        spelling = unquoted(entry.value)
        factor = unit_factor(entry.key, spelling)
        if factor is None:
            problem = f"{entry.key} in {quoted(spelling)}" if spelling else f"{entry.key} in [UNITS] has no value"
            raise TirError(f"{where}: {problem}{nearest(spelling, UNITS[entry.key])}")
        factors[entry.key] = factor
        other_units.pop(entry.key, None)
        if factor != 1.0:
            other_units[entry.key] = entry.value
    notes += [f"{key} is in {unquoted(unit)}: converted to SI" for key, unit in other_units.items()]
    if not factors:
        notes.append("the file declares no units: SI is taken")
    return UnitSystem(factors, other_units), notes


def _names_unit(entry: Entry) -> bool:
    """Return whether an entry outside [UNITS], such as in a [HEADER], is a unit."""
    named = entry.key in UNITS and unit_factor(entry.key, unquoted(entry.value)) is not None
    return named and not entry.section.startswith("TIREFMU")
