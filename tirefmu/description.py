"""What is in a tire, as plain values: for ``tirefmu info``."""

from __future__ import annotations

from typing import Any

from tirefmu.tires import Tire


def describe(tire: Tire) -> dict[str, Any]:
    """Return what is in a tire: model, effects, ranges, coefficients at neutral or beyond plausible bounds.

    Parameters
    ----------
    tire : Tire

    Returns
    -------
    dict of str to Any
        Plain JSON values.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> describe(published("trento_hoosier"))["model"]
    'mf96'
    """
    book, plain = tire.book, tire.in_signs("adapted-sae")
    cards = book.coefficients
    at_neutral = [
        name for name, card in cards.items() if card.neutral is not None and plain.values[name] == card.neutral
    ]
    idle = [name for name in book.effects if name in tire.has and book.owned(name) <= set(at_neutral)]
    outside = [
        {"name": name, "value": tire.values[name], "lower": card.lower, "upper": card.upper}
        for name, card in cards.items()
        if name not in at_neutral and not card.lower <= plain.values[name] <= card.upper
    ]
    return {
        "ok": True,
        "name": tire.name,
        "model": tire.model,
        "title": book.title,
        "signs": tire.signs,
        "about": dict(tire.about),
        "ranges": {name: list(bounds) for name, bounds in tire.ranges.items()},
        "effects": [name for name in book.effects if name in tire.has and name not in idle],
        "effects_at_neutral": idle,
        "effects_absent": [name for name in book.effects if name not in tire.has],
        "coefficients_at_neutral": at_neutral,
        "defaulted": list(tire.defaulted),
        "implausible": outside,
        "values": dict(tire.values),
    }
