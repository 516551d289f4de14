"""The most probable explanation of a recording: explanations are refitted, extended, reduced and exchanged, best first.

All compared explanations have one noise and one discrepancy, those of the leading explanation. When another one leads,
both are estimated again and the comparison is repeated. Each move is a function of a table; it yields the table after
each refit, so that what is compared when the time ends is the answer.
"""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ...symbolic.detection import Form
from ..least_squares import LeastSquares, Solution
from ..probing.candidates import Candidate
from ..probing.effect_probing import starts
from ..thresholds import CONFOUNDED, EFFECT_ODDS, REFIT_MARGIN, RIVALS
from .additions import Gain, best_formula, gains, in_place_of, projected, reproduced_terms, rivals_of
from .answer import NAMED, UNSURE, Answer, answer_of
from .budget import Budget, Ended
from .effect_evidence import with_rivals
from .evidence import inflation
from .explanation import UNKNOWN, Explanation, form_errors
from .linearization import Addition, Linearization, forget_columns
from .refit import Refitted, Shared, refitted, shared_problem, some_rows, with_terms
from .table import FAR, Parts, Table, fold_evidences

#: A move: yields the table after each refit, returns the last one.
Move = Generator[Table, None, Table]

#: Number of estimates of the noise, of those under which all that nearly leads is compared, and of explanations that
#: are extended under each of these; growth of the variance of the noise after which it is estimated again. Conventions:
#: computing time.
ESTIMATES, SETTLED, COMPARED, GROWTH = 5, 2, 6, 1.5


@dataclass(frozen=True, eq=False)
class ComparedExplanations:
    """The answer, the refit of the explanation that is delivered, and what all explanations have in common.

    - `stopped`: why explanations were not compared; empty if all were.
    """

    answer: Answer
    leader: Refitted
    shared: Shared
    stopped: str = ""


def compared(
    problem: LeastSquares, baseline: Solution, candidates: Mapping[str, Candidate], budget: Budget
) -> ComparedExplanations:
    """Compare explanations of a recording.

    Parameters
    ----------
    problem : LeastSquares
        Of the baseline model.
    baseline : Solution
    candidates : mapping of str to Candidate
    budget : Budget

    Returns
    -------
    ComparedExplanations
        The best so far if the budget ends.
    """
    few = problem.subsampled(some_rows(problem.simulator))
    few = few.over(few.simulator.driven_at(baseline.parameters))
    at_few = few.at(baseline.parameters, baseline.free)
    linear = Linearization(Explanation(), few, at_few, dict(sorted(candidates.items())))
    latest, settled, stopped = list[Table](), list[Table](), ""
    try:
        for table in _tables(linear, few, baseline, budget, settled):
            same = bool(latest) and latest[-1].shared is table.shared
            latest[:] = [*latest[: len(latest) - same][-1:], table]
        settled[:] = [_with_those_of(table, settled) for table in settled]
    except Ended:
        stopped = budget.ended
    # A table that was stopped at its beginning has compared less than the one before.
    tables = settled or [max(latest, key=lambda table: len(table.scores))]
    scores = [fold_evidences(table) for table in tables]
    absent = [np.full_like(next(iter(evidences.values())), -np.inf) for evidences in scores]
    evidences = {
        parts: np.concatenate([of.get(parts, missing) for of, missing in zip(scores, absent, strict=True)])
        for parts in dict.fromkeys(parts for of in scores for parts in of)
    }
    answer = answer_of(evidences, candidates)
    leader = _simplest(tables[-1], answer)
    if not stopped:
        answer, leader = with_rivals(answer, leader, tables[-1], few, baseline)
    forget_columns()
    with_terms.cache_clear()
    return ComparedExplanations(answer, leader, tables[-1].shared, stopped)


