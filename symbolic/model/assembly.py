"""The lines of a model, assembled from its chapters and the effects that are added to them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import sympy as sp

from ...boundary.errors import EffectError, nearest
from ...boundary.escaping import quoted
from ..added import AddedEffect
from ..declarations import Effect
from ..functions import absolute, sgn, where
from ..notation import Chapter, Equation, Variant
from ..quantities import ACTED_ON, ALPHA, ALPHA_FOLDED, GAMMA
from .extension import acting_name
from .lines import reaching, replaced

#: The largest slip angle with seven digits below 90 deg, rad.
STEEPEST = sp.Float("1.5707963")


def assembled(
    model: str,
    chapters: Sequence[Chapter],
    added: Sequence[AddedEffect],
    quantities: Mapping[str, str],
    outputs: Collection[str],
) -> tuple[Equation, ...]:
    """Return every line of a model, with effects as switches and options as choices.

    `model`: its name; if models that share a line differ, its term is used. `quantities`: the quantity of each role.
    Steps that no output and no named quantity uses are omitted: they belong to another model. Raises `EffectError` if
    an added effect acts on a quantity that the model does not have.
    """
    written = (equation for chapter in chapters for equation in chapter.equations)
    lines = [replace(line, expression=_own(line.expression, model)) for line in written]
    acting = _acting_inputs(added)
    lines = [*acting.values(), *lines]
    for effect in added:
        lines = _acted_on(lines, effect, quantities)
    lines = _reading(lines, acting)
    if any(effect.states for effect in added):
        from .state_lines import state_lines

        lines += state_lines(added)
    folded = _folded_angle()
    lines = _reading([folded, *lines], {ALPHA.symbol: folded})
    return tuple(reaching(lines, set(outputs) | {line.symbol.name for line in lines if line.named}))


def check_reads(
    model: str,
    lines: Iterable[Equation],
    added: Iterable[AddedEffect],
    quantities: Mapping[str, str],
    names: Iterable[str],
) -> None:
    """Raise `EffectError` if an added effect reads a name that is not computed before the line on which it acts.

    `model`: its name, for the message. `lines`: with the added effects. `added`, `quantities`: as for `assembled`.
    `names`: inputs and coefficients.
    """
    lines, before = list(lines), set(names)
    acts = [(act, _places(_target(act.on, quantities), lines, effect)) for effect in added for act in effect.acts]
    for line in lines:
        acting = [act for act, places in acts if line.symbol.name in places]
        for name in sorted({name for act in acting for name in act.reads} - before):
            raise EffectError(f"an effect on {line.symbol} reads {name!r}, which {model} has not"
                              f" before it{nearest(name, before)}")  # fmt: skip
        before.add(line.symbol.name)


def _own(expression: sp.Expr, model: str) -> sp.Expr:
    """Use a model's term wherever models that share a line differ."""
    return replaced(expression, Variant, lambda name, chosen, others: chosen if name.name == model else others)


def _acting_inputs(added: Sequence[AddedEffect]) -> dict[sp.Symbol, Equation]:
    """Return, by input, a line for each input on which effects act: the value that other lines read in its place."""
    eq, names = (
        Chapter("Inputs"),
        dict.fromkeys(act.on for effect in added for act in effect.acts if act.on in ACTED_ON),
    )
    for name in names:
        quantity = ACTED_ON[name]
        eq("tirefmu", _target(name, {}), quantity.symbol, quantity.unit, f"{quantity.description}, as it acts")
    return {ACTED_ON[name].symbol: line for name, line in zip(names, eq.equations, strict=True)}


def _folded_angle() -> Equation:
    """Return the line of the slip angle that all other lines read in place of the input: their one law beyond 90 deg.

    The wheel then moves backwards. The lateral slip is V_y/|V_x|, so that the side force opposes the sliding velocity.
    Next to 90 deg it is `STEEPEST`, whose tangent is positive in single precision, too.
    """
    eq, alpha = Chapter("Inputs"), ALPHA.symbol
    beyond = where(absolute(alpha) > sp.pi - STEEPEST, sp.pi * sgn(alpha) - alpha, STEEPEST * sgn(alpha))
    folded = where(absolute(alpha) > STEEPEST, beyond, alpha)
    eq("tirefmu", ALPHA_FOLDED.name, folded, ALPHA_FOLDED.unit, ALPHA_FOLDED.description, named=False)
    return eq.equations[0]


def _reading(lines: list[Equation], acting: Mapping[sp.Symbol, Equation]) -> list[Equation]:
    """Let lines read the acting value of inputs; the lines that determine an acting value read the input itself."""
    symbols = {read: line.symbol for read, line in acting.items()}
    first = max((i + 1 for i, line in enumerate(lines) if line.symbol in symbols.values()), default=0)
    return [*lines[:first], *(replace(e, expression=e.expression.xreplace(symbols)) for e in lines[first:])]


def _target(on: str, quantities: Mapping[str, str]) -> str:
    """Return the line on which an act acts, for the name of a quantity, a role or an input beyond the book."""
    return acting_name(on) if on in ACTED_ON else quantities.get(on, on)


def _acted_on(lines: list[Equation], effect: AddedEffect, quantities: Mapping[str, str]) -> list[Equation]:
    """Insert an added effect into the lines of the quantities on which it acts."""
    places = {on: _places(_target(on, quantities), lines, effect) for on in effect.acts_on}
    switch = Effect(effect.name, effect.physics, optional=True)
    changed = []
    for line in lines:
        acts = [act for act in effect.acts if line.symbol.name in places[act.on]]
        if acts and effect.states:
            # In a separate line: the structure of a line has a case for each combination of its effects.
            before = sp.Symbol(f"{line.symbol}_without_{effect.name}", real=True)
            changed.append(replace(line, symbol=before, named=False, acts_for=""))
            line = replace(line, expression=before)
        expression = line.expression
        for act in acts:
            change = _upright(act.expression, effect) if line.variant else act.expression
            acted = expression * change if act.how == "factor" else expression + change
            expression = switch.either(acted, expression)
        changed.append(replace(line, expression=expression))
    return changed


def _upright(formula: sp.Expr, effect: AddedEffect) -> sp.Expr:
    """Return a formula without inclination, as it changes a line that the book repeats for the upright wheel."""
    upright = sp.sympify(formula.subs(GAMMA.symbol, 0))
    if upright.has(sp.zoo, sp.oo, -sp.oo, sp.nan):
        raise EffectError(f"{effect.name}: {quoted(str(formula))} is not finite without inclination")
    return upright


def _places(name: str, lines: Sequence[Equation], effect: AddedEffect) -> frozenset[str]:
    """Return the lines that an effect on a named quantity changes: its own, unless that reads one that acts for it."""
    named = [line.symbol.name for line in lines if line.named]
    if name not in named:
        raise EffectError(f"{effect.name} acts on {quoted(name)}, which is no named quantity{nearest(name, named)}")
    acting = frozenset(line.symbol.name for line in lines if line.acts_for == name)
    before = {line.symbol.name for line in reaching(lines, [name])}
    return acting if acting & before else frozenset({name, *acting})
