"""What the states of effects read: the coefficients without which they do not act, and each other."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...numerics.arrays import IndexArray
from ...symbolic.added.effect import owners_of
from ...symbolic.added.state import State
from ...tires.tire import Tire


def amplitudes_of(tire: Tire) -> dict[str, IndexArray]:
    """Return for each state of an effect that the tire lacks the coefficients without which it does not act.

    They are indices in the parameters of the model.
    """
    parameters, amplitudes = list(tire.symbolic_model.parameters), {}
    for name, owners in owners_of(tire.symbolic_model.added).items():
        if not tire.has.isdisjoint(effect.name for effect, _ in owners):
            continue
        read = {symbol for effect, _ in owners for state in effect.states for symbol in state.reads}
        acting = {symbol for effect, _ in owners for act in effect.acts for symbol in act.reads}
        declared = [declaration.name for effect, _ in owners for declaration in effect.declarations]
        needed = [coefficient for coefficient in declared if coefficient in acting or coefficient not in read]
        amplitudes[name] = np.array([parameters.index(coefficient) for coefficient in needed])
    return amplitudes


def groups_of(states: Mapping[str, State]) -> tuple[tuple[str, ...], ...]:
    """Return the names of states in groups: a state that reads another one, or is its speed, is in its group."""
    groups = list[tuple[str, ...]]()
    for name, state in states.items():
        read = state.reads | {
            other for other in states if states[other].oscillates and states[other].speed_name == name
        }
        joined = tuple(other for group in groups if not read.isdisjoint(group) for other in group)
        groups = [group for group in groups if set(joined).isdisjoint(group)] + [(*joined, name)]
    return tuple(groups)
