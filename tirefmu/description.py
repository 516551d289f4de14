"""What is in a tire, as plain values: for ``tirefmu info``."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from typing import Any

from tirefmu.tires import Tire
from tirefmu.tires.property_file.names import MOST_SEARCHED, OWN_SECTIONS, near_miss, not_given, unit_of

from .implausible import implausible

#: Sections that say nothing of the tire itself, or are told otherwise.
_OURS = ("MDI_HEADER", *OWN_SECTIONS)


def describe(tire: Tire, notes: Iterable[str] = ()) -> dict[str, Any]:
    """Return what is in a tire: model, effects, ranges, where its values come from, what looks implausible.

    Parameters
    ----------
    tire : Tire
    notes : iterable of str
        What reading its file had to tell.

    Returns
    -------
    dict of str to Any
        Plain JSON values. ``missing`` has what was taken for the coefficients that nobody gave; ``unknown``
        the keys of the file that nothing here knows, with the coefficient that they almost are; ``unused`` those
        of the field that this model does not read; ``tables`` the sections with lines that are no keys.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> told = describe(published("trento_hoosier"))
    >>> told["model"], told["nominal"]["Fz"], [doubt["name"] for doubt in told["implausible"]]
    ('mf96', 220.0, ['E_t'])
    """
    book, plain = tire.book, tire.in_signs("adapted-sae")
    cards = book.coefficients
    at_neutral = [
        name for name, card in cards.items() if card.neutral is not None and plain.values[name] == card.neutral
    ]
    idle = [name for name in book.effects if name in tire.has and book.owned(name) <= set(at_neutral)]
    kept = tire.kept
    entries = [
        {"section": section, "key": key, "value": value} for section, key, value in kept if key and section not in _OURS
    ]
    unknown = [entry for entry in entries if unit_of(entry["key"]) is None]
    near = {entry["key"]: near_miss(entry["key"], cards) for entry in unknown[:MOST_SEARCHED]}
    return {
        "ok": True,
        "name": tire.name,
        "model": tire.model,
        "title": book.title,
        "signs": tire.signs,
        "side": tire.side,
        "about": dict(tire.about),
        "nominal": {quantity.name: tire.nominal(quantity.name) for quantity in book.inputs},
        "ranges": {name: list(bounds) for name, bounds in tire.ranges.items()},
        "effects": [name for name in book.effects if name in tire.has and name not in idle],
        "effects_at_neutral": idle,
        "effects_absent": [name for name in book.effects if name not in tire.has],
        "coefficients_at_neutral": at_neutral,
        "missing": {name: tire.values[name] for name in not_given(tire)},
        "unknown": [{**entry, "near": near.get(entry["key"])} for entry in unknown],
        "unused": [e for e in entries if unit_of(e["key"]) is not None],
        "tables": list(dict.fromkeys(section for section, key, _ in kept if not key)),
        "notes": list(notes),
        "implausible": [
            {"name": doubt.name, "value": doubt.value if isfinite(doubt.value) else None, "reason": doubt.reason}
            for doubt in implausible(tire)
        ],
        "values": dict(tire.values),
    }
