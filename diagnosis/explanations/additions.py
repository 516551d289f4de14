"""What could be added to an explanation: effects with their gains, those that take another one's place, formulas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ..probing.effect_probing import Screen
from ..thresholds import CONFOUNDED, RIVALS
from ..unexplained.features import CORE_INPUTS
from ..unexplained.formula_proposal import Dictionary
from ..weighted_columns import joined
from .evidence import NormalEquations, Projected
from .explanation import UNKNOWN, Term, prior_deviation, terms_of_form
from .linearization import Addition, Linearization, weighted_additions
from .refit import Refitted, Shared, refitted

#: Number of terms of a formula. Convention: computing time.
TERMS = 3
#: Correlation from which an effect may take the place of another one: a tenth of the variance is common. Convention.
ALIKE = 0.3


@dataclass(frozen=True, eq=False)
class Gain:
    """An addition with the increase of the logarithm of the evidence, prior odds included.

    - `estimate`, `of_fitted`: of what a refit fits of it, and its gain: it chooses between forms of an effect, each of
      which has the others among what is not fitted.
    """

    gain: float
    addition: Addition
    estimate: FloatArray
    of_fitted: float

    @classmethod
    def of(cls, addition: Addition, columns: Projected, group: slice, prior: float = 0.0) -> Gain:
        """Return the gain of an addition whose columns are a group of others."""
        of_fitted, estimate = columns.gain(slice(group.start, group.stop - addition.unfitted))
        return cls(columns.gain(group)[0] + prior, addition, estimate, of_fitted + prior)


def projected(linear: Linearization, additions: Sequence[Addition], *, exactly: bool = False) -> Projected:
    """Return the columns of additions without what an explanation contains; `exactly` as of `equations`."""
    equations, (added, cross) = linear.equations(exactly=exactly), linear.beside(additions)
    sizes = [len(addition.deviation) for addition in additions]
    return Projected.beside(equations, added, cross[: len(equations.target)], sizes)


def gains(columns: Projected, additions: Sequence[Addition]) -> dict[str, list[Gain]]:
    """Return what could be added to an explanation, by name, with its gain in the linear problem."""
    scored = dict[str, list[Gain]]()
    for addition, group in zip(additions, columns.groups, strict=True):
        scored.setdefault(addition.name, []).append(Gain.of(addition, columns, group, addition.log_prior))
    return scored


def in_place_of(part: str, linear: Linearization, additions: Sequence[Addition]) -> Projected:
    """Return the columns of additions with the response to a part as the residual; its column is the first group.

    Of the explanation, only its other coefficients and the errors of the recording are projected out: how well an
    addition takes the place of the part does not depend on what its form may err by.
    """
    problem, solution = linear.problem, linear.solution
    others = [name for name in solution.free if linear.explanation.owner(name) != part]
    recorded = problem.disturbances.of_recording()
    response = linear.responses.of(part)[:, :, None]
    fixed = [recorded.columns, linear.simulator.jacobian(solution.parameters, others), response]
    columns = joined([problem.weighted_columns(fixed), weighted_additions(problem, additions)])
    deviations = [
        recorded.deviation,
        problem.prior(others)[1],
        np.ones(1),
        *(addition.deviation for addition in additions),
    ]
    precision, matrix = np.concatenate(deviations) ** -2.0, columns.times(columns)
    place = len(recorded.deviation) + len(others)
    normal = NormalEquations(matrix, matrix[place], float(matrix[place, place]), precision, np.zeros(len(precision)))
    return Projected.of(normal, [1, *(len(addition.deviation) for addition in additions)])


def rivals_of(columns: Projected, additions: Sequence[Addition]) -> dict[str, Gain]:
    """Return the best addition of each of the `RIVALS` effects most like a part, by `in_place_of`, most of all first.

    An effect that is little like the part alone may take its place together with others, whose memories change then.
    """
    correlation, best = dict[str, float](), dict[str, Gain]()
    for addition, group in zip(additions, columns.groups[1:], strict=True):
        size = float(columns.correlations(slice(group.start, group.stop - addition.unfitted))[0])
        correlation[addition.name] = max(correlation.get(addition.name, 0.0), size)
        gain = Gain.of(addition, columns, group)
        if addition.name not in best or graded(gain.of_fitted) > graded(best[addition.name].of_fitted):
            best[addition.name] = gain
    alike = [name for name, size in correlation.items() if size > ALIKE]
    return {name: best[name] for name in sorted(alike, key=lambda name: -graded(correlation[name]))[:RIVALS]}


def reproduced_terms(linear: Linearization) -> frozenset[str]:
    """Return the texts of terms of slips and load that a candidate of these inputs alone reproduces.

    They are this effect, and no errors of form. `linear`: of the baseline model.
    """
    terms = terms_of_form(linear.problem, linear.solution)
    static = [name for name, candidate in linear.candidates.items() if not candidate.has_states]
    of_core = [name for name in static if linear.candidates[name].reads <= CORE_INPUTS]
    effects = [addition for name in of_core for addition in linear.of_effect(name)]
    if not terms or not effects:
        return frozenset()
    columns = projected(linear, [_together(terms), *effects])
    alike = np.max([columns.correlations(group)[: len(terms)] for group in columns.groups[1:]], axis=0)
    return frozenset(term.text for term, size in zip(terms, alike.tolist(), strict=True) if size > CONFOUNDED)


def best_formula(shared: Shared, refit: Refitted) -> Refitted | None:
    """Return a refit with a formula at one location, without terms without which its score is larger.

    None if it gains nothing beside all formulas at this location that are errors of form: one of the speed resembles
    one of slips and load.
    """
    dictionary, errors = Dictionary(_screen(refit)), refit.linear.form_errors
    of_form = [errors.contain(at, term.depends_on.union(at.proportional_to)) for at, term in dictionary.terms]
    best = _without_idle_terms(shared, _grown(shared, refit, dictionary, of_form))
    if not (terms := best.explanation.terms):
        return None
    beside = [
        _term(shared, dictionary, i)
        for i, (at, _) in enumerate(dictionary.terms)
        if of_form[i] and at == terms[0].location
    ]
    columns = projected(refit.linear, [_together([*beside, *terms])])
    gain = columns.gain(columns.groups[0])[0] - columns.gain(slice(0, len(beside)))[0]
    return best if gain + best.explanation.log_prior > refit.explanation.log_prior else None


def _together(terms: Sequence[Term]) -> Addition:
    return Addition(
        UNKNOWN, np.stack([term.column for term in terms], axis=-1), np.array([term.deviation for term in terms])
    )


def _grown(shared: Shared, refit: Refitted, dictionary: Dictionary, of_form: Sequence[bool]) -> Refitted:
    """Return a refit with terms at one location, which are added while the score grows.

    Each is one of all that were tested. The first one is no error of form.
    """
    best, possible = refit, [i for i, contained in enumerate(of_form) if not contained]
    while possible and len(best.explanation.terms) < TERMS:
        i, gain = _best_term(shared, best, dictionary, dictionary.shortlisted(_screen(best), possible))
        explanation = best.explanation.with_term(_term(shared, dictionary, i))
        if gain + explanation.log_prior <= best.explanation.log_prior:
            break
        more = refitted(shared, explanation, [best.linear.solution.parameters], best.linear.simulator)
        if more.score <= best.score:
            break
        place, texts = dictionary.terms[i][0], {term.feature.text for term in explanation.terms}
        possible = [k for k, (at, term) in enumerate(dictionary.terms) if at == place and term.text not in texts]
        best = more
    return best


def _without_idle_terms(shared: Shared, best: Refitted) -> Refitted:
    """Return the refit of a formula without the terms without which its score is larger."""
    while len(best.explanation.terms) > 1:
        fewer = [
            refitted(shared, explanation, [best.linear.solution.parameters], best.linear.simulator)
            for explanation in best.explanation.with_a_term_less()
        ]
        other = max(fewer, key=lambda refit: graded(refit.score))
        if other.score <= best.score:
            break
        best = other
    return best


def _best_term(shared: Shared, refit: Refitted, dictionary: Dictionary, tried: Sequence[int]) -> tuple[int, float]:
    """Return the term with the largest gain in the linear problem, and this gain."""
    additions = [_together([_term(shared, dictionary, i)]) for i in tried]
    columns = projected(refit.linear, additions)
    gained = [columns.gain(group)[0] for group in columns.groups]
    return tried[int(np.argmax(graded(gained)))], max(gained)


def _term(shared: Shared, dictionary: Dictionary, i: int) -> Term:
    (location, feature), column = dictionary.terms[i], dictionary.column(i)
    deviation = prior_deviation(shared.problem, column)
    return Term(location, feature, column, deviation, -float(np.log(len(dictionary.terms))))


def _screen(refit: Refitted) -> Screen:
    """Return the linearization of a refit in rows of independent noise."""
    problem = replace(refit.linear.problem, whitening=None)
    return Screen(problem, problem.at(refit.linear.solution.parameters, refit.linear.solution.free))
