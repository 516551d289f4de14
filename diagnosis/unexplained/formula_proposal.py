"""Structure as a proposed effect: its file, and the model with it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ...boundary.errors import EffectError
from ...boundary.escaping import toml_string
from ...symbolic.added import AddedEffect, read_effect
from ...tires.tire import Tire
from ..least_squares import LeastSquares, Solution
from ..recording.simulation import Simulator
from ..thresholds import COEFFICIENT_BOUND_FACTOR
from .past import STATES
from .structure import Structure


@dataclass(frozen=True)
class Unknown:
    """Structure that no candidate effect explains.

    Attributes
    ----------
    depends_on : tuple of str
    formula : str
        As in an effect file: "quantity, factor or term: formula".
    added : bool
        Whether the improved tire contains it: only if it predicts the hold-out set better.
    effect : AddedEffect or None
        The proposed effect file.
    not_added_because : str
        Reason; "" if it was added.
    next_measurement : str
        The measurement that determines its form.
    """

    depends_on: tuple[str, ...]
    formula: str
    added: bool
    effect: AddedEffect | None = None
    not_added_because: str = ""
    next_measurement: str = ""


@dataclass(frozen=True, eq=False)
class Added:
    """A proposed formula that was added to the model.

    Attributes
    ----------
    effect : AddedEffect
    tire : Tire
        The baseline model with the effect of the formula.
    problem : LeastSquares
    solution : Solution
    """

    effect: AddedEffect
    tire: Tire
    problem: LeastSquares
    solution: Solution


def effect_of(structure: Structure) -> AddedEffect:
    """Return structure as an effect; rates and memories become states."""
    names = [f"FOUND{i + 1}" for i in range(len(structure.terms))]
    variables = "_".join(re.sub(r"\W", "", variable) for variable in structure.depends_on).lower()
    states = dict.fromkeys(state for term in structure.terms for state in term.states)
    text = (
        f'name = "found_{variables}"\nphysics = "{structure.location.name} changes with '
        f'{", ".join(structure.depends_on)}"\nsource = "proposed by the diagnosis of a recording"\n[coefficients]\n'
        + _declarations(structure, names)
        + "".join(map(_table_of, states))
        + _acts(structure, names)
    )
    return read_effect(text, f"found_{variables}.toml")


def _declarations(structure: Structure, names: Sequence[str]) -> str:
    """Return the declarations of the coefficients of structure, a line each."""
    flips = ", flips = true" if structure.location.flips else ""
    return "".join(
        f'{name} = {{description = {toml_string(f"found: {term.text}")}, unit = "1", lower = {-_bound(size)!r}, '
        f"upper = {_bound(size)!r}{flips}}}\n"
        for name, term, size in zip(names, structure.terms, structure.sizes, strict=True)
    )


def _acts(structure: Structure, names: Sequence[str]) -> str:
    """Return how the terms of structure act on its quantities, a table each."""
    location = structure.location
    total = " + ".join(f"{name}*({term.in_effect_file})" for name, term in zip(names, structure.terms, strict=True))
    per = f"{location.per}*" if location.per else ""
    value = f"1 + {total}" if location.how == "factor" else f"{per}({total})"
    return "".join(f'[[acts]]\non = "{quantity}"\n{location.how} = "{value}"\n' for quantity in location.quantities)


def _table_of(state: str) -> str:
    """Return the table of a state in an effect file."""
    rows = [
        f"{key} = " + (toml_string(value) if isinstance(value, str) else f"[{', '.join(map(toml_string, value))}]")
        for key, value in STATES[state].items()
    ]
    return "\n".join((f"[states.{state}]", *rows, ""))


def unknown_of(structure: Structure, effect: AddedEffect, added: Added | str) -> Unknown:
    """Return the report of structure that no candidate effect explains.

    Parameters
    ----------
    structure : Structure
    effect : AddedEffect
        Result of `effect_of`.
    added : Added or str
        Result of `with_formula`.
    """
    formula = structure.formula
    if isinstance(added, Added):
        index = added.problem.simulator.index
        formula = structure.formula_with(
            [added.solution.parameters[index[declaration.name]] for declaration in added.effect.declarations]
        )
    measurements = [_MEASUREMENTS[name] for name in structure.depends_on if name in _MEASUREMENTS]
    return Unknown(
        structure.depends_on, formula, isinstance(added, Added), effect, "" if isinstance(added, Added) else added,
        measurements[0] if measurements else "",
    )  # fmt: skip


#: Measurement that determines the form of structure that depends on a rate. Relaxation depends on the distance rolled,
#: a delay on time, friction within the carcass on the direction only.
_MEASUREMENTS = {
    "dalpha/dt": "sweep alpha at three rates and two speeds, up and down",
    "dkappa/dt": "sweep kappa at three rates and two speeds, up and down",
    "dFz/dt": "step the load at constant slip, at two speeds",
    "memory": "hold the slip after a sweep, and repeat the sweep after a rest",
}


def _bound(size: float) -> float:
    return max(abs(float(size)), 1e-4) * COEFFICIENT_BOUND_FACTOR


def with_formula(
    structure: Structure, effect: AddedEffect, start: Tire, problem: LeastSquares, solution: Solution
) -> Added | str:
    """Add a formula to the model.

    Parameters
    ----------
    structure : Structure
    effect : AddedEffect
        Result of `effect_of`.
    start : Tire
    problem : LeastSquares
    solution : Solution
        Solution without the formula.

    Returns
    -------
    Added or str
        Otherwise the reason why the model cannot contain the formula.
    """
    try:
        tire = replace(start, added=(*start.added, effect))
        simulator = Simulator(tire, problem.simulator.signals.with_inputs_of(tire))  # the states are inputs
    except EffectError as error:
        return f"the model cannot contain the formula: {error}"
    parameters = tire.parameters()
    for name in problem.simulator.names:
        parameters[simulator.index[name]] = solution.parameters[problem.simulator.index[name]]
    for declaration, size in zip(effect.declarations, structure.sizes, strict=True):
        parameters[simulator.index[declaration.name]] = size
    extended = replace(problem, simulator=simulator.driven_at(parameters))
    free = (*solution.free, *(declaration.name for declaration in effect.declarations))
    return Added(effect, tire, extended, extended.solve(parameters, free, iterations=8))
