"""The notation: the lines of a chapter, and their common shapes."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from tirefmu.symbolic.declarations import Coefficient, Effect, Section
from tirefmu.symbolic.notation import Chapter, magic, smooth_sign

x = sp.Symbol("x", real=True)


def evaluated(eq, expression, at):
    """Return the values of an expression at the points, from its recorded steps in order."""
    space = {"x": at}
    for line in eq.equations:
        names = sorted(line.expression.free_symbols, key=str)
        space[line.symbol.name] = sp.lambdify(names, line.expression)(*(space[str(name)] for name in names))
    names = sorted(expression.free_symbols, key=str)
    return sp.lambdify(names, expression)(*(space[str(name)] for name in names))


@pytest.fixture
def curve():
    eq = Chapter("A curve")
    B, C, D, E = map(sp.Float, (10, 1.4, 2, -0.5))
    return eq, magic(eq, "y", B, C, D, E, x)


def test_the_magic_formula_begins_with_slope_BCD(curve):
    eq, formula = curve
    assert evaluated(eq, formula.sine, np.array([0.0])) == [0]
    assert evaluated(eq, formula.slope, np.array([0.0])) == pytest.approx([10 * 1.4 * 2])
    assert evaluated(eq, formula.cosine, np.array([0.0])) == [2]


def test_the_magic_formula_peaks_at_D_and_ends_at_D_sin_C_half_pi(curve):
    eq, formula = curve
    values = evaluated(eq, formula.sine, np.linspace(0, 2, 20001))
    assert values.max() == pytest.approx(2, abs=1e-6)
    assert evaluated(eq, formula.sine, np.array([1e9])) == pytest.approx([2 * np.sin(1.4 * np.pi / 2)])


def test_the_slope_is_the_derivative_where_E_is_constant(curve):
    eq, formula = curve
    at, h = np.linspace(-1, 1, 101), 1e-6
    difference = (evaluated(eq, formula.sine, at + h) - evaluated(eq, formula.sine, at - h)) / (2 * h)
    np.testing.assert_allclose(evaluated(eq, formula.slope, at), difference, atol=1e-7)


def test_the_smooth_sign_is_odd_and_saturates():
    eq = Chapter("A sign")
    sign = smooth_sign(eq, "sign_x", x)
    values = evaluated(eq, sign, np.array([-1.0, -1e-3, 0.0, 1e-3, 1.0]))
    np.testing.assert_allclose(values, [-1, -np.sqrt(0.5), 0, np.sqrt(0.5), 1], atol=1e-6)


def test_a_section_collects_its_coefficients_in_order():
    class Made(Section, title="MADE"):
        B = Coefficient("second letter", start=2.0, neutral=None)
        A = Coefficient("first letter", neutral=1.0)
        C = Coefficient("third letter", start=3.0)
        D = Coefficient("no value at all", neutral=None)

    assert list(Made.coefficients) == ["B", "A", "C", "D"]
    assert [declaration.section for declaration in Made.coefficients.values()] == ["MADE"] * 4
    assert [Made.coefficients[name].default for name in "BAC"] == [2.0, 1.0, 0.0]
    assert [Made.coefficients[name].generic for name in "BAC"] == [2.0, 1.0, 3.0]
    assert np.isnan(Made.coefficients["D"].default)
    assert sp.Symbol("A", real=True) == Made.A


def test_an_effect_is_a_switch_in_a_line():
    effect = Effect("wear_drift", "the tread wears")
    assert effect.term(x).args[1:] == (x, 0)
    assert effect.factor(x).args[1:] == (x, 1)
    assert effect.either(x, 2 * x).args[1:] == (x, 2 * x)


def test_a_chapter_files_lines_in_order():
    eq = Chapter("A chapter")
    y = eq("1", "y", x + 1, "m", "a line")
    eq("2", "z", 2 * y, named=False)
    assert [(line.number, str(line.symbol), line.unit, line.chapter, line.named) for line in eq.equations] == [
        ("1", "y", "m", "A chapter", True),
        ("2", "z", "1", "A chapter", False),
    ]
    assert eq.equations[1].expression == 2 * y  # the symbol, not x + 1
