"""Calls of one elementary function that do not depend on each other: two of them share a vector.

With one row at a time, the elementary functions take most of the time of the forces.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from .routines import Assignment

#: The functions that compute two values at a time, by the class of their calls; cosines are shifted sines.
FUNCTIONS: dict[type[sp.Basic], str] = {
    sp.atan: "atan", sp.tan: "tan", sp.sin: "shifted_sin", sp.cos: "shifted_sin", sp.exp: "exp", sp.Pow: "pow",
}  # fmt: skip


def in_pairs(body: Sequence[Assignment]) -> list[tuple[Assignment, ...]]:
    """Return statements in the order in which their arguments are known, calls of one function in pairs.

    Statements without calls are first, then all calls whose arguments are known, then what uses their results.

    The result has no headings. It has single statements and pairs of calls.

    >>> a, b, c, x, y = sp.symbols("a b c x y")
    >>> waiting = [Assignment(a, 2 * sp.atan(x)), Assignment(b, sp.atan(a)), Assignment(c, sp.atan(y))]
    >>> for members in in_pairs(waiting):
    ...     print(*(f"{member.symbol} = {member.expression}" for member in members), sep="; ")
    a_atan = atan(x); c_atan = atan(y)
    a = 2*a_atan
    c = c_atan
    b_atan = atan(a)
    b = b_atan
    """
    waiting, groups = _separated(body), list[tuple[Assignment, ...]]()
    while waiting:
        unknown = {statement.symbol for statement in waiting}
        ready = [statement for statement in waiting if not statement.expression.free_symbols & unknown]
        chosen = [statement for statement in ready if not function_of(statement.expression)]
        groups += [(statement,) for statement in chosen]
        if not chosen:
            chosen = ready
            for function in dict.fromkeys(FUNCTIONS.values()):
                calls = [call for call in ready if function_of(call.expression) == function]
                groups += [tuple(calls[i : i + 2]) for i in range(0, len(calls), 2)]
        waiting = [statement for statement in waiting if statement not in chosen]
    return groups


def function_of(expression: sp.Expr) -> str:
    """Return the function that an expression calls, or "" if its outermost operation is not in `FUNCTIONS`.

    >>> x, y = sp.symbols("x y")
    >>> function_of(sp.cos(x)), function_of(x**y), function_of(x**2), function_of(2 * sp.cos(x))
    ('shifted_sin', 'pow', '', '')
    """
    if expression.is_Pow and not expression.exp.free_symbols:
        return ""
    return FUNCTIONS.get(expression.func, "")


def _separated(body: Sequence[Assignment]) -> list[Assignment]:
    """Return statements in which calls of elementary functions, and their arguments, are statements of their own."""
    statements: list[Assignment] = []
    symbols: dict[sp.Expr, sp.Symbol] = {}
    names = {symbol.name for line in body for symbol in (line.symbol, *line.expression.free_symbols)}

    def named(expression: sp.Expr, name: str) -> sp.Symbol:
        """Return the symbol of an expression, which becomes a statement unless it is one."""
        if expression.is_Symbol:
            return expression
        if expression not in symbols:
            while name in names:
                name += "_"
            names.add(name)
            symbols[expression] = sp.Symbol(name, real=True)
            statements.append(Assignment(symbols[expression], expression))
        return symbols[expression]

    def without_calls(expression: sp.Expr, name: str) -> sp.Expr:
        if expression.is_Atom:
            return expression
        parts = [without_calls(argument, name) for argument in expression.args]
        if not function_of(expression):
            return expression.func(*parts)
        symbol = f"{name}_{expression.func.__name__.lower()}"
        return named(expression.func(*(named(part, f"{symbol}_of") for part in parts)), symbol)

    for line in body:
        expression = without_calls(line.expression, line.symbol.name)
        statements.append(Assignment(line.symbol, expression, line.remark))
    return statements
