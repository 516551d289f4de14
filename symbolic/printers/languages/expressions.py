"""How an expression is written in the languages of other programs."""

from __future__ import annotations

from typing import Any, ClassVar

import sympy as sp
from sympy.printing.precedence import PRECEDENCE

from ..expressions import CallPrinter


class C99Printer(CallPrinter):
    """C99 in double precision with the functions of math.h.

    >>> C99Printer().doprint(sp.atan(sp.Symbol("B_x")) / 3)
    '0.3333333333333333*atan(B_x)'
    """

    names: ClassVar[dict[str, str]] = {"absolute": "fabs", **{name: f"tirefmu_{name}" for name in CallPrinter.defined}}


class CppPrinter(CallPrinter):
    """C++ with a template parameter Scalar; functions are found by the type of their argument.

    >>> CppPrinter().doprint(sp.Piecewise((2, sp.Symbol("x") > 0), (sp.Symbol("x"), True)))
    'Math::choose(x > Scalar(0.0), Scalar(2.0), x)'
    """

    names: ClassVar[dict[str, str]] = {
        "absolute": "Math::absolute",
        **{name: f"Math::{name}" for name in ("sgn", "sgn1", "square", "cube", "fourth", "cubed_sqrt")},
    }
    choice = "Math::choose({condition}, {then}, {otherwise})"
    number = "Scalar({})"

    def _print_SmallestSquare(self, expr: Any) -> str:
        return "Math::smallest_square()"


class JavaScriptPrinter(CallPrinter):
    """JavaScript.

    >>> JavaScriptPrinter().doprint(sp.sqrt(sp.Symbol("x")) + sp.Symbol("y") ** 2)
    'Math.sqrt(x) + square(y)'
    """

    names: ClassVar[dict[str, str]] = {"absolute": "abs"}
    prefix = "Math."
    equal = "==="


class RustPrinter(CallPrinter):
    """Rust with the functions of the crate libm, which needs no standard library.

    >>> RustPrinter().doprint(sp.Piecewise((sp.exp(sp.Symbol("x")), sp.Symbol("x") < 0), (1, True)))
    '(if x < 0.0 { libm::exp(x) } else { 1.0 })'
    """

    prefix = "libm::"
    choice = "(if {condition} {{ {then} }} else {{ {otherwise} }})"


class MatlabPrinter(CallPrinter):
    """MATLAB and Octave, element by element of arrays.

    >>> x, y = sp.symbols("x y")
    >>> MatlabPrinter().doprint(2 * x * y / (1 + x**2))
    '2.0.*x.*y./(1.0 + x.^2.0)'
    >>> MatlabPrinter().doprint(x ** (1 / y)), MatlabPrinter().doprint((x**y) ** (y**-2))
    ('x.^(1.0./y)', 'x.^y.^(y.^(-2.0))')
    >>> MatlabPrinter().doprint(sp.Piecewise((1, sp.And(x > 0, y > 0)), (x / 3, True)))
    'choose((x > 0.0) & (y > 0.0), 1.0, 0.3333333333333333.*x)'
    """

    names: ClassVar[dict[str, str]] = {"absolute": "abs", "sgn": "sign"}
    choice = "choose({condition}, {then}, {otherwise})"
    conjunction, disjunction = " & ", " | "
    pi = "pi"

    def _print_Mul(self, expr: Any) -> str:
        # A star or a slash occurs only in an operator: arguments have no texts.
        return str(super()._print_Mul(expr)).replace(".*", "*").replace("./", "/").replace("*", ".*").replace("/", "./")

    def _print_Pow(self, expr: Any) -> str:
        if expr.exp == -1:
            return f"1.0./{self.parenthesize(expr.base, PRECEDENCE['Mul'], strict=True)}"
        if abs(expr.exp) == sp.Rational(1, 2):
            text = self._call("sqrt", expr.base)
            return text if expr.exp > 0 else f"1.0./{text}"
        # Powers are read from the left: x.^y.^z is (x.^y).^z.
        base = self.parenthesize(expr.base, PRECEDENCE["Pow"], strict=True)
        exponent = self.parenthesize(expr.exp, PRECEDENCE["Pow"])
        return f"{base}.^{exponent if not exponent.startswith('-') else f'({exponent})'}"


class ModelicaPrinter(CallPrinter):
    """Modelica, with brackets around every power: the operator is not associative.

    >>> x, y = sp.symbols("x y")
    >>> ModelicaPrinter().doprint(2 * x**2 / (1 + x ** (1 / y)))
    '2.0*x^2/(1.0 + x^(1.0/y))'
    >>> ModelicaPrinter().doprint(sp.Piecewise((1, sp.And(x > 0, y > 0)), (sp.sqrt(x) ** y, True)))
    '(if (x > 0.0) and (y > 0.0) then 1.0 else x^(0.5*y))'
    """

    names: ClassVar[dict[str, str]] = {"absolute": "abs", "sgn": "sign"}
    choice = "(if {condition} then {then} else {otherwise})"
    conjunction, disjunction = " and ", " or "

    def _print_Pow(self, expr: Any) -> str:
        if expr.exp.is_negative:
            base = self._print(expr.base**-expr.exp) if expr.exp != -1 else self._bracketed(expr.base, "Mul")
            return f"1.0/{base}"
        if expr.exp == sp.Rational(1, 2):
            return self._call("sqrt", expr.base)
        exponent = str(expr.exp) if expr.exp.is_Integer else self._bracketed(expr.exp, "Pow")
        return f"{self._bracketed(expr.base, 'Pow')}^{exponent}"

    def _bracketed(self, expr: Any, than: str) -> str:
        """Return the text of a part that binds more strongly than an operator."""
        text: str = self.parenthesize(expr, PRECEDENCE[than], strict=False)
        return f"({text})" if text.startswith("-") else text
