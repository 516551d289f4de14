"""The lines that the states of added effects add to a model: target, rate, start and derivative of each.

The states are inputs of the model. These lines follow all others, so a state may be driven by a force or a named
quantity. `tirefmu.symbolic.laws` has the updates, which need only these lines.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import sympy as sp

from ...boundary.errors import EffectError, nearest
from ..added.effect import AddedEffect, owners_of
from ..added.formula import formula
from ..added.state import SLIDING_POWER, SPEED, SPEED_ENDING, State, couplings, rate_unit
from ..declarations import Effect
from ..functions import absolute, sgn, where
from ..notation import Chapter, Equation

#: A magnitude below which a slip has no direction.
NO_SLIP = sp.Float("1e-12")


def state_lines(effects: Sequence[AddedEffect]) -> tuple[Equation, ...]:
    """Return the lines of the states of effects; 0 if the effects of a state are off.

    `effects`: effects may share a state that they declare alike. Returns: a line named `SLIDING_POWER` first if a state
    reads it.
    """
    eq = Chapter("States")
    if any(SLIDING_POWER in state.reads for effect in effects for state in effect.states):
        kappa, alpha, V, Fx, Fy = sp.symbols("kappa alpha V Fx Fy", real=True)
        power = absolute(Fx * V * kappa) + absolute(Fy * V * sp.sin(alpha))
        eq("tirefmu", SLIDING_POWER, power, "W", "power that sliding turns into heat")
    owned = owners_of(effects)
    for name, owners in owned.items():
        _file(eq, owners[0][1], [Effect(effect.name, effect.physics, optional=True) for effect, _ in owners], name)
    for line, name, other in couplings(owners[0][1] for owners in owned.values()):
        effect, state = owned[name][0]
        exchange = sp.diff(formula(state.drive[0], f"state {name}"), sp.Symbol(other, real=True))
        switch = Effect(effect.name, effect.physics, optional=True)
        eq("tirefmu", line, switch.either(exchange, sp.Integer(0)), "1/s", f"change of {name}' with {other}")
    return tuple(eq.equations)


def check_state_reads(model: str, effects: Sequence[AddedEffect], names: set[str]) -> None:
    """Raise `EffectError` if a state reads a name that a model does not have."""
    for effect in effects:
        for state in effect.states:
            for name in sorted(state.reads - names):
                raise EffectError(f"effect {effect.name}: state {state.name} reads {name!r},"
                                  f" which {model} has not{nearest(name, names)}")  # fmt: skip


def check_oscillators(states: Iterable[State], is_direct: Callable[[State], bool]) -> None:
    """Raise `EffectError` if forces or other states drive an oscillator, whose law is exact for inputs only."""
    for state in states:
        if state.oscillates and not is_direct(state):
            raise EffectError(f"state {state.name}: an oscillator reads inputs and coefficients only")


def check_temperatures(states: Iterable[State]) -> None:
    """Raise `EffectError` if the drive of a temperature is not linear in temperatures, or does not cool the node."""
    nodes = [state for state in states if state.is_temperature]
    symbols = [sp.Symbol(state.name, real=True) for state in nodes]
    for state, symbol in zip(nodes, symbols, strict=True):
        drive = formula(state.drive[0], f"state {state.name}")
        if sp.diff(drive, symbol) == 0 or any(sp.diff(drive, other).has(*symbols) for other in symbols):
            raise EffectError(f"state {state.name}: the drive of a temperature is linear in the temperatures"
                              " and falls with its own")  # fmt: skip


def _file(eq: Chapter, state: State, effects: Sequence[Effect], name: str) -> None:
    """File the four lines of a state."""

    def only_with(expression: sp.Expr) -> sp.Expr:
        term = sp.Integer(0)
        for effect in effects:
            term = effect.either(expression, term)
        return term

    texts = dict(state.formulas())
    parts = {key: formula(text, f"state {name}") for key, text in texts.items()}
    target, rate = _target_and_rate(state, parts)
    x = sp.Symbol(name, real=True)
    what, unit = state.description or name, rate_unit(state.unit)
    per_time = state.kind == "accumulation" or state.follows_a_path
    first, second, third, last = state.line_names
    u = eq("tirefmu", first, only_with(target), unit if per_time else state.unit, f"target of {what}")
    r = eq("tirefmu", second, only_with(rate), "1/s", f"rate of {what}")
    eq("tirefmu", third, only_with(parts.get("start", sp.Integer(0))), state.unit, f"start of {what}")
    derivative = {"accumulation": u, "hysteresis": (sgn(u) - x) * absolute(u) * r}.get(state.kind, r * (u - x))
    if state.oscillates:
        derivative = sp.Symbol(state.speed_name, real=True)
    elif state.kind == "play":
        margin = where(x * sgn(u) < 1, 1 - x * sgn(u), -1)
        eq("tirefmu", state.event_line, only_with(margin), "1", f"margin of {what} in its direction, -1 without one")
        derivative = where(x * sgn(u) < 1, u * r, 0)
    elif state.kind == SPEED:
        position, target, frequency = (
            sp.Symbol(name.removesuffix(SPEED_ENDING) + ending, real=True) for ending in ("", "_target", "_rate")
        )
        derivative = frequency**2 * (target - position) - r * x
    eq("tirefmu", last, derivative, unit, f"derivative of {what}")


def _target_and_rate(state: State, parts: dict[str, sp.Expr]) -> tuple[sp.Expr, sp.Expr]:
    """Return the first two lines of a state; those of an oscillator are its target and its frequency."""
    if state.follows_a_path:
        return _path(state, parts)
    if state.oscillates:
        return parts["drive"], parts["frequency"]
    if state.kind == SPEED:  # in equilibrium it is 0; its rate is the damping
        return sp.Integer(0), parts["damping"]
    return _balance(state, parts)


def _balance(state: State, parts: dict[str, sp.Expr]) -> tuple[sp.Expr, sp.Expr]:
    """Return target (or flow) and rate of a state that changes with time."""
    rate = parts.get("rate", sp.Integer(0))
    if "length" in parts:
        rate = absolute(sp.Symbol("V", real=True)) / parts["length"]
    if state.is_temperature:
        x = sp.Symbol(state.name, real=True)
        rate = -sp.diff(parts["drive"], x)
        return parts["drive"].xreplace({x: sp.Integer(0)}) / rate, rate
    if state.kind == "heat":
        return parts.get("ambient", sp.Integer(0)) + parts["drive"] / rate, rate
    return parts["drive"], rate


def _path(state: State, parts: dict[str, sp.Expr]) -> tuple[sp.Expr, sp.Expr]:
    """Return the velocity along the path and the reciprocal of the width."""
    lags = [sp.Symbol(name, real=True) for name in state.drive]
    velocities = [sp.Symbol(f"{lag}_rate", real=True) * (sp.Symbol(f"{lag}_target", real=True) - lag) for lag in lags]
    velocity = velocities[0]
    if len(lags) == 2:
        size = sp.sqrt(lags[0] ** 2 + lags[1] ** 2 + NO_SLIP**2)
        velocity = sum((lag * v for lag, v in zip(lags, velocities, strict=True)), sp.Integer(0)) / size
    return velocity, 1 / parts["width"]
