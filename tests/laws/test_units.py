"""Dimensions: a tire told in other units of force and length is the same tire.

Every coefficient, input and line carries a unit. With forces counted in units of a newton and lengths in units
of b metres, each number changes by its own power of a and b; a wrong unit or formula does not follow.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

A, B = 1 / 4.448, 1 / 0.3048  # pounds-force and feet


def factor(unit):
    """Return by what a number changes; an angle has no dimension."""
    over, _, under = unit.partition("/")
    powers = {"1": 1.0, "rad": 1.0, "rad^2": 1.0, "": 1.0, "N": A, "m": B, "N m": A * B}
    return powers[over] / powers[under]


def test_other_units_of_force_and_length(tire, points):
    rows = points(tire)
    table = pd.DataFrame(dict(zip(tire.inputs, rows, strict=True)))
    units = {quantity.name: quantity.unit for quantity in tire.book.inputs}
    units |= {line.symbol.name: line.unit for line in tire.book.equations}
    values = {name: tire.values[name] * factor(card.unit) for name, card in tire.book.coefficients.items()}
    told = replace(tire, values=values).evaluate(
        table.assign(**{name: table[name] * factor(units[name]) for name in table}), signs=tire.signs
    )
    for name, column in tire.evaluate(table, signs=tire.signs).items():
        expected = column.to_numpy() * factor(units[name])
        # relative to the column: a sum of large parts may be small
        assert told[name].to_numpy() == pytest.approx(expected, rel=1e-9, abs=1e-11 * np.abs(expected).max()), name
