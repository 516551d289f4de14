"""Generic value and typical size of a coefficient, and its influence on the forces at measured rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...symbolic.declarations import Coefficient
from ...tires.code import CHUNK, fastest_code
from ...tires.tire import Tire
from .rows import Rows


def generic(declaration: Coefficient) -> float:
    """Return the generic value of a coefficient: its start, else the value that readers assume, else its default."""
    if declaration.start is not None or declaration.assumed is None:
        return declaration.generic
    assumed = -declaration.assumed if declaration.flips else declaration.assumed  # declared in ISO-W
    return min(max(assumed, declaration.lower), declaration.upper)


def typical_size(lower: float, upper: float, guess: float) -> float:
    """Return the typical size of a coefficient: a quarter of its range, at least the magnitude of its guess."""
    span = upper - lower
    return max(abs(guess), 0.25 * span if np.isfinite(span) else 1.0, 1e-3)


def influence(tire: Tire, rows: Rows, names: Sequence[str]) -> set[str]:
    """Return the coefficients that influence a measured force at these rows.

    The Jacobian is evaluated at the present values and at two random points nearby: if a factor is 0, the coefficients
    that it multiplies have no influence at the present values.
    """
    model, code = tire.symbolic_model, fastest_code(tire.symbolic_model)
    order = list(model.parameters)
    declarations = [model.coefficients[name] for name in names]
    columns, factors = np.array([order.index(name) for name in names], dtype=int), tire.rescaled
    sizes = np.array(
        [typical_size(c.lower, c.upper, tire.values[c.name]) * factors.get(c.name, 1.0) for c in declarations]
    )
    present = np.isfinite(rows.measured)
    squares = np.sum(np.where(present, rows.measured, 0.0) ** 2, axis=0)
    forces = np.sqrt(np.where(squares > 0, squares, np.inf) / np.maximum(present.sum(axis=0), 1))
    force, coefficient = code.entries
    reach_of_each = np.zeros(len(order))
    reach_of_each[columns] = sizes
    random = np.random.default_rng(0)
    seen: set[int] = set()
    for reach in (0.0, 0.1, 0.1):
        parameters, most = tire.parameters(), np.zeros(code.entries.shape[1])
        parameters[columns] += reach * sizes * random.uniform(-1.0, 1.0, len(names))
        for chunk, jacobian in code.jacobian_chunks(rows.inputs, parameters, CHUNK):
            most = np.fmax(most, np.fmax.reduce(np.where(present[chunk].T[force], np.abs(jacobian), 0.0), axis=1))
        seen.update(coefficient[most * reach_of_each[coefficient] > 1e-6 * forces[force]].tolist())
        if seen.issuperset(columns.tolist()):
            break
    return {name for name, column in zip(names, columns, strict=True) if int(column) in seen}
