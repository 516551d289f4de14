"""How an expression is written in the languages of other programs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import sympy as sp
from sympy.printing.precedence import PRECEDENCE

from ..expressions import CALLED_POWERS, PlainCPrinter


class CallPrinter(PlainCPrinter):
    """Scalar text in which every function is a call; a language names the functions and writes choices.

    `members`: what is written for a symbol that is a member of a structure, by its name.

    >>> x, y = sp.symbols("x y")
    >>> CallPrinter().doprint(sp.Piecewise((sp.sin(x) ** 2, x > 0), (1 / y, True)))
    '(x > 0.0 ? square(sin(x)) : 1.0/y)'
    >>> CallPrinter({"x": "inputs.x"}).doprint(x * y)
    'inputs.x*y'
    """

    #: Names of functions that differ from SymPy's.
    names: ClassVar[dict[str, str]] = {"absolute": "fabs"}
    #: Prefix of the functions that the language has.
    prefix = ""
    #: Functions that the printout defines.
    defined: ClassVar[frozenset[str]] = frozenset(["square", "cube", "fourth", "cubed_sqrt", "sgn", "sgn1"])
    choice = "({condition} ? {then} : {otherwise})"
    conjunction, disjunction, equal = " && ", " || ", "=="
    number = "{}"
    pi = "3.141592653589793"

    def __init__(self, members: Mapping[str, str] | None = None) -> None:
        super().__init__()
        self._members = dict(members or {})

    def _print_Symbol(self, expr: Any) -> str:
        return self._members.get(expr.name) or str(super()._print_Symbol(expr))

    def _call(self, name: str, *arguments: Any) -> str:
        called = self.names.get(name, name)
        prefix = "" if called in self.defined else self.prefix
        return f"{prefix}{called}({', '.join(self._print(argument) for argument in arguments)})"

    def _print_called(self, expr: Any) -> str:
        return self._call(expr.func.__name__, *expr.args)

    _print_sin = _print_cos = _print_tan = _print_atan = _print_acos = _print_exp = _print_log = _print_called
    _print_sgn = _print_sgn1 = _print_absolute = _print_called

    def _print_Pow(self, expr: Any) -> str:
        if expr.exp == -1:
            return f"{self._print(sp.Integer(1))}/{self.parenthesize(expr.base, PRECEDENCE['Mul'], strict=True)}"
        called = CALLED_POWERS.get(abs(expr.exp))
        if called is None:
            return self._call("pow", expr.base, expr.exp)
        text = self._call(called, expr.base)
        return text if expr.exp > 0 else f"{self._print(sp.Integer(1))}/{text}"

    def _print_Integer(self, expr: Any) -> str:
        return self._signed(f"{abs(expr.p)}.0", expr.p < 0)

    def _print_Rational(self, expr: Any) -> str:
        return self._signed(repr(abs(expr.p / expr.q)), expr.p < 0)

    def _print_Float(self, expr: Any) -> str:
        return self._signed(repr(abs(float(expr))), float(expr) < 0)

    def _print_Literal(self, expr: Any) -> str:
        text = self._signed(repr(abs(expr.value)), expr.value < 0)
        return f"({text})" if expr.value < 0 else text

    def _print_Pi(self, expr: Any) -> str:
        return self.number.format(self.pi)

    def _signed(self, text: str, negative: bool) -> str:
        return f"{'-' if negative else ''}{self.number.format(text)}"

    def _print_Relational(self, expr: Any) -> str:
        operator = self.equal if expr.rel_op == "==" else expr.rel_op
        return f"{self._print(expr.lhs)} {operator} {self._print(expr.rhs)}"

    def _print_And(self, expr: Any) -> str:
        return self.conjunction.join(f"({self._print(arg)})" for arg in expr.args)

    def _print_Or(self, expr: Any) -> str:
        return self.disjunction.join(f"({self._print(arg)})" for arg in expr.args)

    def _print_Piecewise(self, expr: Any) -> str:
        (value, condition), (otherwise, _) = expr.args
        parts = {"condition": condition, "then": value, "otherwise": otherwise}
        return self.choice.format(**{name: self._print(part) for name, part in parts.items()})


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
