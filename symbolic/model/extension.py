"""What a model needs for effects beyond the book: quantities to act on, unused names, and further inputs."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from ...boundary.errors import EffectError
from ..added import AddedEffect
from ..added.state import SLIDING_POWER
from ..declarations import Quantity
from ..effects import EFFECTS
from ..options import OPTIONS
from ..quantities import ACTED_ON, BEYOND, OWN_SPEED


def has_place(effect: AddedEffect, named: Collection[str], inputs: Collection[str]) -> bool:
    """Return whether a model has everything on which an effect acts and that it reads.

    `named`: named quantities and roles of the model. `inputs`: its inputs and coefficients.
    """
    acted_on = ACTED_ON.keys() & set(effect.acts_on)  # an input that it acts on is added if the model lacks it
    readable = {*inputs, *BEYOND, *acted_on, *(declaration.name for declaration in effect.declarations)}
    if effect.states:
        readable |= {"V", SLIDING_POWER, *named, *(state.name for state in effect.states)}
    return {*named, *ACTED_ON}.issuperset(effect.acts_on) and readable.issuperset(effect.reads)


def further_inputs(effects: Sequence[AddedEffect], inputs: Iterable[Quantity]) -> tuple[Quantity, ...]:
    """Return the inputs that effects read and a model lacks, and their states, which are inputs of its lines."""
    read = {name for effect in effects for name in effect.reads}
    read |= {"V"} if SLIDING_POWER in read else set()
    lacking = read.difference(quantity.name for quantity in inputs)
    beyond = [quantity for name, quantity in {**ACTED_ON, "V": OWN_SPEED}.items() if name in lacking]
    states = {state.name: state for effect in effects for state in effect.states}
    memory = [Quantity(name, state.unit, state.description or name) for name, state in states.items()]
    return (*beyond, *memory)


def further_results(effects: Sequence[AddedEffect]) -> tuple[str, ...]:
    """Return the lines that effects add to the results of a model: of temperatures, and of inputs as they act."""
    nodes = (line for effect in effects for state in effect.states if state.is_temperature for line in state.line_names)
    acting = (acting_name(name) for effect in effects for name in effect.acts_on if name in ACTED_ON)
    return tuple(dict.fromkeys([*nodes, *acting]))


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
        names = [declaration.name for declaration in effect.declarations]
        names += [name for state in effect.states for name in (state.name, *state.line_names, state.event_line) if name]
        for name in (effect.name, *names):
            if name in taken:
                raise EffectError(f"effect {effect.name}: {name} is {taken[name]} of {model} already")