def _with_those_of(table: Table, others: Collection[Table]) -> Table:
    """Return a table with refits of what is probable under the noise of others.

    A comparison may not find what leads in another one. All are refitted from where the others ended.
    """
    simulator = table.refits[()].linear.simulator
    for refit in [refit for other in others if other is not table for refit in other.probable()]:
        start = refit.linear.solution.parameters
        table = table.with_refit(refitted(table.shared, refit.explanation, [start], simulator))
    return table


def _simplest(table: Table, answer: Answer) -> Refitted:
    """Return the leader without what only weak evidence adds, with the simplest of effects of which one is missing.

    Evidence of less than ten to one is weak, and so is that of which of several effects it is. The simplest one has the
    fewest states; of these it is the most probable one, as the evidence counts coefficients.
    """
    leader, model = _with_fewest_parts(table, answer), table.shared.problem.simulator.symbolic_model
    probability = dict.fromkeys(table.refits, 0.0)
    probability |= {explanation.parts: explanation.probability for explanation in answer.explanations}
    states = {effect.name: len(effect.states) for effect in model.added}

    def size(refit: Refitted) -> tuple[int, float]:
        number = sum(states.get(name, 0) for name in refit.explanation.effects)
        return number, -graded(probability[refit.explanation.parts])

    for alternatives in answer.one_of(leader.explanation.effects):
        rest = set(leader.explanation.parts).difference(alternatives.effects)
        least = UNSURE * probability[leader.explanation.parts]
        equal = [
            refit
            for parts, refit in table.refits.items()
            if set(parts).difference(alternatives.effects) == rest
            and len(parts) == len(rest) + 1
            and probability[parts] > least
        ]
        leader = min(equal, key=size, default=leader)
    return leader


def _with_fewest_parts(table: Table, answer: Answer) -> Refitted:
    """Return the best refit with all that is called missing, without other parts that only weak evidence adds."""
    named = {part for part, probability in answer.probabilities.items() if probability >= NAMED}
    able = [refit for parts, refit in table.refits.items() if named.issubset(parts)]
    leader = max(able, key=lambda refit: graded(refit.score), default=table.leader)
    most, doubtful = set(leader.explanation.parts), answer.doubtful(leader.explanation.effects)
    least = most.difference(doubtful, {UNKNOWN} - named)
    equal = [
        refit
        for parts, refit in table.refits.items()
        if least <= set(parts) <= most and refit.score > leader.score + np.log(UNSURE)
    ]
    return min(equal, key=lambda refit: (len(refit.explanation.parts), -graded(refit.score)), default=leader)


def _tables(
    linear: Linearization, few: LeastSquares, baseline: Solution, budget: Budget,
    settled: list[Table],
) -> Generator[Table]:  # fmt: skip
    """Compare explanations under the noise of each leading one in turn.

    All that nearly lead are compared under the noise of an explanation that explains nearly as much. `settled`: these
    tables are added. Nobody knows the noise, and an explanation leads easily under its own: all of them count equally.
    """
    seen, far, explained = set[Parts](), frozenset[Parts](), 0.0
    reproduced = reproduced_terms(linear)
    for remaining in reversed(range(ESTIMATES)):
        empty = replace(_empty(linear, baseline, reproduced, explained, budget), far=far)
        table = yield from _climbed(empty, linear)
        seen.add(linear.explanation.parts)
        first = bool(table.leader.explanation.parts) and not linear.explanation.parts
        searched = not remaining or not (first or _growth(table) > GROWTH)
        several = searched and len(table.leader.explanation.parts) > 1
        if several:  # one formula may be in the place of all of them
            table = yield from _with_formulas(table, [()])
        if searched:
            table = yield from _settled(table)
        if searched and (not remaining or 1.0 / GROWTH <= _growth(table) <= GROWTH):
            # Two explanations may lead in turn, each under the noise of the other one: then the smaller one leads.
            last = not remaining or len(settled) + 1 == SETTLED
            if last or table.leads_again(seen, linear.explanation):
                places = _places_of_formulas(table)[several:]
                before, table = table.leader, (yield from _with_formulas(table, places))
                if table.leader is not before:
                    table = yield from _settled(table)
            settled.append(table.condensed())
            if last or table.leads_again(seen, linear.explanation):
                break
            far |= table.behind(FAR)
        explained, linear = table.explained, _with_own_noise(table.leader, few)


