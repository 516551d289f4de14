"""Numbers in the lines of a tire, without a change of the order in which the lines compute.

SymPy distributes a number over a sum: 0.1 (x - y) becomes 0.1 x - 0.1 y. If x and y are almost equal, as in the
deflection by a quadratic equation, the result loses its digits. A literal is a symbol for SymPy and a number for a
printer; only 0, 1 and -1 are numbers, so that terms disappear.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import sympy as sp

from ..notation import Equation


class Literal(sp.Symbol):
    """A number that SymPy treats as a symbol.

    >>> x = sp.Symbol("x")
    >>> Literal("0.1") * (x - 1), Literal("0.1").value
    (0.1*(x - 1), 0.1)
    """

    @property
    def value(self) -> float:
        """The number."""
        return float(self.name)


def literal(value: float) -> sp.Expr:
    """Return a number as a literal, or as a number if it is 0, 1 or -1."""
    return sp.Integer(int(value)) if value in (0.0, 1.0, -1.0) else Literal(repr(value), real=True)


def folded(lines: Sequence[Equation], values: Mapping[str, float]) -> tuple[Equation, ...]:
    """Return lines with numbers for the coefficients; a line that becomes a number is used as such.

    >>> from tirefmu.symbolic.notation import Chapter
    >>> eq, (PCX1, LCX, B) = Chapter("Fx"), sp.symbols("PCX1 LCX B", real=True)
    >>> C = eq("4.E11", "C_x", PCX1 * LCX)
    >>> _ = eq("4.1", "F_x0", sp.sin(C * B))
    >>> [str(line.expression) for line in folded(eq.equations, {"PCX1": 1.5, "LCX": 1.0})]
    ['1.5', 'sin(1.5*B)']
    """
    coefficients = {sp.Symbol(name, real=True): literal(value) for name, value in values.items()}
    numbers = dict(coefficients)
    lines_left: list[Equation] = []
    for line in lines:
        expression = _constants_computed(line.expression.xreplace(numbers))
        if expression.has(sp.zoo, sp.nan, sp.oo):
            # A branch that is never taken may divide by a coefficient that is 0: it stays a variable of this line.
            read = sorted(line.expression.free_symbols & coefficients.keys(), key=str)
            new = [symbol for symbol in read if all(other.symbol != symbol for other in lines_left)]
            lines_left += [replace(line, symbol=symbol, expression=numbers[symbol], named=False) for symbol in new]
            expression = line.expression.xreplace({symbol: numbers[symbol] for symbol in numbers.keys() - set(read)})
        if expression.is_Number or isinstance(expression, Literal):
            numbers[line.symbol] = expression
        lines_left.append(replace(line, expression=expression))
    return tuple(lines_left)


def _constants_computed(expression: sp.Expr) -> sp.Expr:
    """Return an expression in which parts without variables are numbers, and so are products of numbers."""
    if not expression.args:
        return expression
    expression = expression.func(*map(_constants_computed, expression.args))
    symbols = expression.free_symbols
    if not expression.args or not symbols:
        return literal(float(expression)) if expression.is_Number else expression
    if all(isinstance(symbol, Literal) for symbol in symbols):
        number = expression.xreplace({symbol: sp.Float(symbol.value) for symbol in symbols})
        return literal(float(number)) if number.is_Number else number
    if expression.is_Mul:
        numbers = [factor for factor in expression.args if isinstance(factor, Literal)]
        if len(numbers) > 1:
            product = sp.prod(sp.Float(factor.value) for factor in numbers)
            return sp.Mul(literal(float(product)), *(factor for factor in expression.args if factor not in numbers))
    return expression
