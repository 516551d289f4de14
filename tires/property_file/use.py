"""What [MODEL] of a property file states about the use of its tire, and how tirefmu differs."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ...boundary.escaping import excerpt, quoted
from ..definition import TireDefinition
from .text import number_and_rest, unquoted

#: The last digit of USE_MODE in files of the Magic Formula, and what programs compute then. 4 is combined slip and 5
#: turn slip in addition, as tirefmu computes.
USE_MODES = {
    0: "no slip forces",
    1: "Fx and My only",
    2: "Fy, Mx and Mz only",
    3: "forces without combined slip",
}
COMPLETE = (4, 5)
#: Values that the keys have in files of tires that tirefmu computes in the same way.
SAME = {"FE_METHOD": ("NO",), "TYPE": ("CAR",)}
STATED = {
    "FE_METHOD": "Chrono computes combined slip by a friction ellipse, tirefmu by the coefficients",
    "TYPE": "the formula is that of a car tire",
}
#: Switches of MF-Tyre that change forces outside the fitted range.
SAFETY = ("MFSAFE1", "MFSAFE2", "MFSAFE3")


def side_of(value: str) -> str:
    """Return the side of a TYRESIDE, "left", "right" or "symmetric"; "" for any other value.

    >>> [side_of(text) for text in ("'LEFT'", "r", "Symmetrical", "'UNKNOWN'")]
    ['left', 'right', 'symmetric', '']
    """
    text = unquoted(value).strip().lower()
    if text.startswith("sym"):
        return "symmetric"
    return {"left": "left", "l": "left", "right": "right", "r": "right"}.get(text, "")


def use_notes(tire: TireDefinition) -> tuple[str, ...]:
    """Return a sentence for each statement on the use of a tire that other programs obey and tirefmu does not.

    >>> from tirefmu.tires import Tire
    >>> size = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
    >>> use_notes(Tire("mf61", size, other_entries=(("MODEL", "USE_MODE", "3"),)))
    ('USE_MODE = 3: other programs compute forces without combined slip, tirefmu all forces with combined slip',)
    """
    entries = {key.upper(): value for section, key, value in tire.other_entries if section == "MODEL"}
    return tuple(_notes(tire, entries))


def _notes(tire: TireDefinition, entries: dict[str, str]) -> Iterator[str]:
    if "USE_MODE" in entries and tire.symbolic_model.property_file.fittyp:
        yield from _mode(entries["USE_MODE"])
    if "TYRESIDE" in entries and unquoted(entries["TYRESIDE"]):
        shown = quoted(unquoted(entries["TYRESIDE"]))
        yield f"TYRESIDE = {shown} is none of LEFT, RIGHT, SYMMETRIC: the tire is evaluated as it was measured"
    for key, same in SAME.items():
        if unquoted(entries.get(key, "")).upper() not in ("", *same):
            yield f"{key} = {quoted(unquoted(entries[key]))}: {STATED[key]}"
    for key in SAFETY:
        number, _ = number_and_rest(entries.get(key, "0"))
        if number != 0.0:
            yield f"{key} = {excerpt(entries[key])}: MF-Tyre limits forces outside the range, tirefmu does not"


def _mode(value: str) -> Iterator[str]:
    number, _ = number_and_rest(value)
    if math.isnan(number) or number != int(number):
        yield f"USE_MODE = {quoted(unquoted(value))} is no whole number: tirefmu computes all forces with combined slip"
        return
    digit = abs(int(number)) % 10
    if digit in USE_MODES:
        computed = f"other programs compute {USE_MODES[digit]}"
        yield f"USE_MODE = {number:g}: {computed}, tirefmu all forces with combined slip"
    elif digit not in COMPLETE:
        yield f"USE_MODE = {number:g} is unknown: tirefmu computes all forces with combined slip"
    if number < 0:
        yield f"USE_MODE = {number:g}: other programs mirror the tire, tirefmu only on request (--mirror)"
