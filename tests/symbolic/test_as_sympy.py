"""What the printers compute themselves because SymPy takes several times as long is the same as in SymPy."""

from __future__ import annotations

import pytest
import sympy as sp
from sympy.printing.codeprinter import CodePrinter
from sympy.printing.str import StrPrinter

from tirefmu.symbolic.functions import absolute, expm1, sgn, sgn1, where
from tirefmu.symbolic.model.lines import replaced
from tirefmu.symbolic.notation import Switch
from tirefmu.symbolic.printers.derivatives import ONE, _derivative, _product
from tirefmu.symbolic.printers.expressions import NumpyPrinter, PlainCPrinter

x, y, z = sp.symbols("x y z", real=True)
THIRD = sp.Rational(1, 3)

EXPRESSIONS = [
    -x * y, -2 * x * (y + 1), x * y / 3, -(x**2), -1 / (x * y), -x / (y + z), sp.Float("0.5") * x,
    -sp.Float("0.5") * x * y,
    x * where(y > 0, x, z), -where(y > 0, x, z) / 2, x * sp.sqrt(y) * (y + z) ** 2, x**THIRD * y, -(x**THIRD),
    x ** (-THIRD) * y, x**y * z, x ** (-y) * z, -sp.pi * x, sp.pi**2 * x / 2, x * sp.exp(-y) * sgn(z), -sgn1(x) * y,
    sp.Mul(-1, x + y, evaluate=False), sp.Mul(2, sp.Mul(-1, x, evaluate=False), evaluate=False),
    -x - y * z + 2, -3 * x + THIRD * y, sp.Add(x, -(y + z), evaluate=False), absolute(x) - expm1(y) / z,
    -sp.tan(x) - sp.log(y),
    (x + y) * (x - z) * sp.cos(x) / (1 + x**2) ** 2, sp.sqrt(x**2 + 1) ** 3, sp.acos(x * y) ** 2,
    where(x <= 0, x**2, sp.atan(x) / y),
]  # fmt: skip


def slow(printer):
    """Return a class of printers with SymPy's own sums and products."""
    return type("Slow", (printer,), {"_print_Add": StrPrinter._print_Add, "_print_Mul": CodePrinter._print_Mul})


@pytest.mark.parametrize("printer", [NumpyPrinter, PlainCPrinter])
def test_sums_and_products_are_printed_the_same(printer):
    for expression in EXPRESSIONS:
        assert printer().doprint(expression) == slow(printer)().doprint(expression), expression


def test_derivatives_are_the_same():
    for expression in EXPRESSIONS:
        for by in (x, y, z):
            assert _derivative(expression, by) == sp.diff(expression, by), (expression, by)


def test_products_are_the_same():
    factors = [ONE, -ONE, sp.pi, x, -x, y, -y, 2 / sp.pi]
    assert all(_product(a, b) == a * b and _product(a, b).args == (a * b).args for a in factors for b in factors)


def test_switches_are_replaced_the_same():
    def side(effect, on, off):
        return on if effect.name == "heat" else off

    heat, wear = sp.symbols("heat wear")
    inner = Switch(wear, x + y, 0)
    for expression in (
        Switch(heat, x * inner, z),
        1 + y * Switch(wear, x, inner),
        sp.sin(Switch(heat, 0, x)) + y,
        x * y,
    ):
        assert replaced(expression, Switch, side) == expression.replace(Switch, side)
