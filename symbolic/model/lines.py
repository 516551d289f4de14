"""Passes over the lines of a model: which lines a result depends on, effects switched, options decided."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import replace

import sympy as sp

from ..notation import Choice, Equation, Switch


def reaching(lines: Iterable[Equation], targets: Collection[str]) -> list[Equation]:
    """Return the lines on which the targets depend, in order.

    `lines`: each uses only earlier symbols. `targets`: names of symbols.
    """
    needed, lines_read = set(targets), []
    for line in reversed(list(lines)):
        if line.symbol.name in needed:
            lines_read.append(line)
            needed |= line.reads
    return lines_read[::-1]


def reduced(equations: Iterable[Equation], present: Collection[str], read: Collection[str]) -> tuple[Equation, ...]:
    """Return lines with effects switched and options decided, without the lines that become trivial.

    `equations`: each uses only earlier symbols. `present`: the effects that are on. `read`: the options that stay in
    the lines; the others have their first value.
    """
    lines: list[Equation] = []
    values: dict[sp.Symbol, sp.Expr] = {}  # a line that is 0 or 1 now removes later terms
    for line in equations:
        expression = decided(switched(line.expression, present), read).xreplace(values)
        symbol = line.symbol
        if expression.is_Number or (expression.is_Symbol and not line.named):
            values[symbol] = expression
        if expression.is_Symbol and not line.named:
            continue
        step = next((i for i, e in enumerate(lines) if e.symbol == expression and not e.named), None)
        if step is None:
            lines.append(replace(line, expression=expression))
            continue
        values[expression] = symbol  # a step that is now the whole of this line takes its name
        lines[step] = replace(line, expression=lines[step].expression)
        lines[step + 1 :] = [replace(e, expression=e.expression.xreplace(values)) for e in lines[step + 1 :]]
    return tuple(lines)


def switches(expression: sp.Expr) -> list[sp.Expr]:
    """Return every switch of an expression, in the order of a traversal."""
    return [node for node in sp.preorder_traversal(expression) if isinstance(node, Switch)]


def decided(expression: sp.Expr, read: Collection[str]) -> sp.Expr:
    """Return an expression that reads the named options from the parameter vector, the others at their first value."""

    def decide(option: sp.Symbol, first: sp.Expr, second: sp.Expr) -> sp.Expr:
        if first == second or option.name not in read:
            return first
        return sp.Piecewise((second, option > sp.Rational(1, 2)), (first, True))

    return replaced(expression, Choice, decide)


def switched(expression: sp.Expr, present: Collection[str]) -> sp.Expr:
    """Return an expression with every switch replaced by its `on` or `off` side."""
    return replaced(expression, Switch, lambda effect, on, off: on if effect.name in present else off)


def replaced(expression: sp.Expr, kind: type[sp.Function], by: Callable[..., sp.Expr]) -> sp.Expr:
    """Return an expression in which a function of the arguments replaces every node of a class.

    `Basic.replace` does the same from the innermost node outwards, but takes several times as long.

    `by`: what replaces a node, given its arguments; nodes in the result are replaced, too.
    """
    if isinstance(expression, kind):
        return replaced(by(*expression.args), kind, by)
    parts = [replaced(part, kind, by) for part in expression.args]
    if all(new is old for new, old in zip(parts, expression.args, strict=True)):
        return expression
    return expression.func(*parts)
