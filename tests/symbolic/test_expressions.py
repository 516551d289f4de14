"""How expressions are written in Python and in C, and that both still mean the same number."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp

from tirefmu.symbolic.printers.expressions import NumpyPrinter, PlainCPrinter

x, y, z = sp.symbols("x y z", real=True)
HALF = sp.Rational(1, 2)

EXPRESSIONS = {
    x**2 * y: ("y*x**2", "y*square(x)"),
    x**3: ("x**3", "cube(x)"),
    (x + y) ** 2: ("(x + y)**2", "square(x + y)"),
    x / (y * z**2): ("x/(y*z**2)", "x/(y*square(z))"),
    1 / sp.sqrt(x): ("1/np.sqrt(x)", "1.0/sqrt(x)"),
    x / sp.sqrt(y + 1): ("x/np.sqrt(1 + y)", "x/sqrt(1.0 + y)"),
    x / (y + 1) ** (3 * HALF): ("x/(1 + y)**1.5", "x/cubed_sqrt(1.0 + y)"),
    (x + 1) ** (3 * HALF): ("(1 + x)**1.5", "cubed_sqrt(1.0 + x)"),
    sp.exp(-x * y): ("np.exp(-x*y)", "exp(-x*y)"),
    -sp.atan(x) - y: ("-y - np.atan(x)", "-y - atan(x)"),
    x - (y - z) * 2: ("x - 2*y + 2*z", "x - 2.0*y + 2.0*z"),
    HALF * x: ("0.5*x", "0.5*x"),
    -HALF * x: ("-0.5*x", "-0.5*x"),
    sp.Float("1e-6") + x: ("1e-06 + x", "1e-06 + x"),
    x * sp.cos(y) / sp.cos(z): ("x*np.cos(y)/np.cos(z)", "x*cos(y)/cos(z)"),
    sp.Piecewise((0, x <= 1), (y + z, True)): ("np.where(x <= 1, 0, y + z)", "(x <= 1.0 ? 0.0 : y + z)"),
}
POINT = {"x": 0.7, "y": 1.3, "z": -0.4}


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
def test_text(expression):
    python, c = EXPRESSIONS[expression]
    assert NumpyPrinter().doprint(expression) == python
    assert PlainCPrinter().doprint(expression) == c


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
def test_meaning(expression):
    expected = float(expression.subs({sp.Symbol(name, real=True): value for name, value in POINT.items()}))
    python = NumpyPrinter().doprint(expression)
    assert float(eval(python, {"np": np, **POINT})) == pytest.approx(expected, rel=1e-14)
    if "?" not in PlainCPrinter().doprint(expression):  # the rest of C's expressions reads as Python
        powers = {"square": lambda a: a * a, "cube": lambda a: a**3, "cubed_sqrt": lambda a: a * math.sqrt(a)}
        c = PlainCPrinter().doprint(expression)
        assert eval(c, {**vars(math), **powers, **POINT}) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("power", [-3, 4, sp.Rational(5, 2)])
def test_other_powers_are_still_right_in_python(power):
    text = NumpyPrinter().doprint((x + 1) ** power * y)
    assert float(eval(text, {"np": np, **POINT})) == pytest.approx(1.7 ** float(power) * 1.3, rel=1e-14)
