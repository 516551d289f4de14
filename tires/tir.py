"""Tire property files (.tir): text to tire and back.

The format is the field's: sections in brackets, ``KEY = value``, comments after ``$`` or ``!``. What it
cannot say (the model's name where no FITTYP exists, the effects, where the tire comes from) stands in the
sections [TIREFMU] and [TIREFMU_ABOUT], which other readers skip. Tires are written in ISO-W with every digit
of every value.
"""

from __future__ import annotations

import json
import math
import os
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tirefmu.symbolic import MODELS
from tirefmu.symbolic.errors import TirefmuError, TirError, UnknownName, nearest

from .tire import Tire

#: FITTYP of the models. 96 is ours: the field has no number for the Trento form.
FITTYP = {"mf96": 96}
#: The spellings of these units, the written one first.
ACCEPTED_UNITS = {
    "LENGTH": ("meter", "m"),
    "FORCE": ("newton", "n"),
    "ANGLE": ("radians", "radian", "rad"),
    "MASS": ("kg", "kilogram"),
    "TIME": ("second", "sec", "s"),
}
#: Keys of the ranges in which a tire is known, by input.
RANGE_SECTIONS = {
    "kappa": ("LONG_SLIP_RANGE", "KPUMIN", "KPUMAX"),
    "alpha": ("SLIP_ANGLE_RANGE", "ALPMIN", "ALPMAX"),
    "gamma": ("INCLINATION_ANGLE_RANGE", "CAMMIN", "CAMMAX"),
    "Fz": ("VERTICAL_FORCE_RANGE", "FZMIN", "FZMAX"),
}


@dataclass(frozen=True)
class Entry:
    """A line ``KEY = value`` of a .tir file."""

    section: str
    key: str
    value: str
    line: int