def _growth(table: Table) -> float:
    """Return the variance of the noise by what the leader explains, relative to that of the comparison."""
    return inflation(table.explained) / inflation(table.shared.explained)


def _empty(
    linear: Linearization, baseline: Solution, reproduced: Collection[str], explained: float, budget: Budget
) -> Table:
    """Return an empty table under the noise of a linearization.

    `reproduced`: terms that are no errors of form. `explained`: logarithm of the likelihood by which the explanation of
    the linearization is better than none.
    """
    additions = dict[str, list[Addition]]()
    for name in linear.lacking:
        budget.check()
        additions[name] = linear.of_effect(name)
    every = [addition.fitted() for forms in additions.values() for addition in forms]
    shared = shared_problem(linear, baseline, every, reproduced, explained, budget)
    weighted = {name: [addition.weighted(shared.problem) for addition in forms] for name, forms in additions.items()}
    return Table(shared, baseline.parameters, weighted)


def _with_own_noise(leader: Refitted, problem: LeastSquares) -> Linearization:
    """Return the linearization of a refit with rows of independent noise and without a discrepancy.

    Its forces drive the states from then on.
    """
    simulator = leader.linear.simulator.driven_at(leader.linear.solution.parameters)
    bare = with_terms(problem, leader.explanation.terms).over(simulator)
    at = bare.at(leader.linear.solution.parameters, leader.linear.solution.free)
    return replace(leader.linear, problem=bare, solution=at)


def _climbed(table: Table, linear: Linearization) -> Move:
    """Extend the leading explanation while an extension leads, or until the noise is to be estimated again."""
    table = table.with_refit(refitted(table.shared, Explanation(), [table.absent], linear.simulator))
    yield table
    if linear.explanation.parts:
        start, static = linear.solution.parameters, linear.responses.static
        whole = refitted(table.shared, linear.explanation, [start], linear.simulator)
        table = table.with_refit(whole)
        yield table
        if static.parts not in table.refits:
            table = table.with_refit(refitted(table.shared, static, [table.without(whole, static)], linear.simulator))
            yield table
    before = None
    while before is not table.leader and _growth(table) <= GROWTH:
        before = table.leader
        table = yield from extended(*_gained(table, before), before)
    return table


def _settled(table: Table) -> Move:
    """Extend, reduce and exchange all explanations that nearly lead, until none is left.

    Also the best ones without a part that all of these have: its name is as certain as these were searched.
    """
    settled = set[Parts]()
    while len(settled) < COMPARED:
        remaining = [parts for parts in (*table.near(), *table.doubts) if parts not in settled]
        if not remaining:
            break
        refit = table.refits[remaining[0]]
        settled.add(remaining[0])
        table, exactly = _gained(table, refit, exactly=True)  # before refits, which free the columns of this one
        table, scored = _gained(table, refit)
        table = yield from reduced(table, refit)
        if remaining[0] in (*table.roots, *table.doubts):
            table = yield from exchanged(table, refit)
            table = yield from extended_boldly(table, exactly, refit)
        table = yield from extended(table, scored, refit)
    return table


def _gained(table: Table, refit: Refitted, *, exactly: bool = False) -> tuple[Table, dict[str, list[Gain]]]:
    """Return the table with what could be added to a refit, and the gains (`exactly` as of `projected`)."""
    table, possible = table.possible(refit.linear)
    return table, gains(projected(refit.linear, possible, exactly=exactly), possible) if possible else {}


