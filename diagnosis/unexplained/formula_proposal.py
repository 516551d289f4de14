"""Unknown structure as an effect of the book: its file, and the test on rows that no decision has seen."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.added import AddedEffect, read_effect
from tirefmu.symbolic.errors import EffectError
from tirefmu.symbolic.escaping import toml_string
from tirefmu.tires.tire import Tire

from ..least_squares import LeastSquares, Solution
from ..recording.simulation import Simulator
from ..thresholds import LEAST_IMPROVEMENT, REACH
from .structure import Structure

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Unknown:
    """Structure that no known effect explains.

    Attributes
    ----------
    depends_on : tuple of str
    formula : str
        As it would stand in an effect file: "quantity: factor or term".
    added : bool
        Whether the improved tire has it: only if the untouched hold-out improves.
    effect : AddedEffect or None
        The proposed effect file.
    not_added_because : str
        "" where it was added.
    next_measurement : str
        What would show its form.
    """

    depends_on: tuple[str, ...]
    formula: str
    added: bool
    effect: AddedEffect | None = None
    not_added_because: str = ""
    next_measurement: str = ""


@dataclass(frozen=True, eq=False)
class Added:
    """A formula that stands in the model now.

    Attributes
    ----------
    effect : AddedEffect
    tire : Tire
        The start model with the formula's effect beside its own.
    problem : LeastSquares
    solution : Solution
    """

    effect: AddedEffect
    tire: Tire
    problem: LeastSquares
    solution: Solution


def effect_of(structure: Structure) -> AddedEffect | None:
    """Return structure as an effect file would have it, or None where no file can say it.

    Parameters
    ----------
    structure : Structure

    Returns
    -------
    AddedEffect or None
    """
    if not structure.written:
        return None
    sizes = structure.trace.estimate
    names = [f"FOUND{i + 1}" for i in range(len(sizes))]
    cards = "\n".join(
        f'{name} = {{description = {toml_string("found: " + term.text)}, unit = "1", lower = {-_reach(size)!r}, '
        f"upper = {_reach(size)!r}{', flips = true' if structure.place.flips else ''}}}"
        for name, term, size in zip(names, structure.terms, sizes, strict=True)
    )
    total = " + ".join(f"{name}*({term.text})" for name, term in zip(names, structure.terms, strict=True))
    carried = f"{structure.place.per}*" if structure.place.per else ""
    acts = "\n".join(
        f'[[acts]]\non = "{quantity}"\n{structure.place.how} = '
        + (f'"1 + {total}"' if structure.place.how == "factor" else f'"{carried}({total})"')
        for quantity in structure.place.quantities
    )
    name = "found_" + "_".join(structure.depends_on).lower()
    text = (
        f'name = "{name}"\nphysics = "{structure.place.name} changes with {", ".join(structure.depends_on)}"\n'
        f'source = "proposed by the diagnosis of a recording"\n[coefficients]\n{cards}\n{acts}\n'
    )
    return read_effect(text, f"{name}.toml")


def unknown_of(structure: Structure, effect: AddedEffect | None, added: Added | None) -> Unknown:
    """Return what a verdict tells of structure that no known effect explains.

    Parameters
    ----------
    structure : Structure
    effect : AddedEffect or None
        What `effect_of` made of it.
    added : Added or None
        What `added_if_better` made of it.
    """
    formula, why = structure.formula, ""
    if added:
        place = added.problem.simulator.place
        formula = structure.formula_with(
            [added.solution.parameters[place[card.name]] for card in added.effect.declarations]
        )
    elif effect:
        why = "the rows kept apart do not come closer by it"
    else:
        why = "it depends on how an input changes: an effect file knows the inputs of the moment, no rate and no memory"
    asks = [_SHOWN_BY[name] for name in structure.depends_on if name in _SHOWN_BY]
    return Unknown(structure.depends_on, formula, added is not None, effect, why, asks[0] if asks else "")


#: What shows the form of structure that depends on a rate: a lag goes by distance rolled, a delay by time, friction
#: within the carcass by the direction alone.
_SHOWN_BY = {
    "dalpha/dt": "sweep alpha at three rates and two speeds, up and down",
    "dkappa/dt": "sweep kappa at three rates and two speeds, up and down",
    "dFz/dt": "step the load at constant slip, at two speeds",
    "memory": "hold the slip after a sweep, and repeat the sweep after a rest",
}


def _reach(size: float) -> float:
    return max(abs(float(size)), 1e-4) * REACH


def added_if_better(
    structure: Structure, effect: AddedEffect, start: Tire, problem: LeastSquares, solution: Solution
) -> Added | None:
    """Put a formula into the model and keep it if the untouched hold-out improves.

    Parameters
    ----------
    structure : Structure
    effect : AddedEffect
        What `effect_of` made of it.
    start : Tire
    problem : LeastSquares
    solution : Solution
        Before the formula.

    Returns
    -------
    Added or None
        None where the hold-out does not improve, or the book has no place for the formula.
    """
    beside = problem.disturbances.extended(
        tuple(card.name for card in effect.declarations),
        structure.columns,
        np.abs(structure.trace.estimate) * REACH + 1e-6,
    )
    tried = replace(problem, disturbances=beside).solve(solution.parameters, solution.free, iterations=3)
    if not _better(problem, solution, tried):
        return None
    try:
        tire = replace(start, added=(*start.added, effect))
        simulator = Simulator(tire, problem.simulator.signals)
    except EffectError:
        return None
    parameters = tire.parameters()
    for name in problem.simulator.names:
        parameters[simulator.place[name]] = solution.parameters[problem.simulator.place[name]]
    for card, size in zip(effect.declarations, structure.trace.estimate, strict=True):
        parameters[simulator.place[card.name]] = size
    whole = replace(problem, simulator=simulator)
    free = (*solution.free, *(card.name for card in effect.declarations))
    fitted = whole.solve(parameters, free, iterations=8)
    return Added(effect, tire, whole, fitted) if _better(problem, solution, fitted) else None


def _better(problem: LeastSquares, before: Solution, after: Solution) -> bool:
    """Return whether the hold-out's squared misfit, in the training rows' own, falls."""
    signals = problem.simulator.signals
    kept = signals.present & signals.holdout
    learns = problem.root > 0.0
    sums = []
    for solution in (before, after):
        total = 0.0
        for i in range(len(signals.channels)):
            scale = float(np.mean(before.residual[i][learns[i]] ** 2)) if learns[i].any() else np.inf
            total += float(np.sum(solution.residual[i][kept[i]] ** 2)) / scale
        sums.append(total)
    return sums[1] < (1.0 - LEAST_IMPROVEMENT) * sums[0]
