"""Reading of .tir files: the model, values in SI, other entries to retain, and notes for the user.

If a key occurs twice, the last one counts; a coefficient is taken from its own section before any other. A missing or
empty coefficient, and a zero radius or stiffness of the body, takes the value that other programs assume (`assumed` of
its declaration), else its default, and is in `Tire.defaulted`. A file without [TIREFMU] EFFECTS has the default
effects, and an optional effect if one of its own coefficients is given and not neutral. All other keys and tables are
retained and written again. Further content of files is not an error, because files in use always contain more than one
reader needs. If only tirefmu writes the files of a model (`PropertyFile.strict`), a key that resembles a coefficient is
refused.
"""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from ...boundary.errors import LISTED_BY, TirefmuError, TirefmuWarning, TirError, UnknownName, nearest, path_from
from ...boundary.escaping import excerpt, quoted
from ...symbolic.added import AddedEffect, library, read_effect
from ...symbolic.model import INDISPENSABLE, Model
from ...symbolic.models import with_library
from ..code.printed import model_with
from ..definition import RANGES
from ..tire import Tire
from .mirror import sided, symmetric
from .model_identification import model_of
from .names import (
    ADDED,
    ASSUMED,
    OWN_RANGES,
    OWN_SECTIONS,
    RANGE_SECTIONS,
    OtherEntry,
    assumed_lines,
    in_written_order,
    listed,
)
from .other_entries import other_entries
from .text import Entry, Row, number_and_rest, read_lines, unquoted, without_comment
from .unit_system import unit_system
from .units import unit_contradicts
from .use import side_of, transient_notes, use_notes

#: Sections with ``KEY = value`` only, in addition to those of the coefficients.
STRICT = ("UNITS", "MODEL", *OWN_SECTIONS)

#: The coefficient that a caller can give if a file lacks it.
RADIUS = "UNLOADED_RADIUS"
#: Divisors in the equations; files of tires with measured forces only contain 0.
BODY = ("VERTICAL_STIFFNESS", "Q_RE0")


@dataclass(frozen=True)
class TirReading:
    """A tire as read from a file, and notes on the reading for its user.

    - `notes`: what the file does not state and how it was interpreted, a sentence each: units converted, keys that
      resemble coefficients, keys given twice, ...
    - `disputed`: those of the notes about statements that other programs read or obey differently, and `typical`.
    - `typical`: those about coefficients without which no force can be computed, and which the file lacks.
    """

    tire: Tire
    notes: tuple[str, ...]
    disputed: tuple[str, ...] = ()
    typical: tuple[str, ...] = ()


def read_tir(path: str | Path, radius: float | None = None) -> Tire:
    """Read a tire from a .tir file.

    Parameters
    ----------
    path : str or Path
        With a FITTYP or a PROPERTY_FILE_FORMAT of a model (`PropertyFile`), such as 61 or 'PAC2002'; in any units
        that [UNITS] can declare.
    radius : float, optional
        Free radius, m, of a file without UNLOADED_RADIUS.

    Returns
    -------
    Tire
        In ISO-W and SI.

    Raises
    ------
    TirError
        If the file is missing or broken, or states another radius; the message names file, line and key.

    Warns
    -----
    TirefmuWarning
        For each statement of the file that other programs read or obey differently, such as FITTYP 52 or USE_MODE 3.
    """
    reading = read_tir_with_notes(path, radius)
    for note in reading.disputed:
        warnings.warn(f"{path}: {note}", TirefmuWarning, stacklevel=2)
    return reading.tire


def read_tir_with_notes(path: str | Path, radius: float | None = None) -> TirReading:
    """Read a tire from a .tir file, with notes on information that the file does not state.

    Raises `TirError`: as `read_tir` does.
    """
    return _Reader(path_from(path), radius).reading()