def reduced(table: Table, refit: Refitted) -> Move:
    """Compare an explanation with those that lack one of its parts; those that may lead are refitted."""
    fewer = {part: refit.explanation.without(part) for part in refit.explanation.parts}
    fewer = {part: less for part, less in fewer.items() if less.parts not in table.refits}
    for part, less in fewer.items():
        if part != UNKNOWN:
            table = table.with_linear(less.parts, refit.linear.evidence_without(part), less.log_prior)
    for part, less in fewer.items():
        if part != UNKNOWN and table.is_far(less.parts):
            continue
        table.report(f"comparing {part} with other explanations")
        start = table.without(refit, less)
        table = table.with_refit(refitted(table.shared, less, [start], refit.linear.simulator))
        yield table
    return table


def extended(table: Table, scored: Mapping[str, Collection[Gain]], refit: Refitted) -> Move:
    """Compare an explanation with those that have one effect more; from `REFIT_MARGIN` on they are refitted.

    `scored`: gains of what could be added.
    """
    table.report(f"adding an effect to {', '.join(refit.explanation.parts) or 'the baseline model'}")
    totals = {name: float(np.logaddexp.reduce([form.gain for form in forms])) for name, forms in scored.items()}
    before = refit.evidence - float(np.log(EFFECT_ODDS))
    for name in sorted(totals, key=lambda part: -graded(totals[part])):
        more = _with_gain(table, refit.explanation, _best(scored[name]))
        if more.parts in table.refits:
            continue
        evidence, prior = before + totals[name], more.log_prior
        score = evidence + prior
        if more.terms == refit.explanation.terms:  # the evidence has those that would be errors of form, too
            table = table.with_linear(more.parts, evidence, prior)
        if score > max(table.scores.values()) + REFIT_MARGIN:
            table = table.with_refit(_with_effect(table, refit, more, _best(scored[name])))
            yield table
    return table


def extended_boldly(table: Table, scored: Mapping[str, Collection[Gain]], refit: Refitted) -> Move:
    """Refit an explanation with each of the `RIVALS` effects that would gain most if its effects had an exact form.

    The errors of the form of an effect contain much of what a similar effect does. In the linear problem it gains
    little beside them, in a refit it may make the other one, and thus its errors, small.

    `scored`: these gains.
    """
    best = {name: _best(forms) for name, forms in scored.items()} if refit.explanation.effects else {}
    for name in sorted(best, key=lambda part: -graded(best[part].gain))[:RIVALS]:
        more = _with_gain(table, refit.explanation, best[name])
        if best[name].gain > 0.0 and not table.compared(more):
            table.report(f"comparing {', '.join(refit.explanation.parts)} with {name}")
            table = table.with_refit(_with_effect(table, refit, more, best[name]))
            yield table
    return table


def exchanged(table: Table, refit: Refitted) -> Move:
    """Refit explanations in which a confounded effect takes the place of one of the effects.

    The linear problem at the explanation without it states little about what acts through time: all others follow then.
    """
    table, possible = table.possible(refit.linear)
    for part in refit.explanation.effects if possible else ():
        less = refit.explanation.without(part)
        for name, best in rivals_of(in_place_of(part, refit.linear, possible), possible).items():
            more = _with_gain(table, less, best)
            if table.compared(more):
                continue
            table.report(f"comparing {part} with {name}")
            begins = _starts(table, refit, more, best)
            if less.parts in table.refits:
                begins = [*_starts(table, table.refits[less.parts], more, best), *begins]
            table = table.with_refit(refitted(table.shared, more, begins, refit.linear.simulator))
            yield table
        table = yield from _with_both(table, refit, part)
    return table


