"""What is printed: routines of a model as plain lists of assignments, before any language.

Derivatives follow the chain rule along the lines: local partials of each short line, then totals carried
forward (by few inputs) or backward (by many parameters). No line is ever substituted into another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import sympy as sp

from ..model import Model
from ..model.lines import reaching
from ..notation import Equation
from .derivatives import ChainRule, is_short, split

#: Headings in derivative routines, after the chapters.
LOCAL, CARRIED = "Partial derivatives of each line", "Chain rule"
#: The variant for rows without turn slip under default options.
PLAIN = "plain"
#: The derivatives of the forces, and what they are.
JACOBIANS = ("jacobian_inputs", "jacobian_parameters")
SUMMARIES = ("Derivatives of the forces by the inputs.", "Derivatives of the forces by the coefficients.")


@dataclass(frozen=True)
class Assignment:
    """One statement: a symbol and its expression, with its remark and heading."""

    symbol: sp.Symbol
    expression: sp.Expr
    remark: str = ""
    heading: str = ""


@dataclass(frozen=True)
class Routine:
    """A function to print.

    - `results`: one row for a vector, several for a matrix (row per output).
    - `labels`: what the results are called, in the same order; columns of a matrix.
    - `variant`: "" if the routine is valid for every row, `PLAIN` if it is valid only for most rows.
    """

    name: str
    summary: str
    body: tuple[Assignment, ...]
    results: tuple[tuple[sp.Expr, ...], ...]
    labels: tuple[str, ...]
    variant: str = ""

    @property
    def full_name(self) -> str:
        """The name with the variant."""
        return f"{self.name}_{self.variant}" if self.variant else self.name

    def uses(self, names: Sequence[str]) -> list[str]:
        """Return the names that the routine reads, in the given order."""
        return [name for name in names if name in self._read]

    @cached_property
    def _read(self) -> frozenset[str]:
        expressions = [*(assignment.expression for assignment in self.body), *chain.from_iterable(self.results)]
        return frozenset(symbol.name for expression in expressions for symbol in expression.free_symbols)


def value_routines(model: Model) -> tuple[Routine, ...]:
    """Return the routines of a model that are no Jacobians, all effects present.

    Returns: quantities, forces; relaxation, where slips can lag; state_lines, where there are states; if options and
    turn slip are in the lines, forces and relaxation again, plain.

    >>> from tirefmu.symbolic.models import model_named
    >>> [routine.name for routine in value_routines(model_named("mf96"))]
    ['quantities', 'forces']
    """
    (_, general), *plain = _variants(model)
    printed = [_values("quantities", "Every named quantity of the model.", general, _named(model, general))]
    printed += _forces(model, general)
    if model.states:
        summary = "Of each state: target, velocity of its path or flow; rate or reciprocal width; start."
        printed.append(
            _values("state_lines", summary, general, [sp.Symbol(name, real=True) for name in model.state_lines])
        )
    printed += [replace(routine, variant=name) for name, lines in plain for routine in _forces(model, lines)]
    return tuple(printed)


def jacobians(model: Model) -> tuple[Routine, ...]:
    """Return the derivatives of the forces of a model: most of the text, which is printed into separate files.

    Returns: jacobian_inputs, jacobian_parameters; again, plain, where forces are.

    >>> from tirefmu.symbolic.models import model_named
    >>> [routine.name for routine in jacobians(model_named("mf96"))]
    ['jacobian_inputs', 'jacobian_parameters']
    """
    outputs = [quantity.symbol for quantity in model.outputs]
    columns = (
        [quantity.symbol for quantity in model.inputs],
        [sp.Symbol(name, real=True) for name in model.coefficients],
    )
    printed = []
    for variant, lines in _variants(model):
        needed = reaching(lines, [str(output) for output in outputs])
        for name, summary, by in zip(JACOBIANS, SUMMARIES, columns, strict=True):
            printed.append(replace(_derivatives(name, summary, needed, outputs, by), variant=variant))
    return tuple(printed)


def reach(model: Model) -> tuple[tuple[str, ...], ...]:
    """Return the coefficients that the lines of each force read, in the order of the model.

    >>> from tirefmu.symbolic.models import model_named
    >>> [len(names) for names in reach(model_named("mf96"))]
    [29, 40, 100]
    """
    lines, reached = model.lines(), []
    for output in model.outputs:
        needed = reaching(lines, [str(output.symbol)])
        read = {symbol.name for line in needed for symbol in line.expression.free_symbols}
        reached.append(tuple(name for name in model.coefficients if name in read))
    return tuple(reached)


def chosen_routines(
    lines: Sequence[Equation],
    names: Sequence[str],
    outputs: Sequence[sp.Symbol],
    inputs: Sequence[sp.Symbol],
    coefficients: Sequence[sp.Symbol],
    quantities: Sequence[sp.Symbol] = (),
    states: Sequence[sp.Symbol] = (),
) -> tuple[Routine, ...]:
    """Return some routines of given lines, for printouts outside `generated/`.

    `lines`: without switches, as from `tirefmu.symbolic.model.lines.reduced`. `names`: of "forces", "quantities",
    "jacobian_inputs", "jacobian_parameters" and "states". `outputs`: the forces and moments. `inputs`, `coefficients`:
    the columns of the Jacobians. `quantities`: the named quantities. `states`: the derivatives of the states and the
    rates at which they decay.
    """
    needed = reaching(lines, [output.name for output in outputs])
    make = {
        "forces": lambda: _values("forces", "Forces and moments.", needed, list(outputs)),
        "quantities": lambda: _values("quantities", "Named quantities.", lines, list(quantities)),
        "jacobian_inputs": lambda: _derivatives(JACOBIANS[0], SUMMARIES[0], needed, outputs, inputs),
        "jacobian_parameters": lambda: _derivatives(JACOBIANS[1], SUMMARIES[1], needed, outputs, coefficients),
        "states": lambda: _values("states", "Derivatives of the states, and decay rates.", lines, list(states)),
    }
    return tuple(make[name]() for name in names)


def entries(model: Model) -> list[int]:
    """Return the indices of the derivatives by coefficients, counted row by row, that `reach` does not exclude."""
    places = {name: i for i, name in enumerate(model.coefficients)}
    return [row * len(places) + places[name] for row, names in enumerate(reach(model)) for name in names]


def _variants(model: Model) -> list[tuple[str, Sequence[Equation]]]:
    """Return the lines for every row, and those for most rows if they differ, by their variant."""
    general, plain = model.lines(), model.lines(plain=True)
    differ = [line.expression for line in general] != [line.expression for line in plain]
    return [("", general), *[(PLAIN, plain)] * differ]


def _named(model: Model, lines: Sequence[Equation]) -> list[sp.Symbol]:
    outputs = {quantity.symbol for quantity in model.outputs}
    return [line.symbol for line in lines if line.named and line.symbol not in outputs]


def _forces(model: Model, lines: Sequence[Equation]) -> list[Routine]:
    """Return the forces, and the relaxation lengths where slips can lag."""
    printed = [_values("forces", "Forces and moments.", lines, [quantity.symbol for quantity in model.outputs])]
    relaxation = (model.quantity("relaxation_x"), model.quantity("relaxation_y"))
    lengths = [line.symbol for line in lines if line.symbol.name in relaxation]
    if lengths:
        printed.append(_values("relaxation", "Relaxation lengths that act on kappa and tan(alpha).", lines, lengths))
    return printed


def _values(name: str, summary: str, lines: Sequence[Equation], targets: list[sp.Symbol]) -> Routine:
    needed = reaching(lines, [target.name for target in targets])
    return Routine(name, summary, tuple(_printed(needed)), (tuple(targets),), tuple(t.name for t in targets))


def _printed(lines: Sequence[Equation]) -> list[Assignment]:
    """Value lines with the book's number as remark and the chapter's title above the first of each."""
    return _headed(
        [Assignment(e.symbol, e.expression, f"[{e.number}] {e.description}".rstrip(), e.chapter) for e in lines]
    )


def _derivatives(
    name: str, summary: str, lines: Sequence[Equation], outputs: Sequence[sp.Symbol], by: Sequence[sp.Symbol]
) -> Routine:
    """Values, the partial derivatives of each line, the chain rule; only what a result needs."""
    values: list[Assignment] = []
    local: list[Assignment] = []
    chain = ChainRule()
    for line in lines:
        parts = split(line)
        *inner, last = parts.steps
        values += [Assignment(step.symbol, step.expression, "", line.chapter) for step in inner]
        remark = f"[{line.number}] {line.description}".rstrip()
        values.append(Assignment(line.symbol, last.expression, remark, line.chapter))
        local += [Assignment(symbol, expression, "", LOCAL) for symbol, expression in parts.shared]
        for step in parts.steps:
            for symbol, partial in step.partials:
                if not is_short(partial):
                    local.append(
                        Assignment(sp.Symbol(f"{step.symbol.name}_by_{symbol.name}", real=True), partial, "", LOCAL)
                    )
                    partial = local[-1].symbol
                chain.add(step.symbol, symbol, partial)
    results = chain.total(outputs, by)
    carried = [Assignment(symbol, expression, "", CARRIED) for symbol, expression in chain.assignments]
    needed = {symbol for row in results for value in row for symbol in value.free_symbols}
    body = tuple(_headed(_needed([*values, *local, *carried], needed)))
    return Routine(name, summary, body, results, tuple(x.name for x in by))


def _needed(statements: Sequence[Assignment], needed: set[sp.Symbol]) -> list[Assignment]:
    """Return the statements that are needed; the symbols that they need are added to `needed`."""
    routines_of_model = []
    for statement in reversed(statements):
        if statement.symbol in needed:
            routines_of_model.append(statement)
            needed |= statement.expression.free_symbols
    return routines_of_model[::-1]


def _headed(assignments: Sequence[Assignment]) -> list[Assignment]:
    """Keep a heading only above the first of its statements."""
    if not assignments:
        return []
    above = ["", *(assignment.heading for assignment in assignments[:-1])]
    pairs = zip(assignments, above, strict=True)
    return [replace(a, heading="" if a.heading == last else a.heading) for a, last in pairs]