def read_tir(path: str | Path) -> Tire:
    """Read a tire from a .tir file.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Tire
        In ISO-W.

    Raises
    ------
    TirError
        If the file is missing or broken; file, line and key stand in the message.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig", errors="replace")
    except OSError as error:
        raise TirError(f"{path}: cannot be read ({error.strerror or error})") from error
    entries: dict[str, Entry] = {}
    own: dict[str, Entry] = {}
    about: dict[str, Entry] = {}
    for entry in _entries(text, path):
        {"TIREFMU": own, "TIREFMU_ABOUT": about}.get(entry.section, entries)[entry.key] = entry
        _check_unit(entry, path)
    if not entries:
        raise TirError(f"{path}: no line 'KEY = value' found: not a .tir file")
    model = _model(entries, own, path)
    known = MODELS[model].coefficients
    sections = {card.section for card in known.values()}
    read = [entry for entry in entries.values() if entry.key in known or entry.section in sections]
    values = {_key(entry.key, model, entry, path): _number(entry, path) for entry in read}
    effects = None
    if "EFFECTS" in own:
        effects = _effects(own["EFFECTS"], model, path)
        core = {entry.key.removeprefix("CORE_"): entry for entry in own.values() if entry.key.startswith("CORE_")}
        values |= {_key(name, model, entry, path): _number(entry, path) for name, entry in core.items()}
    told = {entry.key.lower(): _text(entry, path) for entry in about.values()}
    name = _text(own["NAME"], path) if "NAME" in own else path.stem
    ranges = _ranges(entries, path)
    try:
        return Tire(model, values, effects=effects, name=name, about=told, ranges=ranges)
    except TirefmuError as error:
        raise TirError(f"{path}: {error}") from error


def write_tir(tire: Tire, path: str | Path) -> None:
    """Write a tire as a .tir file: complete or not at all.

    Parameters
    ----------
    tire : Tire
        Written in ISO-W, whatever its own signs.
    path : str or Path

    Raises
    ------
    TirError
        If the file cannot be written.
    """
    path = Path(path)
    text = tir_text(tire)
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as scratch:
            written = Path(scratch) / path.name
            written.write_text(text, encoding="utf-8", newline="\n")
            os.replace(written, path)
    except OSError as error:
        raise TirError(f"{path}: cannot be written ({error.strerror or error})") from error


def tir_text(tire: Tire) -> str:
    """Return the text of a tire's .tir file.

    Parameters
    ----------
    tire : Tire

    Returns
    -------
    str

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> tir_text(published("trento_hoosier")).splitlines()[0]
    '[MDI_HEADER]'
    """
    tire = tire.in_signs("iso")
    book = tire.book
    written = dict(zip(book.coefficients, tire.parameters().tolist(), strict=True))
    lines = ["[MDI_HEADER]", "FILE_TYPE = 'tir'", "FILE_VERSION = 3.0", "FILE_FORMAT = 'ASCII'"]
    lines += _section("UNITS", {key: f"'{units[0]}'" for key, units in ACCEPTED_UNITS.items()})
    lines += _section(
        "MODEL", {"FITTYP": str(FITTYP[tire.model]), "PROPERTY_FILE_FORMAT": "'USER'", "TYRESIDE": "'LEFT'"}
    )
    for section in book.sections:
        lines += ["", f"[{section.title}]"]
        lines += [
            f"{name} = {written[name]!r}  $ {card.description} [{card.unit}]"
            for name, card in section.coefficients.items()
        ]
    for name, (title, low, high) in RANGE_SECTIONS.items():
        if name in tire.ranges:
            lines += _section(title, {low: repr(tire.ranges[name][0]), high: repr(tire.ranges[name][1])})
    lines += ["", "$ What follows is tirefmu's own; other readers skip it.", *_own_section(tire)]
    return "\n".join(lines) + "\n"


def _own_section(tire: Tire) -> list[str]:
    own = {"TIREFMU_MODEL": f"'{tire.model}'", "NAME": _quoted(tire.name)}
    absent = [effect for name, effect in tire.book.effects.items() if name not in tire.has]
    if absent:
        own["EFFECTS"] = f"'{','.join(name for name in tire.book.effects if name in tire.has)}'"
    # An absent effect may rescale a coefficient for other readers; its own value is kept here, every digit.
    own |= {f"CORE_{name}": repr(tire.values[name]) for effect in absent for name, _ in effect.rescales}
    lines = ["[TIREFMU]", *(f"{key} = {value}" for key, value in own.items())]
    return lines + _section("TIREFMU_ABOUT", {key.upper(): _quoted(str(value)) for key, value in tire.about.items()})


def _section(title: str, values: dict[str, str]) -> list[str]:
    return ["", f"[{title}]", *(f"{key} = {value}" for key, value in values.items())] if values else []


def _quoted(text: str) -> str:
    """Return a text of our own sections on one line, without a sign that starts a comment or ends a quote."""
    if text.isprintable() and not set(text) & set("'\"$!\\"):
        return f"'{text}'"
    inner = json.dumps(text)[1:-1].replace('\\"', "\\u0022")
    for sign in "'$!":
        inner = inner.replace(sign, f"\\u{ord(sign):04x}")
    return f'"{inner}"'


def _text(entry: Entry, path: Path) -> str:
    """Return what `_quoted` wrote; also a plain text that somebody typed without quotes."""
    if entry.value.startswith('"'):
        try:
            return str(json.loads(entry.value))
        except json.JSONDecodeError:
            raise TirError(f"{path}:{entry.line}: {entry.key} is not a quoted text: {entry.value}") from None
    single = len(entry.value) > 1 and entry.value[0] == entry.value[-1] == "'"
    return entry.value[1:-1] if single else entry.value


def _unquoted(text: str) -> str:
    return text.strip().strip("'\"").strip()


def _entries(text: str, path: Path) -> Iterator[Entry]:
    section = ""
    for number, raw in enumerate(text.splitlines(), start=1):
        line = _without_comment(raw).strip()
        if not line:
            continue
        if line.startswith("["):
            if not line.endswith("]"):
                raise TirError(f"{path}:{number}: section {line!r} is not closed by ']'")
            section = line[1:-1].strip().upper()
            continue
        key, equals, value = line.partition("=")
        if not equals:
            if section in ("SHAPE", ""):  # a table of numbers, or prose before the first section
                continue
            raise TirError(f"{path}:{number}: {line!r} in [{section}] is not 'KEY = value'")
        yield Entry(section, key.strip().upper(), value.strip(), number)


def _without_comment(line: str) -> str:
    quoted = False
    for i, character in enumerate(line):
        if character in "'\"":
            quoted = not quoted
        elif character in "$!" and not quoted:
            return line[:i]
    return line


def _number(entry: Entry, path: Path) -> float:
    try:
        value = float(_unquoted(entry.value).lower().replace("d", "e"))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise TirError(f"{path}:{entry.line}: {entry.key} = {entry.value!r} is not a number")
    return value


def _key(name: str, model: str, entry: Entry, path: Path) -> str:
    """Return the name of a coefficient, or report a line with a key that the model does not know."""
    known = MODELS[model].coefficients
    if name not in known:
        raise TirError(f"{path}:{entry.line}: unknown key {entry.key} of {model}{nearest(name, known)}")
    return name


def _effects(entry: Entry, model: str, path: Path) -> frozenset[str]:
    names = (name.strip() for name in _unquoted(entry.value).split(","))
    try:
        return MODELS[model].known_effects(name for name in names if name)
    except UnknownName as error:
        raise TirError(f"{path}:{entry.line}: {error}") from None


def _ranges(entries: dict[str, Entry], path: Path) -> dict[str, tuple[float, float]]:
    ranges = {}
    for name, (_, low, high) in RANGE_SECTIONS.items():
        if low in entries and high in entries:
            lower, upper = _number(entries[low], path), _number(entries[high], path)
            if lower > upper:
                raise TirError(f"{path}:{entries[low].line}: {low} = {lower} lies above {high} = {upper}")
            ranges[name] = (lower, upper)
    return ranges


def _check_unit(entry: Entry, path: Path) -> None:
    units = ACCEPTED_UNITS.get(entry.key)
    if entry.section == "UNITS" and units and _unquoted(entry.value).lower() not in units:
        raise TirError(f"{path}:{entry.line}: {entry.key} in {_unquoted(entry.value)}: only SI ({units[0]}) is read")


def _model(entries: dict[str, Entry], own: dict[str, Entry], path: Path) -> str:
    named = own.get("TIREFMU_MODEL")
    if named:
        name = _unquoted(named.value)
        if name not in MODELS:
            raise TirError(f"{path}:{named.line}: unknown model {name!r}{nearest(name, MODELS)}")
        return name
    entry = entries.get("FITTYP")
    if entry is None:
        raise TirError(f"{path}: no FITTYP in [MODEL]: which model is it?")
    for name, number in FITTYP.items():
        if _number(entry, path) == number:
            return name
    known = ", ".join(f"{number} ({name})" for name, number in FITTYP.items())
    raise TirError(f"{path}:{entry.line}: FITTYP {entry.value} is not a model of this version: known are {known}")
