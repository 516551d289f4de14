"""How an expression is written in each language: SymPy's own printers with the book's habits."""

from __future__ import annotations

from typing import Any

import sympy as sp
from sympy.printing.c import C99CodePrinter
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.pycode import PythonCodePrinter
from sympy.printing.str import StrPrinter


class NumberPrinter(StrPrinter):
    """Numbers as both languages write them: a fraction is one decimal number, which needs no brackets."""

    def parenthesize(self, item: Any, level: int, strict: bool = False) -> str:
        """Return the text of an operand; a fraction, printed as one number, needs no brackets."""
        if item.is_Rational and item > 0:
            return str(self._print(item))
        return str(super().parenthesize(item, level, strict))

    def _print_Rational(self, expr: Any) -> str:
        return repr(expr.p / expr.q)

    def _print_Float(self, expr: Any) -> str:
        return repr(float(expr))


class ArrayPrinter(NumberPrinter, PythonCodePrinter):
    """Python text calling the elementary functions of a module such as NumPy or CasADi.

    Parameters
    ----------
    module : str
        The name that the module goes by in the printed text.
    where : str
        The function of three arguments that chooses between two values.

    Examples
    --------
    >>> ArrayPrinter("np", "np.where").doprint(sp.sin(sp.Symbol("F_x0_w")) ** 2)
    'np.sin(F_x0_w)**2'
    >>> loaded = sp.Piecewise((0, sp.Symbol("Fz") <= 0), (sp.Symbol("F_x0"), True))
    >>> ArrayPrinter("np", "np.where").doprint(loaded)
    'np.where(Fz <= 0, 0, F_x0)'
    """

    def __init__(self, module: str, where: str) -> None:
        super().__init__({"fully_qualified_modules": False, "strict": True, "order": "none"})
        self._module, self._where = module, where

    def _print_Function(self, expr: Any) -> str:
        return f"{self._module}.{expr.func.__name__}({', '.join(self._print(arg) for arg in expr.args)})"

    _print_sin = _print_cos = _print_atan = _print_exp = _print_Function

    def _print_Pow(self, expr: Any, rational: bool = False, sqrt: str = "sqrt") -> str:
        if expr.exp == sp.Rational(1, 2):
            return f"{self._module}.sqrt({self._print(expr.base)})"
        if expr.exp == -sp.Rational(1, 2):
            return f"1/{self._module}.sqrt({self._print(expr.base)})"
        if expr.exp == sp.Rational(3, 2):
            return f"{self.parenthesize(expr.base, PRECEDENCE['Pow'])}**1.5"
        return str(super()._hprint_Pow(expr, rational=rational, sqrt=f"{self._module}.sqrt"))

    def _print_Relational(self, expr: Any) -> str:
        return f"{self._print(expr.lhs)} {expr.rel_op} {self._print(expr.rhs)}"

    def _print_Piecewise(self, expr: Any) -> str:
        (value, condition), (otherwise, _) = expr.args
        return f"{self._where}({self._print(condition)}, {self._print(value)}, {self._print(otherwise)})"


#: Powers that C code writes as a call; the inline functions stand in `tirefmu.symbolic.printers.c`.
CALLED_POWERS = {
    sp.Rational(1, 2): "sqrt",
    sp.Rational(3, 2): "cubed_sqrt",
    sp.Integer(2): "square",
    sp.Integer(3): "cube",
}


class PlainCPrinter(NumberPrinter, C99CodePrinter):
    """C99 text in double precision; squares are written as calls of an inline function, never with pow.

    Examples
    --------
    >>> PlainCPrinter().doprint(sp.Symbol("dfz") ** 2 / sp.sqrt(sp.Symbol("x")))
    'square(dfz)/sqrt(x)'
    """

    def __init__(self) -> None:
        super().__init__({"order": "none"})

    def _print_Pow(self, expr: Any) -> str:
        # Calls, not products: SymPy prints a denominator without asking whether it needs brackets.
        called = CALLED_POWERS.get(abs(expr.exp))
        if called is None:
            return str(super()._print_Pow(expr))
        text = f"{called}({self._print(expr.base)})"
        return text if expr.exp > 0 else f"1.0/{text}"

    def _print_Integer(self, expr: Any) -> str:
        return f"{expr.p}.0"

    def _print_Piecewise(self, expr: Any) -> str:
        (value, condition), (otherwise, _) = expr.args
        return f"({self._print(condition)} ? {self._print(value)} : {self._print(otherwise)})"
