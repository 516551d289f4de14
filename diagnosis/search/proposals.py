"""What a search could not name: formulas that are added to the model if the hold-out set agrees.

Errors of the functional form, which the search used as disturbances, become one correction of the form. Structure that
no effect of the library explains becomes an effect of its own.

Terms in the inputs of the core alone are one effect ``form_...``, which the verdict names as a finer form, not as a
missing effect. Unless the final fit without it confirms an effect, the model remains as it is. Terms that also depend
on variables of an identified effect are not delivered: they would replace this effect in part.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from tirefmu.symbolic.added import AddedEffect
from tirefmu.tires.tire import Tire

from ..least_squares import LeastSquares, Solution
from ..probing.effect_probing import Screen
from ..thresholds import FINAL_ITERATIONS, MIN_IMPROVEMENT
from ..unexplained.formula_proposal import Added, Unknown, added_if_better, effect_of, unknown_of, with_columns
from ..unexplained.structure import CORE_INPUTS, Structure
from .effect_search import Search
from .settling import settle


@dataclass(frozen=True)
class FormCorrection:
    """A correction of the functional form of the model that the improved tire contains.

    Attributes
    ----------
    formulas : tuple of str
        As in an effect file: "quantity, factor or term: formula".
    effect : AddedEffect
        The effect file.
    """

    formulas: tuple[str, ...]
    effect: AddedEffect


def with_correction(
    search: Search, before: Screen, start: Tire, report: Callable[[str], None]
) -> tuple[FormCorrection | None, Tire]:
    """Add the errors of the functional form that the hold-out set confirms to the model of a search.

    Only those in the inputs of the steady-state core: others are errors of the form of an identified effect, which they
    would replace in part. And only beside an effect that is confirmed without them: where nothing is missing, the model
    remains as it is.

    Parameters
    ----------
    search : Search
        Completed; its problem and solution change if a correction is added.
    before : Screen
        Of the baseline model.
    start : Tire
        The baseline model.
    report : callable
        Called with a sentence.

    Returns
    -------
    FormCorrection or None
    Tire
        The baseline model, with the correction.
    """
    forms = [form for form in search.forms if set(form.depends_on) <= CORE_INPUTS]
    if not forms or not _confirms_effects(search, before):
        return None, start
    problem = replace(search.problem, disturbances=search.problem.disturbances.of_recording())
    solution = problem.solve(search.solution.parameters, search.solution.free, iterations=FINAL_ITERATIONS)
    chosen = _confirmed_by_holdout(forms, problem, solution)
    if not chosen:
        return None, start
    report("adding the correction of the functional form to the model equations")
    added = added_if_better(chosen, effect_of(chosen, prefix="form"), start, problem, solution)
    if not isinstance(added, Added):
        return None, start
    _continue_from(search, added)
    index, values, formulas = added.problem.simulator.index, added.solution.parameters, []
    names = iter(declaration.name for declaration in added.effect.declarations)
    for structure in chosen:
        formulas.append(structure.formula_with([values[index[next(names)]] for _ in structure.terms]))
    return FormCorrection(tuple(formulas), added.effect), added.tire


def _confirms_effects(search: Search, before: Screen) -> bool:
    """Return whether the final fit without a correction confirms an effect."""
    trial = search.copy()
    if trial.found:
        trial.progress = lambda sentence: None
        settle(trial, before)
    return bool(trial.found)


def _confirmed_by_holdout(forms: Sequence[Structure], problem: LeastSquares, solution: Solution) -> list[Structure]:
    """Return the forms each of which reduces the error on the hold-out set, after those before it."""
    chosen: list[Structure] = []
    for form in forms:
        tried = with_columns([*chosen, form], problem, solution)
        before = with_columns(chosen, problem, solution) if chosen else solution
        if problem.holdout_gain(before, tried) > MIN_IMPROVEMENT:
            chosen.append(form)
    return chosen


def with_unknown_structure(
    search: Search, start: Tire, report: Callable[[str], None]
) -> tuple[tuple[Unknown, ...], Tire]:
    """Add the formulas of unexplained structure that improve the hold-out set to the model of a search.

    Parameters
    ----------
    search : Search
        Completed; its problem and solution change if a formula is added.
    start : Tire
        The baseline model.
    report : callable
        Called with a sentence.

    Returns
    -------
    tuple of Unknown
    Tire
        The baseline model, with the formulas.
    """
    unknowns = []
    for structure in search.structures:
        effect = effect_of([structure])
        report("adding the proposed formula to the model equations")
        added = added_if_better([structure], effect, start, search.problem, search.solution)
        if isinstance(added, Added):
            start = added.tire
            _continue_from(search, added)
        unknowns.append(unknown_of(structure, effect, added))
    return tuple(unknowns), start


def _continue_from(search: Search, added: Added) -> None:
    search.problem, search.solution = added.problem, added.solution
    search.screen = Screen(search.problem, search.solution)
    search.last = search.probe()
