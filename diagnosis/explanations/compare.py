"""How probable the identified effects are: they are compared with their rivals.

Compared are the identified effects, all explanations with one effect more or an unknown component, all with one less,
and all with another one in place of one. Rivals that come near are refitted; the others keep the evidence of the linear
problem at the explanation next to them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ..least_squares import Solution
from ..probing.candidates import Candidate
from ..probing.effect_probing import Screen, starts
from ..search.effect_search import Search
from ..thresholds import CONFOUNDED, REFIT_MARGIN, RIVALS
from .answer import Answer, answer_of
from .evidence import Projected
from .explanation import UNKNOWN, Explanation, Term
from .linearization import Addition, Linearization, term_of
from .refit import Refitted, Shared, refitted, shared_problem

FloatArray = npt.NDArray[np.float64]


def compared(
    search: Search, before: Screen, candidates: Mapping[str, Candidate], progress: Callable[[str], None]
) -> Answer:
    """Return the probabilities of the effects and the structure that a search identified, and of their rivals.

    Parameters
    ----------
    search : Search
        Completed and settled.
    before : Screen
        Of the baseline model, before formulas were added to it.
    candidates : mapping of str to Candidate
        All that were tested.
    progress : callable
        Called with a sentence.

    Returns
    -------
    Answer
    """
    baseline = before.solution
    problem = replace(before.problem, disturbances=before.problem.disturbances.of_recording())
    simulator, parameters = problem.simulator, baseline.parameters.copy()
    known = [name for name in simulator.names if name in search.problem.simulator.index]
    values = search.solution.parameters[[search.problem.simulator.index[name] for name in known]]
    parameters[[simulator.index[name] for name in known]] = values
    forms = tuple((refit.name, refit.form) for refit in search.found)
    terms = [
        term
        for one in search.structures
        for column in np.moveaxis(one.columns, -1, 0)
        for term in term_of(problem, one.formula, column, one.tests)
    ]
    fitted = {*baseline.free, *(name for _, form in forms for name in form.free)}
    at = problem.at(parameters, tuple(sorted(fitted, key=simulator.names.index)))
    return _ranked(Linearization(Explanation(forms, tuple(terms)), problem, at, candidates), baseline, progress)


def _ranked(linear: Linearization, baseline: Solution, progress: Callable[[str], None]) -> Answer:
    """Return the probabilities of the explanation of a linearization and of its rivals."""
    identified, additions = linear.explanation, linear.additions()
    shared = shared_problem(linear, baseline, additions)
    evidences: dict[tuple[str, ...], float] = {}
    first = _compared(shared, identified, linear.solution.parameters, evidences)
    _add(shared, first, additions, evidences, refits=0)
    absent = first.linear.simulator.tire.parameters()
    for part in identified.parts:
        progress(f"comparing {part} with other explanations")
        start = first.linear.solution.parameters.copy()
        freed = [name for one, form in identified.forms if one == part for name in form.free]
        indices = [first.linear.simulator.index[name] for name in freed]
        start[indices] = absent[indices]
        less = _compared(shared, identified.without(part), start, evidences, first)
        _add(shared, less, less.linear.additions(), evidences, refits=RIVALS)
    if len(identified.parts) > 1:
        _compared(shared, Explanation(), baseline.parameters, evidences, first)
    return answer_of(evidences, linear.candidates)


def _compared(
    shared: Shared, explanation: Explanation, start: FloatArray, evidences: dict[tuple[str, ...], float],
    near: Refitted | None = None,
) -> Refitted:  # fmt: skip
    """Refit an explanation with the skew of another one first, and store its evidence."""
    refit = refitted(shared, explanation, start, (near.linear if near else shared).problem.simulator)
    evidences[explanation.parts] = refit.evidence + explanation.log_prior
    return refit


def _add(
    shared: Shared, refit: Refitted, additions: Sequence[Addition], evidences: dict[tuple[str, ...], float], *,
    refits: int,
) -> None:  # fmt: skip
    """Store the evidence of an explanation with each addition; the best ones are refitted.

    The first `refits` ones always are, others from `REFIT_MARGIN` on.
    """
    if not additions:
        return
    projected = Projected.of(refit.linear.equations(additions), [len(one.deviation) for one in additions])
    known = _known(projected, additions)
    base = evidences[refit.explanation.parts]
    scored = dict[str, list[tuple[float, Addition, FloatArray]]]()
    for addition, group in zip(additions, projected.groups, strict=True):
        if addition.name != UNKNOWN or not known[group].any():
            gain, estimate = projected.gain(group)
            scored.setdefault(addition.name, []).append((gain + addition.log_prior, addition, estimate))
    totals = {name: float(np.logaddexp.reduce([gain for gain, _, _ in forms])) for name, forms in scored.items()}
    for number, name in enumerate(sorted(totals, key=lambda one: -totals[one])):
        gain, best, estimate = max(scored[name], key=lambda one: one[0])
        extended = _with(refit.explanation, best)
        if extended.parts in evidences:
            continue
        evidences[extended.parts] = base + totals[name]
        if number < refits or base + totals[name] > max(evidences.values()) + REFIT_MARGIN:
            _refit(shared, refit, best, estimate, extended, evidences, totals[name] - gain)


def _known(projected: Projected, additions: Sequence[Addition]) -> npt.NDArray[np.bool_]:
    """Return which columns an effect of the library reproduces: as terms, these are not unknown."""
    known = np.zeros(len(projected.target), dtype=bool)
    for addition, group in zip(additions, projected.groups, strict=True):
        if addition.name != UNKNOWN:
            known |= projected.correlations(group) > CONFOUNDED
    return known


def _refit(
    shared: Shared, refit: Refitted, addition: Addition, estimate: FloatArray, extended: Explanation,
    evidences: dict[tuple[str, ...], float], other_forms: float,
) -> None:  # fmt: skip
    """Store the evidence of a refitted addition.

    Coefficients of a grid are fitted, so that all of its points are one explanation. `other_forms`: logarithm of the
    evidence of all terms relative to that of the best one.
    """
    simulator, solution = refit.linear.simulator, refit.linear.solution
    if isinstance(addition.part, Term):
        one = refitted(shared, extended, solution.parameters, simulator)
        evidences[extended.parts] = one.evidence + extended.log_prior + other_forms
        return
    tried = [
        refitted(shared, extended, start, simulator)
        for start in starts(simulator, solution, addition.part, estimate * addition.deviation)
    ]
    evidences[extended.parts] = max(one.evidence for one in tried) + extended.log_prior


def _with(explanation: Explanation, addition: Addition) -> Explanation:
    if isinstance(addition.part, Term):
        return Explanation(explanation.forms, (*explanation.terms, addition.part))
    return Explanation((*explanation.forms, (addition.name, addition.part)), explanation.terms)
