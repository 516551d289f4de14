"""How an expression is written in each language: SymPy's printers with the conventions of the book."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import reduce
from typing import Any, ClassVar

import sympy as sp
from sympy.printing.c import C99CodePrinter
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.pycode import PythonCodePrinter
from sympy.printing.str import StrPrinter

#: Number of texts that a printer stores: those of a model, whose routines share most of their statements.
REMEMBERED = 8192


class NumberPrinter(StrPrinter):
    """Numbers as both languages write them: a fraction is one decimal number, which needs no brackets.

    Sums and products are printed as SymPy does in the order "none", in a fraction of its time.
    """

    def __init__(self, settings: dict[str, Any]) -> None:
        super().__init__(settings)
        self._texts: dict[Any, str] = {}

    def doprint(self, expr: Any, assign_to: None = None) -> str:
        """Return the text of an expression, without SymPy's search for expressions that lines never contain."""
        text = self._texts.get(expr)
        if text is not None:
            return text
        self._not_supported: set[Any] = set()
        self._number_symbols: set[Any] = set()
        text = str(self._print(expr))
        if self._not_supported:
            raise NotImplementedError(f"{type(self).__name__} cannot print {self._not_supported}")
        if len(self._texts) >= REMEMBERED:
            self._texts.clear()
        self._texts[expr] = text
        return text

    def parenthesize(self, item: Any, level: int, strict: bool = False) -> str:
        """Return the text of an operand; a fraction, printed as one number, needs no brackets."""
        if item.is_Symbol or (item.is_Rational and item > 0):
            return str(self._print(item))
        return str(super().parenthesize(item, level, strict))

    def _print_Add(self, expr: Any, order: None = None) -> str:
        texts = [f"({self._print(term)})" if term.is_Add else self._print(term) for term in expr.args]
        return texts[0] + "".join(f" - {text[1:]}" if text[0] == "-" else f" + {text}" for text in texts[1:])

    def _print_Mul(self, expr: Any) -> str:
        sign, factors = ("-", expr.args[1:]) if expr.args[0] is sp.S.NegativeOne else ("", expr.args)
        if all(map(_is_plain_factor, factors)):
            return sign + "*".join(
                f"({self._print(factor)})" if factor.is_Add else self._print(factor) for factor in factors
            )
        return str(super()._print_Mul(expr))

    def _print_Rational(self, expr: Any) -> str:
        return repr(expr.p / expr.q)

    def _print_Float(self, expr: Any) -> str:
        return repr(float(expr))

    def _print_Literal(self, expr: Any) -> str:
        return repr(expr.value) if expr.value >= 0 else f"({expr.value!r})"

    def _print_SmallestSquare(self, expr: Any) -> str:
        return repr(expr.double)

    def _print_Divisor(self, expr: Any) -> str:
        return str(self._print_Piecewise(expr))


def _is_plain_factor(factor: Any) -> bool:
    """Return whether a factor stays above the line, without brackets unless it is a sum."""
    if factor.is_Pow:
        return bool(factor.exp.is_Rational and factor.exp > 0)
    return bool(factor.is_Symbol or factor.is_Add or (factor.is_Function and not factor.is_Piecewise))


class ArrayPrinter(NumberPrinter, PythonCodePrinter):
    """Python text calling the elementary functions of a library of arrays, which the sub-classes name."""

    module = ""
    where = ""
    conjunction, disjunction = "logical_and", "logical_or"
    #: Functions with another name there.
    other_names: ClassVar[dict[str, str]] = {}

    def __init__(self) -> None:
        super().__init__({"fully_qualified_modules": False, "strict": True, "order": "none"})

    def _print_Function(self, expr: Any) -> str:
        name = expr.func.__name__
        return f"{self.module}.{self.other_names.get(name, name)}({', '.join(self._print(arg) for arg in expr.args)})"

    _print_sin = _print_cos = _print_tan = _print_atan = _print_acos = _print_Function
    _print_exp = _print_log = _print_sgn = _print_absolute = _print_expm1 = _print_Function

    def _print_sgn1(self, expr: Any) -> str:
        x = self._print(expr.args[0])
        # A comparison alone would turn NaN into a sign.
        return f"{self.where}({x} >= 0, 1, {self.module}.sign({x}))"

    def _print_Pi(self, expr: Any) -> str:
        return f"{self.module}.pi"

    def _print_Pow(self, expr: Any, rational: bool = False, sqrt: str = "sqrt") -> str:
        if expr.exp == sp.Rational(1, 2):
            return f"{self.module}.sqrt({self._print(expr.base)})"
        if expr.exp == -sp.Rational(1, 2):
            return f"1/{self.module}.sqrt({self._print(expr.base)})"
        if expr.exp == sp.Rational(3, 2):
            return f"{self.parenthesize(expr.base, PRECEDENCE['Pow'])}**1.5"
        return str(super()._hprint_Pow(expr, rational=rational, sqrt=f"{self.module}.sqrt"))

    def _print_Relational(self, expr: Any) -> str:
        return f"{self._print(expr.lhs)} {expr.rel_op} {self._print(expr.rhs)}"

    def _print_Piecewise(self, expr: Any) -> str:
        (value, condition), (otherwise, _) = expr.args
        return f"{self.where}({self._print(condition)}, {self._print(value)}, {self._print(otherwise)})"

    def _print_And(self, expr: Any) -> str:
        return self._joined(self.conjunction, expr)

    def _print_Or(self, expr: Any) -> str:
        return self._joined(self.disjunction, expr)

    def _joined(self, name: str, expr: Any) -> str:
        texts = [str(self._print(arg)) for arg in expr.args]
        return reduce(lambda joined, text: f"{self.module}.{name}({joined}, {text})", texts)


