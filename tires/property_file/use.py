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
#: The section of factors, 1 without influence, by which other programs scale forces: LGAY in PAC2002.
SCALES = "SCALING_COEFFICIENTS"
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
    scales = {key: value for section, key, value in tire.other_entries if section == SCALES and key.startswith("L")}
    ignored = [f"{key} = {excerpt(value)}" for key, value in scales.items() if number_and_rest(value)[0] != 1.0]
    return (
        *_notes(tire, entries),
        *(f"{text}: other programs may scale forces by it, {tire.model} does not" for text in ignored),
    )


def transient_notes(tire: TireDefinition) -> list[str]:
    """Return a sentence if other programs let the slips of a file lag, by the tens of USE_MODE, and this tire does not.

    >>> from tirefmu.tires import Tire
    >>> entries = (("MODEL", "USE_MODE", "14"),)
    >>> transient_notes(Tire("mf61", {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}, other_entries=entries))
    ['USE_MODE = 14: other programs let the slips lag, this tire does not: it has no effect relax_*']
    """
    modes = [value for section, key, value in tire.other_entries if (section, key.upper()) == ("MODEL", "USE_MODE")]
    numbers = [number for number, _ in map(number_and_rest, modes) if number == number // 1]
    if tire.lags or not tire.symbolic_model.relaxing_effects or not any(abs(n) // 10 % 10 for n in numbers):
        return []
    return [
        f"USE_MODE = {numbers[0]:g}: other programs let the slips lag, this tire does not: it has no effect relax_*"
    ]


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
