"""What a coefficient starts from, its size for the solver, and whether rows of measurement see it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tirefmu.symbolic.notation import Coefficient
from tirefmu.tires.code import fastest_code
from tirefmu.tires.tire import Tire

from .problem import Rows


def generic(card: Coefficient) -> float:
    """Return where a coefficient starts: its card's start, else what readers assume, else its default."""
    if card.start is not None or card.assumed is None:
        return card.generic
    assumed = -card.assumed if card.flips else card.assumed  # cards tell that in ISO-W
    return min(max(assumed, card.lower), card.upper)


def size(lower: float, upper: float, guess: float) -> float:
    """Return the size of a coefficient for the solver: a quarter of its card's range, not less than its guess."""
    span = upper - lower
    return max(abs(guess), 0.25 * span if np.isfinite(span) else 1.0, 1e-3)


def influence(tire: Tire, rows: Rows, names: Sequence[str]) -> set[str]:
    """Return the coefficients that change some measured force at these rows.

    Looked at from the present values and from two random points beside them: where a factor is at neutral,
    what it multiplies shows nothing, though it may once the factor moves.
    """
    book, code = tire.book, fastest_code(tire.book)
    order = list(book.parameters)
    cards = [book.coefficients[name] for name in names]
    columns, factors = np.array([order.index(name) for name in names]), tire.rescaled
    sizes = np.array([size(c.lower, c.upper, tire.values[c.name]) * factors.get(c.name, 1.0) for c in cards])
    there = np.isfinite(rows.measured)
    forces = np.sqrt(np.sum(np.where(there, rows.measured, 0.0) ** 2, axis=0) / np.maximum(there.sum(axis=0), 1))
    random = np.random.default_rng(0)
    seen = np.zeros(len(names), dtype=bool)
    for reach in (0.0, 0.1, 0.1):
        parameters = tire.parameters()
        parameters[columns] += reach * sizes * random.uniform(-1.0, 1.0, len(names))
        jacobian = code.jacobian_parameters(rows.inputs, parameters)[:, :, columns]
        change = np.where(there[:, :, None], np.nan_to_num(jacobian), 0.0) * sizes
        seen |= np.max(np.abs(change) / np.where(forces > 0, forces, np.inf)[:, None], axis=(0, 1)) > 1e-6
    return {name for name, it_is in zip(names, seen, strict=True) if it_is}
