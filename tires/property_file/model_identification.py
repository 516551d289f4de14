"""Which model a .tir file is for."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from ...boundary.errors import TirError, nearest
from ...boundary.escaping import excerpt, quoted
from ...symbolic.models import MODELS
from .names import folded, model_by_coefficients
from .text import Entry, number_and_rest, unquoted

#: Formats of other tire models in use, folded, and their models.
OTHER_MODELS = {
    "PAC89": "the Magic Formula of 1989 (PAC89), whose coefficients have other meanings",
    "PAC94": "the Magic Formula of 1994 (PAC94), whose coefficients have other meanings",
    "PACMC": "the Magic Formula for motorcycle tires (PAC_MC)",
    "FTIRE": "FTire, a physical model without Magic Formula coefficients",
    "UA": "the University of Arizona model (UA)",
    "521": "the 5.2.1 tire of Adams, which interpolates tables",
    "TMEASY": "TMeasy, which describes each curve by its own points",
    "SWIFT": "SWIFT, a rigid ring model",
    "SWIFTTYRE": "SWIFT, a rigid ring model",
    "RMODK": "RMOD-K, a physical model without Magic Formula coefficients",
}


def model_of(
    entries: Mapping[tuple[str, str], Entry], stated: Mapping[str, Entry], path: Path
) -> tuple[str, list[str], list[str]]:
    """Return the model of a file, with notes where the file does not state it, and where other programs read another.

    `stated`: the entries of [TIREFMU]. `path`: for messages. Raises `TirError` if the file is for no model of this
    version, or states none.
    """
    if "TIREFMU_MODEL" in stated:
        return _named(stated["TIREFMU_MODEL"], path), [], []
    fittyp, format_ = _last("FITTYP", entries), _last("PROPERTY_FILE_FORMAT", entries)
    if fittyp and unquoted(fittyp.value):
        name, disputed = _numbered(fittyp, path)
        return name, [], [*disputed, *_other_format(name, unquoted(format_.value) if format_ else "")]
    if format_ is None or not unquoted(format_.value):
        raise TirError(f"{path}: no FITTYP in [MODEL]: which model is it?")
    spelled = unquoted(format_.value).upper()
    files = {name: model.property_file for name, model in MODELS.items()}
    for name, file in files.items():
        if folded(spelled) in map(folded, file.formats):
            return name, [f"no FITTYP: {name} by PROPERTY_FILE_FORMAT '{spelled}'"], []
    formats = {format_ for file in files.values() for format_ in (*file.formats, *file.shared_formats)}
    other = OTHER_MODELS.get("".join(filter(str.isalnum, spelled)))
    if other:
        raise TirError(f"{path}:{format_.line}: the file is for {other}: tirefmu reads files of {', '.join(MODELS)}")
    if folded(spelled) not in map(folded, formats):
        raise TirError(
            f"{path}:{format_.line}: PROPERTY_FILE_FORMAT {quoted(spelled)} is not a model of this version"
            f"{nearest(spelled, sorted(formats))}"
        )
    identified = model_by_coefficients(spelled, {key for _, key in entries})
    if identified is None:
        raise TirError(f"{path}: no FITTYP in [MODEL], and {quoted(spelled)} does not identify the model")
    return identified, [f"no FITTYP: {identified} by the coefficients in the file"], []


def _other_format(name: str, format_: str) -> list[str]:
    """Return a note if PROPERTY_FILE_FORMAT is that of another model than FITTYP: some programs read one of them."""
    others = [other for other, model in MODELS.items() if folded(format_) in map(folded, model.property_file.formats)]
    if not others or name in others:
        return []
    return [f"FITTYP is that of {name}, PROPERTY_FILE_FORMAT {quoted(format_)} that of {others[0]}: read as {name}"]


def _named(entry: Entry, path: Path) -> str:
    name = unquoted(entry.value)
    if name not in MODELS:
        raise TirError(f"{path}:{entry.line}: unknown model {quoted(name)}{nearest(name, MODELS)}")
    return name


def _numbered(entry: Entry, path: Path) -> tuple[str, list[str]]:
    number, _ = number_and_rest(entry.value)
    if math.isnan(number):
        raise TirError(f"{path}:{entry.line}: FITTYP = {quoted(entry.value)} is not a number")
    fittyp = {name: model.property_file.fittyp for name, model in MODELS.items() if model.property_file.fittyp}
    for name, numbers in fittyp.items():
        if number in numbers:
            disputed = MODELS[name].property_file.disputed.get(int(number))
            return name, [f"FITTYP {number:g} is read as {name}; {disputed}"] if disputed else []
    listed = ", ".join(f"{' '.join(map(str, sorted(numbers)))} ({name})" for name, numbers in fittyp.items())
    raise TirError(
        f"{path}:{entry.line}: FITTYP {excerpt(entry.value)} is not a model of this version: known are {listed}"
    )


def _last(key: str, entries: Mapping[tuple[str, str], Entry]) -> Entry | None:
    """Return an entry of [MODEL], else the last one of another section with this key."""
    matching = [entry for (_, name), entry in entries.items() if name == key]
    return entries.get(("MODEL", key)) or (matching[-1] if matching else None)