def _with_both(table: Table, refit: Refitted, part: str) -> Move:
    """Refit an explanation with an effect and with the one that takes its place best: two similar ones may be missing.

    Beside the errors of form of the one, the other gains nothing: half of each is the initial value.
    """
    less = set(refit.explanation.parts).difference([part])
    others = {
        name: other
        for parts, other in table.refits.items()
        if less.issubset(parts) and part not in parts and not table.is_far(parts)
        for name in set(other.explanation.effects).difference(less)
        if len(parts) == len(less) + 1
    }
    if not others:
        return table
    name = max(others, key=lambda effect: graded(others[effect].score))
    more = _with_form(table, refit.explanation, name, dict(others[name].explanation.forms)[name])
    if not table.compared(more):
        table.report(f"comparing {part} with both {part} and {name}")
        start = 0.5 * (table.without(refit, more) + table.without(others[name], more))
        for effect, of in ((part, refit), (name, others[name])):
            form = dict(of.explanation.forms)[effect]
            whole = [of.linear.simulator.index[free] for free in form.free if not form.scalable or free in form.grid]
            start[whole] = of.linear.solution.parameters[whole]
        table = table.with_refit(refitted(table.shared, more, [start], refit.linear.simulator))
        yield table
    return table


def _places_of_formulas(table: Table) -> list[Parts]:
    """Return the baseline model, then the leading explanation with one part less, and this explanation.

    Those with less lack one of the `RIVALS` parts that are missed least: a formula may be in its place.
    """
    leader = table.leader.explanation
    less = [leader.without(part).parts for part in leader.effects]
    less = sorted(less, key=lambda parts: -graded(table.scores.get(parts, -np.inf)))[:RIVALS]
    return list(dict.fromkeys([(), *less, leader.parts]))


def _with_formulas(table: Table, places: Collection[Parts]) -> Move:
    """Compare formulas for what some explanations do not explain, until one of them leads."""
    leader = table.leader
    for parts in places:
        if table.leader is leader and parts in table.refits and UNKNOWN not in leader.explanation.parts:
            table.report(f"searching for a formula in addition to {', '.join(parts) or 'the baseline model'}")
            table, formula = _formula(table, table.refits[parts])
            table = table.with_refit(formula) if formula and table.probable_with(formula, parts) else table
            yield table
    return table


def _formula(table: Table, refit: Refitted) -> tuple[Table, Refitted | None]:
    """Return an explanation with the formula that explains most of what it does not.

    What an effect of the library reproduces is no unknown effect.
    """
    formula = best_formula(table.shared, refit)
    if formula is None:
        return table, None
    table, effects = table.possible(refit.linear)
    change = np.stack([term.column for term in formula.explanation.terms], axis=-1) @ np.array(formula.term_sizes)
    alone = Addition(UNKNOWN, change[:, :, None], np.ones(1))
    whole = projected(refit.linear, [alone, *effects])
    reproduced = any(whole.correlations(group)[0] > CONFOUNDED for group in whole.groups[1:])
    return table, None if reproduced else formula


def _best(forms: Collection[Gain]) -> Gain:
    return max(forms, key=lambda form: graded(form.of_fitted))


def _with_gain(table: Table, explanation: Explanation, gain: Gain) -> Explanation:
    return _with_form(table, explanation, gain.addition.name, gain.addition.form)


def _with_form(table: Table, explanation: Explanation, name: str, form: Form) -> Explanation:
    """Return an explanation with an effect, without the one that it contains and terms that are errors of its form."""
    more = explanation.without(table.shared.candidates[name].contains).with_effect(name, form)
    errors = form_errors(more, table.shared.candidates, table.shared.problem.simulator.symbolic_model)
    terms = tuple(term for term in more.terms if not errors.contain(term.location, term.depends_on))
    return replace(more, terms=terms)


def _with_effect(table: Table, refit: Refitted, more: Explanation, gain: Gain) -> Refitted:
    """Refit an explanation with an addition; coefficients of a grid are fitted: its points are one explanation."""
    return refitted(table.shared, more, _starts(table, refit, more, gain), refit.linear.simulator)


def _starts(table: Table, refit: Refitted, more: Explanation, gain: Gain) -> list[FloatArray]:
    """Return initial values for an explanation with an addition, beside what it has of a refit."""
    estimate = gain.estimate * gain.addition.deviation[: len(gain.estimate)]
    at = replace(refit.linear.solution, parameters=table.without(refit, more))
    return starts(refit.linear.simulator, at, gain.addition.form, estimate)