class _Reader:
    """The state of reading one file: entries are removed from `unread`; the remaining ones are retained."""

    def __init__(self, path: Path, radius: float | None = None) -> None:
        self.path, self.radius = path, radius
        self.notes: list[str] = []
        self.disputed: list[str] = []
        self.repeated: list[str] = []
        self.given: dict[str, Entry] = {}
        lines = read_lines(path)
        self.rows = [line for line in lines if isinstance(line, Row)]
        self.unread: dict[tuple[str, str], Entry] = {}
        for entry in lines:
            if isinstance(entry, Entry):
                self._file(entry)
        self.sections: dict[str, list[tuple[str, str]]] = {}
        for section, key in self.unread:
            self.sections.setdefault(key, []).append((section, key))
        if not self.unread:
            raise TirError(f"{path}: no line 'KEY = value' found: not a .tir file")

    def reading(self) -> TirReading:
        """Return the tire and the notes."""
        stated = {key: self.unread.pop(("TIREFMU", key)) for key in self._keys_of("TIREFMU")}
        self.units, unit_notes = unit_system(self.unread, self.path)
        name, why, self.disputed = model_of(self.unread, stated, self.path)
        self.notes += [*why, *unit_notes]
        added = tuple(self._added(self._take(ADDED, key)) for key in self._keys_of(ADDED))
        named = listed(stated["EFFECTS"].value) if "EFFECTS" in stated else ()
        try:
            model = model_with(name, with_library(name, named, added))
        except TirefmuError as error:
            raise TirError(f"{self.path}: {error}") from error
        self._refuse_rows(model)
        self._refuse_own(stated, model)
        values = dict(self._values(model))
        values |= {
            key.removeprefix("CORE_"): self._number(stated[key], 1.0) for key in stated if key.startswith("CORE_")
        }
        self._add_radius(values)
        self._refuse_crossed(values)
        effects = self._effects(stated, model) if "EFFECTS" in stated else self._effects_by_coefficients(values, model)
        typical = self._typical_values(values, model)
        assumed = self._assume(values, model, model.default_effects if effects is None else effects)
        ranges = {**dict(self._ranges(model)), **dict(self._own_ranges())}
        about = [self._take("TIREFMU_ABOUT", key) for key in self._keys_of("TIREFMU_ABOUT")]
        about_texts = {entry.key.lower(): _text(entry, self.path) for entry in about}
        title = _text(stated["NAME"], self.path) if "NAME" in stated else self.path.stem
        side = self._side()
        others, other_notes = other_entries([*self.rows, *self.unread.values()], model, self.units, self.path)
        self.notes += other_notes
        entries = in_written_order([*others, *assumed], model)
        try:
            tire = Tire(name, values, effects, name=title, about=about_texts, ranges=ranges, side=side, added=added,
                        other_entries=entries)  # fmt: skip
        except TirefmuError as error:
            raise TirError(f"{self.path}: {error}") from error
        tire = self._without_side(tire)
        disputed = (*self.disputed, *self.repeated, *typical, *use_notes(tire))
        return TirReading(tire, (*self.notes, *disputed, *transient_notes(tire)), disputed, tuple(typical))

    def _add_radius(self, values: dict[str, float]) -> None:
        """Add the radius that the caller gives to a file without one."""
        if self.radius is None:
            if RADIUS not in values:
                raise TirError(
                    f"{self.path}: a tire needs {RADIUS} (free radius R_0, m): give it with --nominal R0=..., "
                    "in Python with radius="
                )
            return
        if not 0.0 < self.radius < math.inf:
            raise TirError(f"{self.path}: the radius R0 = {self.radius:g} m is not a positive number")
        if RADIUS in values:
            raise TirError(f"{self.path}: the file states {RADIUS} = {values[RADIUS]:g} m: no other R0 can be given")
        values[RADIUS] = self.radius
        self.notes.append(f"{RADIUS} is not in the file: {self.radius:g} m was given")

    def _file(self, entry: Entry) -> None:
        earlier = self.unread.pop((entry.section, entry.key), None)
        self.unread[entry.section, entry.key] = entry
        if earlier and earlier.value != entry.value:
            value = excerpt(earlier.value)
            self.repeated.append(
                f"line {earlier.line}: {entry.key} = {value} is given again in line {entry.line}, which counts"
            )

    def _keys_of(self, section: str) -> list[str]:
        return [key for title, key in self.unread if title == section]

    def _take(self, section: str, key: str) -> Entry:
        return self.unread.pop((section, key))

    def _line_of(self, entry: Entry) -> str:
        return f"{self.path}:{entry.line}"

    def _find(self, key: str, section: str) -> Entry | None:
        """Remove a key from its own section, or from the last other section that has it."""
        unread = (place for place in self.sections.get(key, ()) if place in self.unread)
        places = [place for place in unread if place[0] not in ("UNITS", *OWN_SECTIONS)]
        home = (section, key)
        entry = self.unread[home if home in places else places[-1]] if places else None
        for place in places:
            del self.unread[place]
        return entry

    def _values(self, model: Model) -> Iterator[tuple[str, float]]:
        spelled = model.property_file.aliases
        spellings = {name: alias for alias, name in spelled.items() if alias not in model.coefficients}
        for name, declaration in model.coefficients.items():
            entry = self._find(name, declaration.section)
            if (entry is None or not entry.value) and name in spellings:
                entry = self._find(spellings[name], declaration.section) or entry
            if entry is None:
                continue
            if not unquoted(entry.value):
                if name in INDISPENSABLE:
                    raise TirError(f"{self._line_of(entry)}: {entry.key} has no value: a tire needs it")
                continue
            self.given[name] = entry
            in_si = entry.key in model.property_file.in_si
            factor = self.units.factor(declaration.unit, declaration.section, per_angle=model.property_file.per_angle)
            number = self._number(entry, 1.0 if in_si else factor)
            if number == 0.0 and name in BODY and declaration.assumed is not None:
                self.notes.append(
                    f"line {entry.line}: {entry.key} = 0 is not possible: {declaration.assumed:g} is assumed"
                )
                continue
            yield name, number

    def _ranges(self, model: Model) -> Iterator[tuple[str, tuple[float, float]]]:
        """Yield the ranges of a model that has no coefficients for them."""
        for name, (section, unit) in RANGE_SECTIONS.items():
            ends = [self._find(key, section) for key in RANGES[name] if key not in model.coefficients]
            given = [entry for entry in ends if entry is not None and unquoted(entry.value)]
            numbers = [self._number(entry, self.units.factor(unit, section)) for entry in given]
            if len(numbers) == 2:
                self.given |= dict(zip(RANGES[name], given, strict=True))
                self._refuse_crossed(dict(zip(RANGES[name], numbers, strict=True)))
                yield name, (numbers[0], numbers[1])

    def _refuse_crossed(self, values: Mapping[str, float]) -> None:
        for low, high in RANGES.values():
            if low in self.given and high in self.given and values.get(low, 0.0) > values.get(high, math.inf):
                where = self._line_of(self.given[low])
                raise TirError(f"{where}: {low} = {values[low]} lies above {high} = {values[high]}")

    def _own_ranges(self) -> Iterator[tuple[str, tuple[float, float]]]:
        """Yield the ranges that only a file of tirefmu has."""
        inputs = {key: name for name, key in OWN_RANGES.items()}
        for key in self._keys_of("TIREFMU_RANGES"):
            entry = self._take("TIREFMU_RANGES", key)
            ends = [number_and_rest(part)[0] for part in listed(entry.value)]
            if key not in inputs:
                raise TirError(f"{self._line_of(entry)}: unknown key {key}{nearest(key, inputs)}")
            if len(ends) != 2 or not ends[0] <= ends[1]:
                raise TirError(f"{self._line_of(entry)}: {key} = {excerpt(entry.value)} is not a range 'lower,upper'")
            yield inputs[key], (ends[0], ends[1])

    def _number(self, entry: Entry, factor: float) -> float:
        number, rest = number_and_rest(entry.value)
        shown = f"{entry.key} = {quoted(entry.value)}"
        if math.isnan(number) or not math.isnan(number_and_rest(rest)[0]):
            raise TirError(f"{self._line_of(entry)}: {shown} is not a number")
        word = rest.partition(" ")[0]
        if unit_contradicts(word, factor):
            raise TirError(f"{self._line_of(entry)}: {shown}: units are declared in [UNITS] only")
        if rest:
            self.notes.append(f"line {entry.line}: text behind {entry.key} is not read: {quoted(rest)}")
        scaled = number * factor if factor != 1.0 else number
        if not math.isfinite(scaled):
            raise TirError(f"{self._line_of(entry)}: {shown} is too large")
        return scaled

    def _added(self, entry: Entry) -> AddedEffect:
        """Return the effect whose file is in a line of tirefmu's section."""
        return read_effect(_text(entry, self.path), self._line_of(entry))

    def _effects(self, stated: dict[str, Entry], model: Model) -> frozenset[str]:
        try:
            return model.known_effects(listed(stated["EFFECTS"].value))
        except UnknownName as error:
            raise TirError(f"{self._line_of(stated['EFFECTS'])}: {error}") from None

    def _effects_by_coefficients(self, values: Mapping[str, float], model: Model) -> frozenset[str] | None:
        """Return the effects of a file that names none, or None for the default effects."""
        beyond = {effect.name for effect in model.added}
        absent = {}
        for effect in model.effects.keys() - model.default_effects - beyond:
            coefficients = sorted(model.owned(effect) & values.keys())
            if acting := [name for name in coefficients if values[name] != model.coefficients[name].neutral]:
                absent[effect] = ", ".join(acting)
        self.notes += [f"the tire has the effect {effect}: {absent[effect]} given" for effect in sorted(absent)]
        return model.default_effects | beyond - library().keys() | absent.keys() if absent else None

    def _assume(self, values: dict[str, float], model: Model, effects: frozenset[str]) -> tuple[OtherEntry, ...]:
        """Fill in missing coefficients, as other programs do, and return the lines that name them.

        The tire fills in those at the model's default and those that only an absent effect reads.
        """
        named = self._named_as_assumed(model)
        for name, declaration in model.coefficients.items():
            if name not in values and declaration.assumed is not None:
                named.add(name)
                values[name] = declaration.assumed
        nominal = (str(quantity.nominal) for quantity in model.inputs if quantity.name in RANGES)
        sizes = {name: values[name] for name in nominal if values.get(name, 0.0) > 0.0}
        defaults = Tire(model.name, {**dict.fromkeys(INDISPENSABLE, 1.0), **sizes}).values
        idle = model.owned(*sorted(model.effects.keys() - effects))
        for name in named & values.keys():
            if name in INDISPENSABLE:
                continue
            plain = model.coefficients[name].default
            if name in idle or repr(values[name]) in (repr(plain), repr(defaults.get(name, plain))):
                del values[name]
        return assumed_lines(named & values.keys(), model)

    def _typical_values(self, values: Mapping[str, float], model: Model) -> list[str]:
        """Return a sentence if a file lacks coefficients that every tire of the model has."""
        listed_as_assumed = {name for key in self._keys_of(ASSUMED) for name in listed(self.unread[ASSUMED, key].value)}
        missing = {}
        for name in model.baseline.coefficients:
            declared = model.coefficients[name]
            value = declared.default if declared.assumed is None else declared.assumed
            if name not in values and name not in listed_as_assumed and value != 0.0:
                missing[name] = f"{name} = {value:g}"
        if not missing:
            return []
        return [f"is the file complete? it lacks what every tire has; assumed: {', '.join(missing.values())}"]

    def _named_as_assumed(self, model: Model) -> set[str]:
        """Return the coefficients that a file of tirefmu lists as not given."""
        names: set[str] = set()
        for key in self._keys_of(ASSUMED):
            entry = self._take(ASSUMED, key)
            for name in listed(entry.value):
                if name not in model.coefficients:
                    similar = nearest(name, model.coefficients, LISTED_BY["coefficient"])
                    raise TirError(f"{self._line_of(entry)}: unknown coefficient {name} of {model.name}{similar}")
                names.add(name)
        return names

    def _side(self) -> str:
        entry = self.unread.get(("MODEL", "TYRESIDE"))
        side = side_of(entry.value) if entry else ""
        if side:
            self._take("MODEL", "TYRESIDE")
        return side

    def _without_side(self, tire: Tire) -> Tire:
        """Return the tire of a file that states that left and right do not differ."""
        if tire.side != "symmetric":
            return tire
        if differing := sided(tire):
            self.disputed.append(
                f"TYRESIDE = 'SYMMETRIC': what makes left and right differ is set to 0: {', '.join(differing)}"
            )
        return symmetric(tire)

    def _refuse_rows(self, model: Model) -> None:
        strict = {*STRICT, *(section.title for section in model.sections)}
        for row in self.rows:
            if row.section in strict and not row.in_table:
                line = quoted(without_comment(row.text).strip())
                words = "" if any(map(str.isdigit, line)) else "; a comment begins with $"  # one that a page has broken
                raise TirError(f"{self.path}:{row.line}: {line} in [{row.section}] is not 'KEY = value'{words}")

    def _refuse_own(self, stated: dict[str, Entry], model: Model) -> None:
        allowed = ["TIREFMU_MODEL", "NAME", "EFFECTS", *(f"CORE_{name}" for name in model.coefficients)]
        for key, entry in stated.items():
            if key not in allowed:
                hint = nearest(key, allowed, LISTED_BY["coefficient"])
                raise TirError(f"{self._line_of(entry)}: unknown key {key} of {model.name}{hint}")


def _text(entry: Entry, path: Path) -> str:
    """Return the content of a text in tirefmu's form; also a plain text without quotes."""
    if entry.value.startswith('"'):
        try:
            return str(json.loads(entry.value))
        except (json.JSONDecodeError, RecursionError):
            raise TirError(f"{path}:{entry.line}: {entry.key} is not a quoted text: {excerpt(entry.value)}") from None
    single = len(entry.value) > 1 and entry.value[0] == entry.value[-1] == "'"
    return entry.value[1:-1] if single else entry.value
