"""What is printed: routines of a model as plain lists of assignments, before any language.

Derivatives follow the chain rule along the lines: local partials of each short line, then totals carried
forward (by few inputs) or backward (by many parameters). No line is ever substituted into another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ..model import Model, reaching
from ..notation import Equation


@dataclass(frozen=True)
class Assignment:
    """One statement: a symbol and its expression, with the remark and the heading that stand by it."""

    symbol: sp.Symbol
    expression: sp.Expr
    remark: str = ""
    heading: str = ""


@dataclass(frozen=True)
class Routine:
    """A function to print.

    Attributes
    ----------
    name, summary : str
    body : tuple of Assignment
    results : tuple of tuple of sympy.Expr
        One row for a vector, several for a matrix (row per output).
    labels : tuple of str
        What the results are called, in the same order; columns of a matrix.
    """

    name: str
    summary: str
    body: tuple[Assignment, ...]
    results: tuple[tuple[sp.Expr, ...], ...]
    labels: tuple[str, ...]

    def uses(self, names: Sequence[str]) -> list[str]:
        """Return those of the names that the routine reads, in the given order."""
        read = {s.name for a in self.body for s in a.expression.free_symbols}
        read |= {s.name for row in self.results for value in row for s in value.free_symbols}
        return [name for name in names if name in read]


def routines(model: Model) -> tuple[Routine, ...]:
    """Return the routines of a model, all effects present.

    Parameters
    ----------
    model : Model

    Returns
    -------
    tuple of Routine
        quantities, forces, slip_stiffnesses, jacobian_inputs, jacobian_parameters.

    Examples
    --------
    >>> from tirefmu.symbolic import model
    >>> [routine.name for routine in routines(model("mf96"))]
    ['quantities', 'forces', 'slip_stiffnesses', 'jacobian_inputs', 'jacobian_parameters']
    """
    lines = model.lines()
    outputs = [quantity.symbol for quantity in model.outputs]
    names = tuple(str(output) for output in outputs)
    inputs = [quantity.symbol for quantity in model.inputs]
    parameters = [sp.Symbol(card.name, real=True) for card in model.parameters]
    named = [line.symbol for line in lines if line.named and line.symbol not in outputs]
    force_lines = reaching(lines, names)
    return (
        _values("quantities", "Every named quantity of the book.", list(lines), named),
        _values("forces", "Forces and moments.", force_lines, outputs),
        _forward("slip_stiffnesses", "Derivatives of the forces by the slips.", force_lines, outputs, inputs[:2]),
        _forward("jacobian_inputs", "Derivatives of the forces by the inputs.", force_lines, outputs, inputs),
        _backward(
            "jacobian_parameters",
            "Derivatives of the forces by the parameters.",
            force_lines,
            outputs,
            parameters,
        ),
    )


def _values(name: str, summary: str, lines: list[Equation], targets: list[sp.Symbol]) -> Routine:
    kept = reaching(lines, [target.name for target in targets])
    return Routine(name, summary, _printed(kept), (tuple(targets),), tuple(t.name for t in targets))


def _printed(lines: Sequence[Equation]) -> tuple[Assignment, ...]:
    """Value lines with the book's number beside them and the chapter's title above the first of each."""
    body, title = [], ""
    for line in lines:
        heading = line.chapter if line.chapter != title else ""
        title = line.chapter
        body.append(Assignment(line.symbol, line.expression, f"[{line.number}] {line.description}", heading))
    return tuple(body)


def _partials(
    lines: Sequence[Equation], by: Sequence[sp.Symbol]
) -> tuple[list[Assignment], dict[tuple[str, str], sp.Expr]]:
    """Local partial derivatives of every line, by earlier lines and by the asked symbols.

    Those that are more than a number or a symbol get an assignment ``F_x0_by_B_x`` of their own.
    """
    asked = {line.symbol for line in lines} | set(by)
    assignments, partials = [], {}
    for line in lines:
        for symbol in sorted(line.expression.free_symbols & asked, key=str):
            partial = sp.diff(line.expression, symbol)
            if partial == 0:
                continue
            if not (partial.is_Number or partial.is_Symbol):
                local = sp.Symbol(f"{line.symbol}_by_{symbol}", real=True)
                assignments.append(Assignment(local, partial))
                partial = local
            partials[line.symbol.name, symbol.name] = partial
    return assignments, partials


def _forward(
    name: str, summary: str, lines: list[Equation], outputs: Sequence[sp.Symbol], by: Sequence[sp.Symbol]
) -> Routine:
    """Carry total derivatives forward along the lines: cheap for a few inputs."""
    local, partials = _partials(lines, by)
    totals: dict[tuple[str, str], sp.Expr] = {(x.name, x.name): sp.Integer(1) for x in by}
    carried = []
    for line in lines:
        for x in by:
            through = [
                arg for arg in _arguments(line) if (line.symbol.name, arg) in partials and (arg, x.name) in totals
            ]
            total = sp.Add(*(partials[line.symbol.name, arg] * totals[arg, x.name] for arg in through))
            if total == 0:
                continue
            if not (total.is_Number or total.is_Symbol):
                symbol = sp.Symbol(f"d{line.symbol}_d{x}", real=True)
                carried.append(Assignment(symbol, total))
                total = symbol
            totals[line.symbol.name, x.name] = total
    results = tuple(tuple(totals.get((y.name, x.name), sp.Integer(0)) for x in by) for y in outputs)
    return _derivative(name, summary, lines, local, carried, results, by)


def _backward(
    name: str, summary: str, lines: list[Equation], outputs: Sequence[sp.Symbol], by: Sequence[sp.Symbol]
) -> Routine:
    """Carry total derivatives backward from each output: cheap for many parameters."""
    local, partials = _partials(lines, by)
    carried, results = [], []
    for output in outputs:
        adjoint: dict[str, sp.Expr] = {output.name: sp.Integer(1)}
        for line in reversed(lines):
            total = adjoint.get(line.symbol.name, sp.Integer(0))
            if total == 0:
                continue
            if not (total.is_Number or total.is_Symbol):
                symbol = sp.Symbol(f"d{output}_d{line.symbol}", real=True)
                carried.append(Assignment(symbol, total))
                total = symbol
            for arg in _arguments(line):
                if (line.symbol.name, arg) in partials:
                    adjoint[arg] = adjoint.get(arg, sp.Integer(0)) + total * partials[line.symbol.name, arg]
        results.append(tuple(adjoint.get(p.name, sp.Integer(0)) for p in by))
    return _derivative(name, summary, lines, local, carried, tuple(results), by)


def _arguments(line: Equation) -> list[str]:
    return sorted(symbol.name for symbol in line.expression.free_symbols)


def _derivative(
    name: str,
    summary: str,
    lines: list[Equation],
    local: list[Assignment],
    carried: list[Assignment],
    results: tuple[tuple[sp.Expr, ...], ...],
    by: Sequence[sp.Symbol],
) -> Routine:
    """Put values, local partials and totals together and drop what no result needs."""
    statements = [
        *_printed(lines),
        *_headed(local, "Partial derivatives of each line"),
        *_headed(carried, "Chain rule"),
    ]
    needed = {symbol for row in results for value in row for symbol in value.free_symbols}
    kept = []
    for statement in reversed(statements):
        if statement.symbol in needed:
            kept.append(statement)
            needed |= statement.expression.free_symbols
    return Routine(name, summary, tuple(kept[::-1]), results, tuple(x.name for x in by))


def _headed(assignments: list[Assignment], heading: str) -> list[Assignment]:
    if not assignments:
        return []
    first = assignments[0]
    return [Assignment(first.symbol, first.expression, first.remark, heading), *assignments[1:]]
