"""Dimensions: a tire in other units of force, length and time is the same tire.

Every coefficient, input and line carries a unit. With forces counted in units of a newton, lengths in units of b
metres and time in units of c seconds, each number changes by its power of a, b and c; a wrong unit or formula
violates this.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

#: Pounds-force, feet and minutes.
POWERS = {"1": 1.0, "": 1.0, "rad": 1.0, "N": 1 / 4.448, "m": 1 / 0.3048, "s": 1 / 60.0}
POWERS["Pa"] = POWERS["N"] / POWERS["m"] ** 2
#: zeta_8 is 1 + a moment in the book, of which D_r takes 1 off again: no one factor changes it.
MIXED = {"zeta_8"}
#: MF5.2 to 6.2 add 1e-6 of whatever unit to divisors: to a speed (2 m/s at least here, 5e-7 of it), to forces, and
#: in the book's (4.104) to the moment by spin. MF96 has no such terms.
ERRORS = {"mf96": 1e-9, "mf52": 2e-6, "mf61": 2e-6, "mf62": 2e-6}
OPTIONS = ({}, {"convention": "book"}, {"slip_angle": "angle"}, {"limits": True})


def factor(unit):
    """Return the factor by which a number changes; an angle has no dimension."""
    over, _, under = unit.partition("/")
    return product(over) / product(under)


def product(unit):
    bases = [base.partition("^") for base in unit.split(" ")]
    return np.prod([POWERS[base] ** int(power or 1) for base, _, power in bases])


def slow_and_flat(tire):
    """Return the tire with many of the rows below VXLOW, and bottoming."""
    hard = {"VXLOW": 5.0, "RIM_RADIUS": 0.95 * tire.values["UNLOADED_RADIUS"]}
    return replace(tire, values={**tire.values, **{name: hard[name] for name in hard if name in tire.values}})


@pytest.mark.parametrize("options", OPTIONS, ids=lambda options: "-".join(map(str, options.values())) or "default")
def test_other_units_of_force_length_and_time(magic_tire, points, narrowed, options):
    if "limits" in options:
        magic_tire = slow_and_flat(narrowed(magic_tire))
    rows = points(magic_tire)
    table = pd.DataFrame(dict(zip(magic_tire.inputs, rows, strict=True)))
    units = {quantity.name: quantity.unit for quantity in magic_tire.symbolic_model.inputs}
    units |= {line.symbol.name: line.unit for line in magic_tire.symbolic_model.equations}
    values = {
        name: magic_tire.values[name] * factor(declaration.unit)
        for name, declaration in magic_tire.symbolic_model.coefficients.items()
    }
    ranges = {name: tuple(end * factor(units[name]) for end in ends) for name, ends in magic_tire.ranges.items()}
    answer = replace(magic_tire, values=values, ranges=ranges).evaluate(
        table.assign(**{name: table[name] * factor(units[name]) for name in table}), signs=magic_tire.signs, **options
    )
    error = ERRORS[magic_tire.model]
    for name, column in magic_tire.evaluate(table, signs=magic_tire.signs, **options).items():
        if name not in MIXED:
            expected = column.to_numpy() * factor(units[name])
            # relative to the column: a sum of large parts may be small
            size = np.abs(expected).max()
            assert np.isfinite(size), name
            np.testing.assert_allclose(answer[name], expected, rtol=error, atol=error * size, err_msg=name)
