"""The formula that explains most of what an explanation does not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...numerics.ties import graded
from ..probing.effect_probing import Screen
from ..unexplained.formula_proposal import Dictionary
from .explanation import UNKNOWN, Term
from .gains import projected
from .linearization import Addition
from .refit import Refitted, Shared, refitted
from .terms import prior_deviation

#: Number of terms of a formula. Convention: computing time.
TERMS = 3


def best_formula(shared: Shared, refit: Refitted) -> Refitted:
    """Return a refit with a formula at one location, without terms without which its score is larger."""
    return _without_idle_terms(shared, _grown(shared, refit))


def _grown(shared: Shared, refit: Refitted) -> Refitted:
    """Return a refit with terms at one location, which are added while the score grows.

    Each is one of all that were tested. The first one is no error of form.
    """
    dictionary, best, errors = Dictionary(_screen(refit)), refit, refit.linear.form_errors
    possible = [
        i
        for i, (location, feature) in enumerate(dictionary.terms)
        if not errors.contain(location, feature.depends_on.union(location.proportional_to))
    ]
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
    terms = [_term(shared, dictionary, i) for i in tried]
    additions = [Addition(UNKNOWN, term.column[:, :, None], np.array([term.deviation])) for term in terms]
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
