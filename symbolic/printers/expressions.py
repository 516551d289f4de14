"""How an expression is written in each language: SymPy's printers with the conventions of the book."""

from __future__ import annotations

from collections.abc import Collection
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


def _is_plain_factor(factor: Any) -> bool:
    """Return whether a factor stays above the line, without brackets unless it is a sum."""
    if factor.is_Pow:
        return bool(factor.exp.is_Rational and factor.exp > 0)
    return bool(factor.is_Symbol or factor.is_Add or (factor.is_Function and not factor.is_Piecewise))


class ArrayPrinter(NumberPrinter, PythonCodePrinter):
    """Python text calling the elementary functions of a library of arrays, which the sub-classes name."""

    module = ""
    where = ""
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
        return self._joined(f"{self.module}.logical_and", expr)

    def _print_Or(self, expr: Any) -> str:
        return self._joined(f"{self.module}.logical_or", expr)

    def _joined(self, function: str, expr: Any) -> str:
        return reduce(lambda joined, arg: f"{function}({joined}, {arg})", [str(self._print(arg)) for arg in expr.args])


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
    other_names: ClassVar[dict[str, str]] = {"sgn": "sign", "absolute": "fabs"}

    def _print_And(self, expr: Any) -> str:
        return self._joined("ca.logic_and", expr)

    def _print_Or(self, expr: Any) -> str:
        return self._joined("ca.logic_or", expr)


#: Powers that C code writes as a call; the inline functions are in `arithmetic.h`.
CALLED_POWERS = {
    sp.Rational(1, 2): "sqrt",
    sp.Rational(3, 2): "cubed_sqrt",
    sp.Integer(2): "square",
    sp.Integer(3): "cube",
    sp.Integer(4): "fourth",
}


class PlainCPrinter(NumberPrinter, C99CodePrinter):
    """C99 text in double precision; squares are written as calls of an inline function, never with pow.

    >>> PlainCPrinter().doprint(sp.Symbol("dfz") ** 2 / sp.sqrt(sp.Symbol("x")))
    'square(dfz)/sqrt(x)'
    """

    def __init__(self) -> None:
        # M_PI and similar constants are not in C99.
        super().__init__({"order": "none", "math_macros": {}})

    def _print_Pow(self, expr: Any) -> str:
        # Calls, not products: SymPy prints a denominator without checking whether it needs brackets.
        called = CALLED_POWERS.get(abs(expr.exp))
        if called is None:
            return str(super()._print_Pow(expr))
        text = f"{called}({self._print(expr.base)})"
        return text if expr.exp > 0 else f"1.0/{text}"

    def _print_fast(self, expr: Any) -> str:
        """Write a call of one of the functions of elementary.h."""
        return f"fast_{expr.func.__name__}({self._print(expr.args[0])})"

    _print_sin = _print_cos = _print_tan = _print_atan = _print_fast

    def _print_sgn(self, expr: Any) -> str:
        return f"sgn({self._print(expr.args[0])})"

    def _print_sgn1(self, expr: Any) -> str:
        return f"sgn1({self._print(expr.args[0])})"

    def _print_absolute(self, expr: Any) -> str:
        return f"fabs({self._print(expr.args[0])})"

    def _print_expm1(self, expr: Any) -> str:
        return f"expm1({self._print(expr.args[0])})"

    def _print_Pi(self, expr: Any) -> str:
        return "PI"

    def _print_Integer(self, expr: Any) -> str:
        return f"{expr.p}.0"

    def _print_And(self, expr: Any) -> str:
        return " && ".join(f"({self._print(arg)})" for arg in expr.args)

    def _print_Or(self, expr: Any) -> str:
        return " || ".join(f"({self._print(arg)})" for arg in expr.args)

    def _print_Piecewise(self, expr: Any) -> str:
        (value, condition), (otherwise, _) = expr.args
        return f"({self._print(condition)} ? {self._print(value)} : {self._print(otherwise)})"


class LanesPrinter(PlainCPrinter):
    """C text in which some symbols represent several rows at a time, see lanes.h.

    `varying`: the symbols that differ from row to row.

    >>> B, x = sp.symbols("B x")
    >>> LanesPrinter({"x"}).doprint(B**2 + sp.atan(B * x) ** 2)
    'square(B) + lanes_square(lanes_atan(B*x))'
    >>> LanesPrinter({"x"}).doprint(sp.Piecewise((B, x > 0), (x, True)))
    'choose(x > 0.0, each(B), x)'
    """

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

    def _print_called(self, expr: Any) -> str:
        if not self.varies(expr):
            return str(getattr(super(), f"_print_{expr.func.__name__}")(expr))
        return f"lanes_{expr.func.__name__}({self._print(expr.args[0])})"

    _print_sin = _print_cos = _print_tan = _print_atan = _print_exp = _print_log = _print_called
    _print_sgn = _print_sgn1 = _print_absolute = _print_called

    def _print_Pow(self, expr: Any) -> str:
        if not self.varies(expr) or expr.exp == -1:
            return super()._print_Pow(expr)
        called = CALLED_POWERS.get(abs(expr.exp))
        if called is None:
            return f"lanes_pow({self.in_lanes(expr.base)}, {self.in_lanes(expr.exp)})"
        text = f"lanes_{called}({self._print(expr.base)})"
        return text if expr.exp > 0 else f"1.0/{text}"

    def _print_And(self, expr: Any) -> str:
        return " & ".join(f"({self._print(arg)})" for arg in expr.args)

    def _print_Or(self, expr: Any) -> str:
        return " | ".join(f"({self._print(arg)})" for arg in expr.args)

    def _print_Piecewise(self, expr: Any) -> str:
        if not self.varies(expr):
            return super()._print_Piecewise(expr)
        (value, condition), (otherwise, _) = expr.args
        then, other = self.in_lanes(value), self.in_lanes(otherwise)
        if not self.varies(condition):
            return f"({super()._print(condition)} ? {then} : {other})"
        return f"choose({self._print(condition)}, {then}, {other})"
