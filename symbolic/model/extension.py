"""What a model needs for effects beyond the book: quantities to act on, unused names, and further inputs."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from tirefmu.boundary.errors import EffectError

from ..added import AddedEffect
from ..added.state import SLIDING_POWER
from ..declarations import Quantity
from ..effects import EFFECTS
from ..options import OPTIONS
from ..quantities import BEYOND, OWN_SPEED


def has_place(effect: AddedEffect, named: Collection[str], known: Collection[str]) -> bool:
    """Return whether a model has everything on which an effect acts and that it reads.

    `named`: named quantities and roles of the model. `known`: its inputs and coefficients.
    """
    readable = {*known, *BEYOND, *(declaration.name for declaration in effect.declarations)}
    if effect.states:
        readable |= {"V", SLIDING_POWER, *named, *(state.name for state in effect.states)}
    return {*named, *BEYOND}.issuperset(effect.acts_on) and readable.issuperset(effect.reads)


def further_inputs(effects: Sequence[AddedEffect], inputs: Iterable[Quantity]) -> tuple[Quantity, ...]:
    """Return the inputs that effects read and a model lacks, and their states, which are inputs of its lines."""
    read = {name for effect in effects for name in effect.reads}
    read |= {"V"} if SLIDING_POWER in read else set()
    lacking = read.difference(quantity.name for quantity in inputs)
    beyond = [quantity for name, quantity in {**BEYOND, "V": OWN_SPEED}.items() if name in lacking]
    states = {state.name: state for effect in effects for state in effect.states}
    memory = [Quantity(name, state.unit, state.description or name) for name, state in states.items()]
    return (*beyond, *memory)


def further_results(effects: Sequence[AddedEffect]) -> tuple[str, ...]:
    """Return the lines that effects add to the results of a model: of observed states, and of inputs as they act."""
    observed = (line for effect in effects for state in effect.states if state.observed for line in state.line_names)
    acting = (acting_name(name) for effect in effects for name in effect.acts_on if name in BEYOND)
    return tuple(dict.fromkeys([*observed, *acting]))


def acting_name(name: str) -> str:
    """Return the line with the value of an input that the other lines read, after the effects that act on it."""
    return f"{name}_acting"


def check_names(model: str, effects: Sequence[AddedEffect], quantities: Iterable[str], declared: Iterable[str]) -> None:
    """Raise `EffectError` if an effect, a coefficient or a state has a name with another meaning in a model.

    `model`: its name. `quantities`, `declared`: its inputs, outputs and lines; its coefficients.
    """
    options = {option.parameter for option in OPTIONS.values()}
    taken = {**dict.fromkeys((*quantities, *(quantity.name for quantity in BEYOND.values())), "a quantity")}
    taken |= {**dict.fromkeys(declared, "a coefficient"), **dict.fromkeys(options, "an option")}
    taken |= dict.fromkeys(EFFECTS, "an effect")
    for effect in effects:
        own = [declaration.name for declaration in effect.declarations]
        own += [name for state in effect.states for name in (state.name, *state.line_names, state.event_line) if name]
        for name in (effect.name, *own):
            if name in taken:
                raise EffectError(f"effect {effect.name}: {name} is {taken[name]} of {model} already")
