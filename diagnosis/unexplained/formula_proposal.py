"""Structure as a proposed effect: its file, and the test on the hold-out set."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tirefmu.boundary.errors import EffectError
from tirefmu.boundary.escaping import toml_string
from tirefmu.symbolic.added import AddedEffect, read_effect
from tirefmu.tires.tire import Tire

from ..least_squares import LeastSquares, Solution
from ..recording.simulation import Simulator
from ..thresholds import COEFFICIENT_BOUND_FACTOR, FINAL_ITERATIONS, MIN_IMPROVEMENT
from .past import STATES
from .structure import Structure

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Unknown:
    """Structure that no candidate effect explains.

    Attributes
    ----------
    depends_on : tuple of str
    formula : str
        As in an effect file: "quantity, factor or term: formula".
    added : bool
        Whether the improved tire contains it: only if the error on the hold-out set decreases.
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


def effect_of(structures: Sequence[Structure], *, prefix: str = "found") -> AddedEffect:
    """Return structure as an effect; rates and memories become states.

    Parameters
    ----------
    structures : sequence of Structure
        The effect contains all of them.
    prefix : str
        Of the name of the effect, and in capital letters of its coefficients.
    """
    declarations, acts, number = "", "", 0
    for structure in structures:
        names = [f"{prefix.upper()}{number + i + 1}" for i in range(len(structure.terms))]
        number += len(names)
        declarations += _declarations(structure, names, prefix)
        acts += _acts(structure, names)
    variables = dict.fromkeys(variable for structure in structures for variable in structure.depends_on)
    quantities = dict.fromkeys(structure.location.name for structure in structures)
    name = f"{prefix}_" + "_".join(re.sub(r"\W", "", variable) for variable in variables).lower()
    states = dict.fromkeys(state for structure in structures for term in structure.terms for state in term.states)
    text = (
        f'name = "{name}"\nphysics = "{" and ".join(quantities)} changes with {", ".join(variables)}"\n'
        f'source = "proposed by the diagnosis of a recording"\n[coefficients]\n{declarations}'
        + "".join(map(_table_of, states))
        + acts
    )
    return read_effect(text.replace("found_", f"{prefix}_"), f"{name}.toml")  # a state belongs to one effect


def _declarations(structure: Structure, names: Sequence[str], prefix: str) -> str:
    """Return the declarations of the coefficients of structure, a line each."""
    flips = ", flips = true" if structure.location.flips else ""
    return "".join(
        f'{name} = {{description = {toml_string(f"{prefix}: {term.text}")}, unit = "1", lower = {-_bound(size)!r}, '
        f"upper = {_bound(size)!r}{flips}}}\n"
        for name, term, size in zip(names, structure.terms, structure.response.estimate, strict=True)
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
        Result of `added_if_better`.
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


def added_if_better(
    structures: Sequence[Structure], effect: AddedEffect, start: Tire, problem: LeastSquares, solution: Solution
) -> Added | str:
    """Add formulas to the model if the error on the hold-out set decreases.

    Parameters
    ----------
    structures : sequence of Structure
    effect : AddedEffect
        Result of `effect_of`.
    start : Tire
    problem : LeastSquares
    solution : Solution
        Solution without the formulas.

    Returns
    -------
    Added or str
        Otherwise the reason: the hold-out error does not decrease, or the model cannot contain the formulas.
    """
    estimate = np.concatenate([structure.response.estimate for structure in structures])
    if (gain := problem.holdout_gain(solution, with_columns(structures, problem, solution))) <= MIN_IMPROVEMENT:
        return _too_small(gain)
    try:
        tire = replace(start, added=(*start.added, effect))
        simulator = Simulator(tire, problem.simulator.signals.with_inputs_of(tire))  # the states are inputs
    except EffectError as error:
        return f"the model cannot contain the formula: {error}"
    parameters = tire.parameters()
    for name in problem.simulator.names:
        parameters[simulator.index[name]] = solution.parameters[problem.simulator.index[name]]
    for declaration, size in zip(effect.declarations, estimate, strict=True):
        parameters[simulator.index[declaration.name]] = size
    extended_problem = replace(problem, simulator=simulator)
    free = (*solution.free, *(declaration.name for declaration in effect.declarations))
    fitted = extended_problem.solve(parameters, free, iterations=8)
    reason = _against_delivery(problem, solution, extended_problem, fitted)
    return reason or Added(effect, tire, extended_problem, fitted)


def with_columns(structures: Sequence[Structure], problem: LeastSquares, solution: Solution) -> Solution:
    """Return the solution with the columns of structure as disturbances.

    Parameters
    ----------
    structures : sequence of Structure
    problem : LeastSquares
    solution : Solution
        Of this problem, the initial values.
    """
    columns = np.concatenate([structure.columns for structure in structures], axis=-1)
    estimate = np.concatenate([structure.response.estimate for structure in structures])
    names = tuple(f"tried_{i}" for i in range(len(estimate)))
    extended = problem.disturbances.extended(names, columns, np.abs(estimate) * COEFFICIENT_BOUND_FACTOR + 1e-6)
    return replace(problem, disturbances=extended).solve(solution.parameters, solution.free, iterations=3)


def _against_delivery(problem: LeastSquares, without: Solution, extended: LeastSquares, fitted: Solution) -> str:
    """Return why a formula is not delivered, or ''; a tire contains no corrections of the functional form."""
    if problem.disturbances.added:
        problem, extended = (
            replace(one, disturbances=one.disturbances.of_recording()) for one in (problem, extended)
        )  # fmt: skip
        without = problem.solve(without.parameters, without.free, iterations=FINAL_ITERATIONS)
        fitted = extended.solve(fitted.parameters, fitted.free, iterations=FINAL_ITERATIONS)
    if (gain := problem.holdout_gain(without, fitted)) <= MIN_IMPROVEMENT:
        return _too_small(gain)
    return ""


def _too_small(gain: float) -> str:
    """Return the reason why a formula with a gain on the hold-out set was not added."""
    change = f"decreases it by {100.0 * gain:.1f} %" if gain > 0.0 else f"increases it by {-100.0 * gain:.1f} %"
    return f"it does not reduce the squared error on the hold-out set by {100.0 * MIN_IMPROVEMENT:.0f} % (it {change})"
