"""Derivatives along the lines of the book: split into steps, differentiated step by step, joined by elimination.

No line is ever substituted into another, because such substitutions make symbolic derivatives explode. A line with
brackets and function calls is split into steps ``D_t_part1``, ``D_t_part2``, ..., each so short that its partial
derivatives are little more than its factors. Common terms of a line and its partials are computed once. The chain rule
then removes one step after the other from the graph of dependencies, the step that costs the fewest multiplications
first (Markowitz' rule; Griewank and Walther, Evaluating Derivatives (2008), chapter 9). Carrying derivatives forward by
a few inputs and backward by many coefficients are special cases of that order.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, reduce
from heapq import heapify, heappop, heappush
from operator import mul

import sympy as sp
from sympy.logic.boolalg import Boolean

from ..functions import absolute, sgn
from ..notation import Equation

ONE, ZERO, MINUS_ONE = sp.Integer(1), sp.Integer(0), sp.Integer(-1)


@dataclass(frozen=True)
class NamedExpression:
    """A short expression with a name, and its partial derivatives by the symbols in it."""

    symbol: sp.Symbol
    expression: sp.Expr
    partials: tuple[tuple[sp.Symbol, sp.Expr], ...] = ()


@dataclass(frozen=True)
class SplitLine:
    """A line preprocessed for the chain rule.

    - `steps`: in an order in which each uses only earlier ones; the last is the line itself.
    - `shared`: common terms of several steps or partials, computed before them.
    """

    steps: tuple[NamedExpression, ...]
    shared: tuple[tuple[sp.Symbol, sp.Expr], ...]


def split(line: Equation) -> SplitLine:
    """Split a line into steps and differentiate each.

    >>> from tirefmu.symbolic.notation import Chapter
    >>> eq, q1, q2, dfz, R0 = Chapter("Trail"), *sp.symbols("q1 q2 dfz R0", real=True)
    >>> D_t = eq("4.E43", "D_t", R0 * (q1 + q2 * dfz))
    >>> for step in split(eq.equations[0]).steps:
    ...     print(step.symbol, "=", step.expression, dict(step.partials))
    D_t_part1 = dfz*q2 + q1 {dfz: q2, q1: 1, q2: dfz}
    D_t = D_t_part1*R0 {D_t_part1: R0, R0: D_t_part1}
    """
    return _split(line.symbol, line.expression)


@lru_cache(maxsize=4096)
def _split(symbol: sp.Symbol, expression: sp.Expr) -> SplitLine:
    splitter = _Splitter(symbol.name)
    top = splitter.shortened(expression)
    steps = [(step, inner) for inner, step in splitter.pulled.items()] + [(symbol, top)]
    derived = [(name, inner, _partials(name, inner)) for name, inner in steps]
    return _without_repetition(symbol.name, derived)


class _Splitter:
    """Extracts steps from one line's expression, innermost first; equal parts become one step."""

    def __init__(self, name: str) -> None:
        self._name = name
        self.pulled: dict[sp.Expr, sp.Symbol] = {}

    def shortened(self, expression: sp.Expr) -> sp.Expr:
        """Return the expression with its parts replaced by steps."""
        if expression.is_Atom:
            return expression
        if isinstance(expression, sp.Piecewise):
            return expression.func(*((self._branch(value), condition) for value, condition in expression.args))
        if expression.is_Pow and expression.exp.is_Rational and not expression.exp.is_Integer:
            return self._root(self._named(expression.base), expression.exp)
        if expression.is_Pow and expression.exp.is_negative and expression.exp.is_Integer:
            return self._step(1 / self._named(expression.base)) ** -expression.exp
        keep = {sp.Add: _is_product, sp.Mul: _is_plain_power}.get(expression.func, _is_none)
        inner = (self.shortened(part) for part in expression.args)
        return expression.func(*(part if keep(part) else self._step(part) for part in inner))

    def _branch(self, value: sp.Expr) -> sp.Expr:
        """Return a branch as a step, unless it may be singular where it is not taken: the result would be 0 * inf."""
        return self._named(value) if all(_is_smooth(node) for node in sp.preorder_traversal(value)) else value

    def _root(self, base: sp.Expr, power: sp.Rational) -> sp.Expr:
        """Powers with half-integer exponents use one root; other fractions are unchanged."""
        if power.q != 2:
            return base**power
        root = self._step(sp.sqrt(base))
        whole = base ** ((abs(power.p) - 1) // 2)
        return whole * root if power > 0 else self._step(1 / root) * (self._step(1 / whole) if whole != 1 else 1)

    def _named(self, part: sp.Expr) -> sp.Expr:
        return self._step(self.shortened(part))

    def _step(self, part: sp.Expr) -> sp.Expr:
        if part.is_Atom or not part.free_symbols:
            return part
        return self.pulled.setdefault(part, sp.Symbol(f"{self._name}_part{len(self.pulled) + 1}", real=True))


def _is_smooth(node: sp.Expr) -> bool:
    """Return whether an operation has a finite derivative everywhere."""
    smooth = (sp.Add, sp.Mul, sp.sin, sp.cos, sp.atan, sgn, absolute)
    return bool(node.is_Atom or isinstance(node, smooth) or _is_plain_power(node))


def _is_none(part: sp.Expr) -> bool:
    return False


def _is_plain_power(part: sp.Expr) -> bool:
    return bool(part.is_Pow and part.base.is_Symbol and part.exp in (2, 3))


def _is_product(part: sp.Expr) -> bool:
    return bool(part.is_Mul or _is_plain_power(part))


def _partials(symbol: sp.Symbol, expression: sp.Expr) -> dict[sp.Symbol, sp.Expr]:
    """Partial derivatives of a step; written with the step's symbol where its own value occurs."""
    partials = {}
    for by in sorted(expression.free_symbols, key=lambda symbol: str(symbol.name)):
        if expression.is_Pow and expression.exp.is_Symbol:
            # x^y y / x, as SymPy has it, is NaN at 0.
            base, power = expression.args
            partial = power * base ** (power - 1) if by == base else symbol * sp.log(base)
        else:
            partial = _derivative(expression, by)
            if not (expression.is_Add or expression.is_Mul):
                partial = partial.subs(expression, symbol)
        if partial != 0:
            partials[by] = partial
    return partials


def _derivative(expression: sp.Expr, by: sp.Symbol) -> sp.Expr:
    """Return the result of `sympy.diff` by its rules, without its preparations, which take most of its time."""
    if expression == by:
        return ONE
    if by not in expression.free_symbols:
        return ZERO
    if expression.is_Add:
        return sp.Add(*(_derivative(part, by) for part in expression.args))
    if expression.is_Mul:
        parts = expression.args
        changes = [(i, _derivative(part, by)) for i, part in enumerate(parts) if by in part.free_symbols]
        return sp.Add(*(reduce(mul, (*parts[:i], change, *parts[i + 1 :])) for i, change in changes if change != 0))
    if expression.is_Pow and by not in expression.exp.free_symbols:
        return expression * (_derivative(expression.base, by) * expression.exp / expression.base)
    if isinstance(expression, sp.Piecewise):
        return sp.Piecewise(*((_derivative(value, by), condition) for value, condition in expression.args))
    if expression.is_Function and len(expression.args) == 1:
        return expression.fdiff(1) * _derivative(expression.args[0], by)
    return sp.diff(expression, by)


def _without_repetition(name: str, steps: Sequence[tuple[sp.Symbol, sp.Expr, dict[sp.Symbol, sp.Expr]]]) -> SplitLine:
    """Compute once what the partials of a line have in common."""
    partials = [partial for *_, by_symbol in steps for partial in by_symbol.values()]
    names = (sp.Symbol(f"{name}_shared{i}", real=True) for i in range(1, 1000))
    shared, reduced = sp.cse(partials, symbols=names, list=True) if len(partials) > 1 else ([], partials)
    constants: dict[sp.Symbol, sp.Expr] = {}  # conditions stay where they are read, and so do constants such as 1/pi
    retained = []
    for common, value in shared:
        whole = value.xreplace(constants)
        if isinstance(whole, Boolean) or not whole.free_symbols:
            constants[common] = whole
        else:
            retained.append((common, whole))
    rest = (partial.xreplace(constants) for partial in reduced)
    return SplitLine(
        tuple(
            NamedExpression(symbol, inner, tuple((by, next(rest)) for by in by_symbol))
            for symbol, inner, by_symbol in steps
        ),
        tuple(retained),
    )


@dataclass
class ChainRule:
    """The graph of which step depends on which, and the removal of its inner vertices.

    - `edges`: by upper and lower symbol, the known derivative of the one by the other.
    - `assignments`: the statements to compute, in order.
    """

    edges: dict[sp.Symbol, dict[sp.Symbol, sp.Expr]] = field(default_factory=dict)
    users: dict[sp.Symbol, dict[sp.Symbol, None]] = field(default_factory=dict)
    assignments: list[tuple[sp.Symbol, sp.Expr]] = field(default_factory=list)

    def add(self, upper: sp.Symbol, lower: sp.Symbol, derivative: sp.Expr) -> None:
        """Add a path from lower to upper."""
        below = self.edges.setdefault(upper, {})
        below[lower] = below[lower] + derivative if lower in below else derivative
        self.users.setdefault(lower, {})[upper] = None

    def total(self, outputs: Sequence[sp.Symbol], by: Sequence[sp.Symbol]) -> tuple[tuple[sp.Expr, ...], ...]:
        """Return the derivatives of the outputs by the given symbols, one row an output."""
        self._keep_between(outputs, by)
        inner = [symbol for symbol in self.edges if symbol not in set(outputs)]
        costs = {symbol: (self._cost(symbol), place) for place, symbol in enumerate(inner)}
        waiting = [(cost, symbol) for symbol, cost in costs.items()]  # of equal costs, the first place comes first
        heapify(waiting)
        while waiting:
            cost, cheapest = heappop(waiting)
            if costs.get(cheapest) != cost:
                continue  # eliminated, or entered again with another cost
            del costs[cheapest]
            for neighbour in self._eliminate(cheapest) & costs.keys():
                changed = (self._cost(neighbour), costs[neighbour][1])
                if changed != costs[neighbour]:
                    costs[neighbour] = changed
                    heappush(waiting, (changed, neighbour))
        for output in outputs:  # an output on which another is built, such as Fy in Mx
            self._eliminate(output, keep=True)
        return tuple(tuple(self.edges.get(y, {}).get(x, ZERO) for x in by) for y in outputs)

    def _keep_between(self, outputs: Iterable[sp.Symbol], by: Iterable[sp.Symbol]) -> None:
        """Remove every edge that is not on a path from a given symbol to an output."""
        above = _reached(outputs, self.edges)
        below = _reached(by, self.users)
        retained = above & below
        self.edges = {
            upper: {lower: d for lower, d in edges.items() if lower in retained}
            for upper, edges in self.edges.items()
            if upper in retained
        }
        self.edges = {upper: edges for upper, edges in self.edges.items() if edges}
        self.users = {
            lower: {upper: None for upper in uppers if lower in self.edges.get(upper, {})}
            for lower, uppers in self.users.items()
        }

    def _cost(self, symbol: sp.Symbol) -> int:
        """Return the number of multiplications to eliminate a vertex."""
        above = sum(not _is_unit(self.edges[upper][symbol]) for upper in self.users.get(symbol, ()))
        return above * sum(not _is_unit(derivative) for derivative in self.edges[symbol].values())

    def _eliminate(self, symbol: sp.Symbol, *, keep: bool = False) -> set[sp.Symbol]:
        """Connect the vertices above a vertex with those below it; return these neighbours."""
        uppers = list(self.users.get(symbol, ()))
        if not uppers:
            return set()
        below = {lower: self._named(symbol, lower) for lower in list(self.edges[symbol])}
        for upper in uppers:
            through = self._named(upper, symbol)
            del self.edges[upper][symbol]
            for lower, derivative in below.items():
                self.add(upper, lower, _product(through, derivative))
        self.users[symbol] = {}
        if not keep:
            for lower in below:
                self.users[lower].pop(symbol)
            del self.edges[symbol]
        return {*uppers, *below}

    def _named(self, upper: sp.Symbol, lower: sp.Symbol) -> sp.Expr:
        """Return the derivative along an edge as a number or a symbol, which is assigned where needed."""
        derivative = self.edges[upper][lower]
        if is_short(derivative):
            return derivative
        symbol = sp.Symbol(f"d{upper.name}_d{lower.name}", real=True)
        self.assignments.append((symbol, derivative))
        self.edges[upper][lower] = symbol
        return symbol


def is_short(derivative: sp.Expr) -> bool:
    """Return whether a derivative can be a factor unchanged: a constant, a symbol or a symbol's negative."""
    if derivative.is_Atom:
        return True
    if derivative.is_Mul and derivative.args[0] is MINUS_ONE:
        return len(derivative.args) == 2 and is_short(derivative.args[1])
    return not derivative.free_symbols


def _is_unit(derivative: sp.Expr) -> bool:
    return derivative is ONE or derivative is MINUS_ONE


def _product(through: sp.Expr, derivative: sp.Expr) -> sp.Expr:
    """Return the product of two short derivatives; for two symbols in SymPy's order, without a search."""
    if through is ONE:
        return derivative
    if derivative is ONE:
        return through
    if through.is_Symbol and derivative.is_Symbol and through != derivative:
        first, second = (through, derivative) if through.name < derivative.name else (derivative, through)
        return sp.Mul(first, second, evaluate=False)
    return through * derivative


def _reached(start: Iterable[sp.Symbol], along: Mapping[sp.Symbol, Mapping[sp.Symbol, object]]) -> set[sp.Symbol]:
    """Return everything that can be reached from some vertices."""
    reached, waiting = set(), list(start)
    while waiting:
        symbol = waiting.pop()
        if symbol not in reached:
            reached.add(symbol)
            waiting.extend(along.get(symbol, ()))
    return reached