class NumpyPrinter(ArrayPrinter):
    """Python text calling NumPy.

    >>> NumpyPrinter().doprint(sp.sin(sp.Symbol("F_x0_w")) ** 2)
    'np.sin(F_x0_w)**2'
    >>> loaded = sp.Piecewise((0, sp.Symbol("Fz") <= 0), (sp.Symbol("F_x0"), True))
    >>> NumpyPrinter().doprint(loaded)
    'np.where(Fz <= 0, 0, F_x0)'
    """

    module = "np"
    where = "np.where"
    other_names: ClassVar[dict[str, str]] = {"sgn": "sign", "absolute": "abs"}


class NamespacePrinter(NumpyPrinter):
    """Python text calling a library of arrays with NumPy's names, which is an argument of the printed function.

    >>> NamespacePrinter().doprint(sp.sin(sp.Symbol("F_x0_w")) ** 2)
    'xp.sin(F_x0_w)**2'
    """

    module = "xp"
    where = "xp.where"


class CasadiPrinter(ArrayPrinter):
    """Python text calling CasADi.

    >>> light, fast = sp.Symbol("Fz") <= 0, sp.Symbol("V") > 1
    >>> CasadiPrinter().doprint(sp.Piecewise((0, sp.And(light, fast)), (sp.pi, True)))
    'ca.if_else(ca.logic_and(Fz <= 0, V > 1), 0, ca.pi)'
    """

    module = "ca"
    where = "ca.if_else"
    conjunction, disjunction = "logic_and", "logic_or"
    other_names: ClassVar[dict[str, str]] = {"sgn": "sign", "absolute": "fabs"}


#: Powers that are written as a call, because SymPy prints a denominator without checking whether it needs brackets.
CALLED_POWERS = {
    sp.Rational(1, 2): "sqrt",
    sp.Rational(3, 2): "cubed_sqrt",
    sp.Integer(2): "square",
    sp.Integer(3): "cube",
    sp.Integer(4): "fourth",
}


class CallPrinter(NumberPrinter, C99CodePrinter):
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
    powers = CALLED_POWERS
    #: Prefix of the functions that the language has.
    prefix = ""
    #: Functions that the printout defines.
    defined: ClassVar[frozenset[str]] = frozenset(["square", "cube", "fourth", "cubed_sqrt", "sgn", "sgn1"])
    choice = "({condition} ? {then} : {otherwise})"
    conjunction, disjunction, equal = " && ", " || ", "=="
    number = "{}"
    pi = "3.141592653589793"

    def __init__(self, members: Mapping[str, str] | None = None) -> None:
        # M_PI and similar constants are not in C99.
        super().__init__({"order": "none", "math_macros": {}})
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
    _print_sgn = _print_sgn1 = _print_absolute = _print_expm1 = _print_called

    def _print_Pow(self, expr: Any) -> str:
        if expr.exp == -1:
            return f"{self._print(sp.Integer(1))}/{self.parenthesize(expr.base, PRECEDENCE['Mul'], strict=True)}"
        called = self.powers.get(abs(expr.exp))
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


class PlainCPrinter(CallPrinter):
    """C99 text of the generated code: powers and elementary functions are calls of its own inline functions.

    >>> PlainCPrinter().doprint(sp.Symbol("dfz") ** 2 / sp.sqrt(sp.Symbol("x")))
    'square(dfz)/sqrt(x)'
    """

    names: ClassVar[dict[str, str]] = {
        "absolute": "fabs", **{name: f"fast_{name}" for name in ("sin", "cos", "tan", "atan")},
    }  # fmt: skip
    powers = CALLED_POWERS | {sp.Rational(1, 3): "cbrt"}
    pi = "PI"


class LanesPrinter(PlainCPrinter):
    """C text in which some symbols represent several rows at a time, see lanes.h.

    `varying`: the symbols that differ from row to row.

    >>> B, x = sp.symbols("B x")
    >>> LanesPrinter({"x"}).doprint(B**2 + sp.atan(B * x) ** 2)
    'square(B) + lanes_square(lanes_atan(B*x))'
    >>> LanesPrinter({"x"}).doprint(sp.Piecewise((B, x > 0), (x, True)))
    'choose(x > 0.0, each(B), x)'
    """

    powers = CALLED_POWERS
    conjunction, disjunction = " & ", " | "

    def __init__(self, varying: Collection[str]) -> None:
        super().__init__()
        self._varying = varying

    def varies(self, expr: Any) -> bool:
        """Return whether an expression differs from row to row."""
        return any(symbol.name in self._varying for symbol in expr.free_symbols)

    def in_lanes(self, expr: Any) -> str:
        """Return the text of an expression as a value for several rows."""
        text = str(self.doprint(expr))
        return text if self.varies(expr) else f"each({text})"

    def _call(self, name: str, *arguments: Any) -> str:
        if not any(map(self.varies, arguments)):
            return super()._call(name, *arguments)
        printed = self.in_lanes if len(arguments) > 1 else self._print
        return f"lanes_{name}({', '.join(map(printed, arguments))})"

    def _print_Piecewise(self, expr: Any) -> str:
        if not self.varies(expr):
            return super()._print_Piecewise(expr)
        (value, condition), (otherwise, _) = expr.args
        then, other = self.in_lanes(value), self.in_lanes(otherwise)
        if not self.varies(condition):
            return f"({super()._print(condition)} ? {then} : {other})"
        return f"choose({self._print(condition)}, {then}, {other})"
