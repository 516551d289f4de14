"""Expressions are printed in Python and in C with the same value."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp

from tirefmu.symbolic.functions import absolute, sgn, sgn1
from tirefmu.symbolic.printers.expressions import CasadiPrinter, NumpyPrinter, PlainCPrinter

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
    -sp.atan(x) - y: ("-y - np.atan(x)", "-y - fast_atan(x)"),
    x - (y - z) * 2: ("x - 2*y + 2*z", "x - 2.0*y + 2.0*z"),
    HALF * x: ("0.5*x", "0.5*x"),
    -HALF * x: ("-0.5*x", "-0.5*x"),
    sp.Float("1e-6") + x: ("1e-06 + x", "1e-06 + x"),
    x * sp.cos(y) / sp.cos(z): ("x*np.cos(y)/np.cos(z)", "x*fast_cos(y)/fast_cos(z)"),
    x**4: ("x**4", "fourth(x)"),
    x**y: ("x**y", "pow(x, y)"),
    sp.cos(sp.atan(x)): ("1/np.sqrt(1 + x**2)", "1.0/sqrt(1.0 + square(x))"),
    sp.sin(sp.atan(x)): ("x/np.sqrt(1 + x**2)", "x/sqrt(1.0 + square(x))"),
    sp.tan(x) * sp.log(y): ("np.log(y)*np.tan(x)", "log(y)*fast_tan(x)"),
    sp.acos(z) / sp.pi: ("np.acos(z)/np.pi", "acos(z)/PI"),
    sgn(z) + absolute(z): ("np.abs(z) + np.sign(z)", "fabs(z) + sgn(z)"),
    sgn1(z): ("np.where(z >= 0, 1, np.sign(z))", "sgn1(z)"),
    sp.Piecewise((x, sp.Or(sp.And(x > 1, y < 2), sp.Eq(z, 0))), (y, True)): (
        "np.where(np.logical_or(z == 0, np.logical_and(x > 1, y < 2)), x, y)",
        "((z == 0.0) || ((x > 1.0) && (y < 2.0)) ? x : y)",
    ),
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
    expected = float(
        expression.subs({sp.Symbol(name, real=True): sp.Float(value, 30) for name, value in POINT.items()})
    )
    python = NumpyPrinter().doprint(expression)
    assert float(eval(python, {"np": np, **POINT})) == pytest.approx(expected, rel=1e-14)
    if "?" not in PlainCPrinter().doprint(expression):  # other C expressions are valid Python
        powers = {"square": lambda a: a * a, "cube": lambda a: a**3, "fourth": lambda a: a**4}
        powers |= {"cubed_sqrt": lambda a: a * math.sqrt(a), "PI": math.pi}
        powers |= {f"fast_{name}": getattr(math, name) for name in ("sin", "cos", "tan", "atan")}
        powers |= {"sgn": np.sign, "sgn1": lambda a: 1.0 if a >= 0 else -1.0}
        c = PlainCPrinter().doprint(expression)
        assert eval(c, {**vars(math), **powers, **POINT}) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("power", [-3, 4, sp.Rational(5, 2)])
def test_other_powers_are_still_right_in_python(power):
    text = NumpyPrinter().doprint((x + 1) ** power * y)
    assert float(eval(text, {"np": np, **POINT})) == pytest.approx(1.7 ** float(power) * 1.3, rel=1e-14)


def test_casadi_combines_conditions_and_propagates_nan():
    both = sp.Piecewise((x, sp.And(x > 1, y < 2)), (sgn1(y), True))
    text = CasadiPrinter().doprint(both)
    assert text == "ca.if_else(ca.logic_and(x > 1, y < 2), x, ca.if_else(y >= 0, 1, ca.sign(y)))"
    assert math.isnan(float(eval(NumpyPrinter().doprint(sgn1(x)), {"np": np, "x": math.nan})))
