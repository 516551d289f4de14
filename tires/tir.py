"""Tire property files (.tir): text to tire and back.

The format is the field's: sections in brackets, ``KEY = value``, comments after ``$`` or ``!``. What it cannot
say (the model's name where no FITTYP exists, the effects, where the tire comes from) stands in the section
[TIREFMU], which other readers skip. Tires are written in ISO-W with every digit of every value.
"""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tirefmu.symbolic import MODELS
from tirefmu.symbolic.errors import TirefmuError, TirError, nearest

from .tire import Tire

#: FITTYP of the models. 96 is ours: the field has no number for the Trento form.
FITTYP = {"mf96": 96}
UNITS = {"LENGTH": "meter", "FORCE": "newton", "ANGLE": "radians", "MASS": "kg", "TIME": "second"}
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
    for entry in _entries(text, path):
        entries[entry.key] = entry
    if not entries:
        raise TirError(f"{path}: no line 'KEY = value' found: not a .tir file")
    _check_units(entries, path)
    model = _model(entries, path)
    known = MODELS[model].coefficients
    values = {}
    for entry in entries.values():
        if entry.key in known:
            values[entry.key] = _number(entry, path)
        elif entry.section in {card.section for card in known.values()}:
            raise TirError(
                f"{path}:{entry.line}: unknown key {entry.key} of {model}{nearest(entry.key, known)}"
            )
    ranges = {
        name: (_number(entries[low], path), _number(entries[high], path))
        for name, (_, low, high) in RANGE_SECTIONS.items()
        if low in entries and high in entries
    }
    effects = None
    if "EFFECTS" in entries:
        effects = [name for name in _unquoted(entries["EFFECTS"].value).split(",") if name]
        for name, factor in _core_values(entries, path).items():
            values[name] = factor
    about = {
        entry.key.lower(): _unquoted(entry.value)
        for entry in entries.values()
        if entry.section == "TIREFMU_ABOUT"
    }
    name = _unquoted(entries["NAME"].value) if "NAME" in entries else path.stem
    try:
        return Tire(model, values, effects=effects, name=name, about=about, ranges=ranges)
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
        handle, scratch = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
        Path(scratch).chmod(0o644)
        os.replace(scratch, path)
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
    lines += _section("UNITS", {key: f"'{unit}'" for key, unit in UNITS.items()})
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
    # An absent effect may rescale a coefficient for other readers; its own value is kept here, to the last bit.
    own |= {f"CORE_{name}": repr(tire.values[name]) for effect in absent for name, _ in effect.rescales}
    lines = ["[TIREFMU]", *(f"{key} = {value}" for key, value in own.items())]
    return lines + _section(
        "TIREFMU_ABOUT", {key.upper(): _quoted(str(value)) for key, value in tire.about.items()}
    )


def _section(title: str, values: dict[str, str]) -> list[str]:
    return ["", f"[{title}]", *(f"{key} = {value}" for key, value in values.items())] if values else []


def _quoted(text: str) -> str:
    plain = re.sub(r"[\s'$!]+", " ", text).strip()
    return f"'{plain}'"


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
        return float(_unquoted(entry.value).lower().replace("d", "e"))
    except ValueError:
        raise TirError(f"{path}:{entry.line}: {entry.key} = {entry.value!r} is not a number") from None


def _core_values(entries: dict[str, Entry], path: Path) -> dict[str, float]:
    return {
        key.removeprefix("CORE_"): _number(e, path) for key, e in entries.items() if key.startswith("CORE_")
    }


def _check_units(entries: dict[str, Entry], path: Path) -> None:
    accepted = {
        "LENGTH": ("meter", "m"),
        "FORCE": ("newton", "n"),
        "ANGLE": ("radians", "radian", "rad"),
        "MASS": ("kg", "kilogram"),
        "TIME": ("second", "sec", "s"),
    }
    for key, units in accepted.items():
        entry = entries.get(key)
        if entry and entry.section == "UNITS" and _unquoted(entry.value).lower() not in units:
            raise TirError(
                f"{path}:{entry.line}: {key} in {_unquoted(entry.value)}: only SI ({units[0]}) is read"
            )


def _model(entries: dict[str, Entry], path: Path) -> str:
    own = entries.get("TIREFMU_MODEL")
    if own:
        name = _unquoted(own.value)
        if name not in MODELS:
            raise TirError(f"{path}:{own.line}: unknown model {name!r}{nearest(name, MODELS)}")
        return name
    entry = entries.get("FITTYP")
    if entry is None:
        raise TirError(f"{path}: no FITTYP in [MODEL]: which model is it?")
    for name, number in FITTYP.items():
        if _number(entry, path) == number:
            return name
    known = ", ".join(f"{number} ({name})" for name, number in FITTYP.items())
    raise TirError(
        f"{path}:{entry.line}: FITTYP {entry.value} is not a model of this version: known are {known}"
    )
