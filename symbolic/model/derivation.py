"""The structure of a model, derived from its lines."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from operator import itemgetter

import sympy as sp

from ..declarations import Option
from ..notation import Choice, Equation
from ..options import OPTIONS, signs
from .lines import decided, reaching, reduced, switched, switches
from .structure import Line, LineCase, Structure


def structure_of(
    equations: Sequence[Equation],
    declared: Iterable[str],
    *,
    required: Iterable[str],
    outputs: Sequence[str],
    on_demand: Iterable[str],
    lengths: Collection[str],
) -> Structure:
    """Return the structure of the lines of a model.

    `equations`: every line, with effects as switches and options as choices. `declared`: the coefficients, in the order
    of their declarations. `required`: coefficients that the model has although no line reads them. `on_demand`: effects
    that an input activates. `lengths`: the relaxation lengths.
    """
    read = {name for line in equations for name in line.reads} | set(required)
    chosen = {str(choice.args[0]) for line in equations for choice in line.expression.atoms(Choice)}
    options = [option for option in OPTIONS.values() if option.parameter in chosen]
    effects = tuple(dict.fromkeys(name for line in equations for name in _effects(line)))
    relaxing = (name for line in equations if line.symbol.name in lengths for name in _effects(line))
    rest = set(effects) - set(on_demand)
    plain = reaching(reduced(equations, rest, {signs.parameter}), outputs)
    return Structure(
        coefficients=tuple(name for name in declared if name in read),
        options=tuple(option.name for option in options),
        plain_options=_plain_options(equations, rest, options, outputs),
        effects=effects,
        relaxing_effects=tuple(sorted(set(relaxing))),
        upright=tuple(line.symbol.name for line in equations if line.variant),
        quantities={line.symbol.name: (line.unit, line.description) for line in equations if line.named},
        plain={output: _read_by(plain, output) for output in outputs},
        lines=_lines(equations),
    )


def _effects(line: Equation) -> list[str]:
    """Return the effects of a line, in the order in which it has them."""
    return list(dict.fromkeys(str(switch.args[0]) for switch in switches(line.expression)))


def _plain_options(
    equations: Sequence[Equation], effects: set[str], options: Sequence[Option], outputs: Sequence[str]
) -> tuple[str, ...]:
    lines = reaching(reduced(equations, effects, {option.parameter for option in OPTIONS.values()}), outputs)
    read = {name for line in lines for name in line.reads}
    return tuple(option.name for option in options if option.parameter in read and option != signs)


def _read_by(lines: Sequence[Equation], output: str) -> tuple[str, ...]:
    read = {name for line in reaching(lines, {output}) for name in line.reads}
    return tuple(sorted(read))


def _lines(equations: Sequence[Equation]) -> tuple[Line, ...]:
    """Return what each line reads in all cases: with every choice of its effects, and of the earlier lines' numbers."""
    options = {option.parameter for option in OPTIONS.values()}
    possible: dict[str, tuple[str, ...]] = {}  # numbers that a line may be, '' for an expression
    numbers: dict[str, sp.Expr] = {}
    derived = []
    for line in equations:
        earlier = sorted(name for name in line.reads if name in possible)
        shape = Line(line.symbol.name, tuple(_effects(line)), {name: possible[name] for name in earlier})
        cases = []
        for present, group in groupby(shape.conditions(), key=itemgetter(0)):
            expression = decided(switched(line.expression, present), options)
            for _, values in group:
                fixed = {name: numbers[value] for name, value in zip(earlier, values, strict=True) if value}
                cases.append(_case(expression, fixed, numbers))
        derived.append(replace(shape, cases=tuple(cases)))
        results = sorted({case.number for case in cases})
        if results != [""]:
            possible[line.symbol.name] = tuple(results)
    return tuple(derived)


def _case(expression: sp.Expr, fixed: Mapping[str, sp.Expr], numbers: dict[str, sp.Expr]) -> LineCase:
    """Return what an expression is with earlier lines that are numbers; a new number is added to `numbers`."""
    result = expression.xreplace({sp.Symbol(name, real=True): number for name, number in fixed.items()})
    if not result.is_Number:
        return LineCase("", tuple(sorted(symbol.name for symbol in result.free_symbols)))
    numbers[str(result)] = result
    return LineCase(str(result), ())
