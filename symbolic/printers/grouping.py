"""Calls of one elementary function that do not depend on each other: up to four of them share a vector.

One row at a time, the elementary functions are most of the forces. Which calls form a group, and in which order
statements follow each other, results from simulating a processor along the statements.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy as sp

from .routines import Assignment

#: The functions that compute two or four values at a time, by the class of their calls; cosines are shifted sines.
FUNCTIONS: dict[type[sp.Basic], str] = {
    sp.atan: "atan", sp.tan: "tan", sp.sin: "shifted_sin", sp.cos: "shifted_sin", sp.exp: "exp", sp.Pow: "pow",
}  # fmt: skip
#: Calls in a group.
MOST = 4
#: How long each takes, in multiplications.
TIMES = {"atan": 11.0, "shifted_sin": 10.0, "tan": 12.0, "exp": 10.0, "pow": 22.0}
#: Operations that a processor begins in the time of a multiplication, and those of a group.
BEGUN, IN_GROUP = 9, 30


@dataclass(frozen=True)
class Group:
    """Calls of one function.

    Attributes
    ----------
    function : str
        One of the values of `FUNCTIONS`, or "" where the group is a statement without a call.
    members : tuple of Assignment
        What each call is assigned to; the only statement where there is no call.
    """

    function: str
    members: tuple[Assignment, ...]


def grouped(body: Sequence[Assignment]) -> list[Group]:
    """Return statements in groups, without headings, in an order in which a processor waits little.

    Of the statements whose arguments are known, that one is next from which the way to the end takes longest. If it is
    a call, the next ones of the same function join it.

    Parameters
    ----------
    body : sequence of Assignment

    Returns
    -------
    list of Group

    Examples
    --------
    >>> a, b, c, x, y = sp.symbols("a b c x y")
    >>> waiting = [Assignment(a, 2 * sp.atan(x)), Assignment(b, sp.atan(a)), Assignment(c, sp.atan(y))]
    >>> for group in grouped(waiting):
    ...     print(group.function, *(f"{member.symbol} = {member.expression}" for member in group.members), sep="; ")
    atan; a_atan = atan(x); c_atan = atan(y)
    ; a = 2*a_atan
    ; c = c_atan
    atan; b_atan = atan(a)
    ; b = b_atan
    """
    return _Schedule(_Separated(body).statements).groups()


class _Separated:
    """Statements in which calls of elementary functions, and their arguments, are statements of their own."""

    def __init__(self, body: Sequence[Assignment]) -> None:
        self.statements: list[Assignment] = []
        self._found: dict[sp.Expr, sp.Symbol] = {}
        self._names = {assignment.symbol.name for assignment in body}
        self._names |= {symbol.name for assignment in body for symbol in assignment.expression.free_symbols}
        for assignment in body:
            expression = self._without_calls(assignment.expression, assignment.symbol.name)
            self.statements.append(Assignment(assignment.symbol, expression, assignment.remark))

    def _without_calls(self, expression: sp.Expr, name: str) -> sp.Expr:
        if expression.is_Atom:
            return expression
        parts = [self._without_calls(argument, name) for argument in expression.args]
        if not function_of(expression):
            return expression.func(*parts)
        own = f"{name}_{expression.func.__name__.lower()}"
        return self._named(expression.func(*(self._named(part, f"{own}_of") for part in parts)), own)

    def _named(self, expression: sp.Expr, name: str) -> sp.Symbol:
        """Return the symbol of an expression, which becomes a statement unless it is one."""
        if expression.is_Symbol:
            return expression
        if expression not in self._found:
            self._found[expression] = sp.Symbol(self._new(name), real=True)
            self.statements.append(Assignment(self._found[expression], expression))
        return self._found[expression]

    def _new(self, name: str) -> str:
        """Return a name that nothing has."""
        while name in self._names:
            name += "_"
        self._names.add(name)
        return name


def function_of(expression: sp.Expr) -> str:
    """Return the function that an expression calls, or "" where its outermost operation is none of `FUNCTIONS`.

    Examples
    --------
    >>> x, y = sp.symbols("x y")
    >>> function_of(sp.cos(x)), function_of(x**y), function_of(x**2), function_of(2 * sp.cos(x))
    ('shifted_sin', 'pow', '', '')
    """
    if expression.is_Pow and not expression.exp.free_symbols:
        return ""
    return FUNCTIONS.get(expression.func, "")


class _Schedule:
    """A simulated processor, which begins statements as soon as their arguments are known."""

    def __init__(self, statements: Sequence[Assignment]) -> None:
        self._statements = statements
        self._functions = [function_of(statement.expression) for statement in statements]
        index = {statement.symbol: i for i, statement in enumerate(statements)}
        self._needs = [
            sorted(index[symbol] for symbol in statement.expression.free_symbols if symbol in index)
            for statement in statements
        ]
        self._takes = [_time(statement.expression) for statement in statements]
        self._to_end = list(self._takes)
        for i in reversed(range(len(statements))):
            for k in self._needs[i]:
                self._to_end[k] = max(self._to_end[k], self._takes[k] + self._to_end[i])

    def groups(self) -> list[Group]:
        now, known, found = 0.0, dict[int, float](), []
        waiting = list(range(len(self._statements)))
        while waiting:
            starts = {i: self._start(i, known) for i in waiting if all(k in known for k in self._needs[i])}
            now = max(now, min(starts.values()))
            # Of equal ones the first.
            first = max((i for i in starts if starts[i] <= now), key=lambda i: self._to_end[i])
            chosen = self._with(first, starts)
            now = max(now, *(starts[i] for i in chosen))
            for i in chosen:
                known[i] = now + self._takes[i]
                waiting.remove(i)
            function = self._functions[first]
            found.append(Group(function, tuple(self._statements[i] for i in sorted(chosen))))
            now += (IN_GROUP if function else _operations(self._statements[first].expression)) / BEGUN
        return found

    def _start(self, i: int, known: dict[int, float]) -> float:
        return max((known[k] for k in self._needs[i]), default=0.0)

    def _with(self, first: int, others: Iterable[int]) -> list[int]:
        """Return a statement without a call, or the most urgent ones with the same call."""
        function = self._functions[first]
        if not function:
            return [first]
        return sorted((i for i in others if self._functions[i] == function), key=lambda i: -self._to_end[i])[:MOST]


def _time(expression: sp.Expr) -> float:
    """Return how long a result takes, in multiplications."""
    if expression.is_Atom:
        return 0.0
    if expression.is_Pow:
        root, below = expression.exp.is_Rational and expression.exp.q == 2, expression.exp.could_extract_minus_sign()
        own = TIMES["pow"] if function_of(expression) else 5.0 * root + 3.0 * below + (not root and not below)
    elif expression.is_Add or expression.is_Mul:
        own = len(expression.args) - 1.0
    else:
        own = TIMES.get(function_of(expression), 1.0)
    return own + max(map(_time, expression.args))


def _operations(expression: sp.Expr) -> int:
    return max(1, sum(max(0, len(node.args) - 1) for node in sp.preorder_traversal(expression)))
