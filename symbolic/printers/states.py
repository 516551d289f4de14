"""The states of a tire as a function of inputs and states: the derivative of each and the rate at which it decays.

A slip that lags is a state of its own, in addition to the slip of the wheel. Relaxation lengths, lags of inputs and
hystereses follow the wheel's slips; a state that forces drive follows the forces at the lagged slips, as in the FMU.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import sympy as sp

from ...boundary.errors import TirefmuError
from ..added.state import State, rate_unit
from ..declarations import Quantity
from ..functions import absolute, where
from ..model import Model
from ..model.lines import reaching
from ..notation import Chapter, Equation
from ..quantities import ALPHA_FOLDED, AT_ONCE, KAPPA, KAPPA_LAGGED, TAN_ALPHA_LAGGED, V

#: Slips that lag: the state, its target, the replacement of the wheel's slip, the role of its length.
SLIPS = (
    (KAPPA_LAGGED, KAPPA.symbol, {KAPPA.symbol: KAPPA_LAGGED.symbol}, "relaxation_x"),
    (
        TAN_ALPHA_LAGGED,
        sp.tan(ALPHA_FOLDED.symbol),
        {ALPHA_FOLDED.symbol: sp.atan(TAN_ALPHA_LAGGED.symbol)},
        "relaxation_y",
    ),
)
#: Endings of the results: derivative; rate of the exponential that approaches the state's target.
ENDINGS = ("dot", "decay")


def lagging_slips(model: Model, lines: Sequence[Equation]) -> tuple[Quantity, ...]:
    """Return the lagged slips of a tire, in the order of `SLIPS`: those whose relaxation length is not always 0."""
    zero = {line.symbol.name for line in lines if line.expression == 0}
    named = {line.symbol.name for line in lines} - zero
    return tuple(slip for slip, _, _, role in SLIPS if model.quantity(role) in named)


def state_lines(
    model: Model, lines: Sequence[Equation], effects: Collection[str]
) -> tuple[tuple[Equation, ...], tuple[sp.Symbol, ...]]:
    """Return the lines that a tire's states need in addition to its own lines, and the results.

    `lines`: the lines of the tire. `effects`: the effects that it has. Returns `results`: ``NAME_dot`` and
    ``NAME_decay`` of each state, lagged slips first, in the units of the state per second and 1/s. Raises
    `TirefmuError` if the tire has no states, or a name is in use.
    """
    eq = Chapter("Derivatives of the states")
    lagging = lagging_slips(model, lines)
    acting: dict[sp.Expr, sp.Expr] = {}
    for slip, target, replacement, role in SLIPS:
        if slip in lagging:
            acting |= replacement
            _file_lag(eq, slip, target, sp.Symbol(model.quantity(role), real=True))
    states = [model.states[name] for name in model.states_of(effects)]
    driven = [name for state in states if _is_driven(model, state) for name in state.line_names]
    copies = _at_lagged_slips(reaching(lines, driven), acting)
    for state in states:
        target, rate, _, derivative = (
            acting.get(symbol, symbol) if _is_driven(model, state) else symbol
            for symbol in (sp.Symbol(name, real=True) for name in state.line_names)
        )
        none = sp.Integer(0)
        decay = {"hysteresis": absolute(target) * rate}.get(state.kind, rate if state.settles else none)
        decay = none if state.oscillates else decay
        what = state.description or state.name
        eq("tirefmu", f"{state.name}_decay", decay, "1/s", f"decay of {what}", named=False)
        eq("tirefmu", f"{state.name}_dot", derivative, rate_unit(state.unit), f"derivative of {what}", named=False)
    if not eq.equations:
        raise TirefmuError("states: the tire has none; relaxation (relax_*) and some added effects have states")
    steps = (*copies, *eq.equations)
    earlier = {line.symbol for line in lines}
    if taken := sorted(str(line.symbol) for line in steps if line.symbol in earlier):
        raise TirefmuError(f"states: {taken[0]} is a name of the tire's own lines")
    names = [slip.name for slip in lagging] + [state.name for state in states]
    return steps, tuple(sp.Symbol(f"{name}_{ending}", real=True) for name in names for ending in ENDINGS)


def _is_driven(model: Model, state: State) -> bool:
    """Return whether forces drive a state. These are the forces at the lagged slips."""
    return not (model.is_direct(state) or state.follows_a_path)


def _file_lag(eq: Chapter, slip: Quantity, target: sp.Expr, length: sp.Symbol) -> None:
    what = slip.description
    distance = eq("tirefmu", f"{slip.name}_length", where(length > AT_ONCE, length, AT_ONCE), "m", named=False)
    decay = eq("tirefmu", f"{slip.name}_decay", absolute(V.symbol) / distance, "1/s", f"decay of {what}", named=False)
    eq("tirefmu", f"{slip.name}_dot", decay * (target - slip.symbol), "1/s", f"derivative of {what}", named=False)


def _at_lagged_slips(lines: Sequence[Equation], acting: dict[sp.Expr, sp.Expr]) -> tuple[Equation, ...]:
    """Return a copy of each line that the lagged slips change; `acting` gets the new symbols."""
    copies = []
    for line in lines:
        expression = line.expression.xreplace(acting)
        if expression != line.expression:
            acting[line.symbol] = sp.Symbol(f"{line.symbol}_acting", real=True)
            chapter = f"{line.chapter}, at the lagged slips"
            copies.append(
                replace(line, symbol=acting[line.symbol], expression=expression, named=False, chapter=chapter)
            )
    return tuple(copies)
