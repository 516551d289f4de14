"""The most probable explanation of a recording: explanations are refitted, extended and reduced, best first.

All compared explanations have one noise and one discrepancy, those of the leading explanation. When another one leads,
both are estimated again and the comparison is repeated.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from ...numerics.ties import graded
from ..least_squares import LeastSquares, Solution
from ..probing.candidates import Candidate
from ..probing.effect_probing import starts
from ..thresholds import CONFOUNDED, EFFECT_ODDS, REFIT_MARGIN, RIVALS
from .answer import Answer, answer_of, percent
from .budget import Budget, Ended
from .evidence import Projected, caution, inflation
from .explanation import UNKNOWN, Explanation
from .formula import best_formula
from .gains import Gain, gains, projected, rivals_of
from .linearization import Addition, Linearization
from .refit import Refitted, Shared, refitted, shared_problem, some_rows, with_terms
from .terms import form_errors

FloatArray = npt.NDArray[np.float64]

#: Number of estimates of the noise, and of extended explanations for each; growth of the variance of the noise after
#: which it is estimated again. Conventions: computing time.
ESTIMATES, COMPARED, GROWTH = 5, 12, 1.5
#: Decrease of the score without a part, from which the part is not tried again while the leading explanation changes:
#: ten margins. Convention: computing time.
CERTAIN = -10.0 * REFIT_MARGIN


@dataclass(frozen=True, eq=False)
class ComparedExplanations:
    """The answer, the most probable explanation with its refit, and what all explanations have in common.

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
    tables, stopped = list[_Table](), ""
    try:
        _compare(linear, few, baseline, budget, tables)
    except Ended:
        stopped = budget.ended
    # A table that was stopped at its beginning has compared less than the one before.
    table = max(tables, key=lambda table: len(table.scores)) if stopped else tables[-1]
    return ComparedExplanations(answer_of(table.divided_scores(), candidates), table.leader, table.shared, stopped)


def _compare(
    linear: Linearization, few: LeastSquares, baseline: Solution, budget: Budget, tables: list[_Table]
) -> None:
    """Compare explanations under the noise of each leading one in turn; the last tables are left in the list."""
    seen, explained, losses = set[tuple[str, ...]](), 0.0, dict[str, float]()
    for remaining in reversed(range(ESTIMATES)):
        table = _table(linear, baseline, explained, budget, losses)
        tables[:] = [*tables[-1:], table]
        table.climb(linear)
        seen.add(linear.explanation.parts)
        # Two explanations may lead in turn, each under the noise of the other one: then the smaller one is the leader.
        if table.leads_again(seen, linear.explanation) or not remaining:
            table.compare()
            table.propose()
            if table.leads_again(seen, linear.explanation):
                break
        explained, linear = table.explained, _with_own_noise(table.leader, few)


def _table(
    linear: Linearization, baseline: Solution, explained: float, budget: Budget, losses: dict[str, float]
) -> _Table:
    """Return an empty table under the noise of a linearization.

    `explained`: logarithm of the likelihood by which the explanation of the linearization is better than none.
    `losses`: of the table before.
    """
    additions = dict[str, list[Addition]]()
    for name in linear.lacking:
        budget.check()
        additions[name] = linear.of_effect(name)
    every = [addition for forms in additions.values() for addition in forms]
    shared = shared_problem(linear, baseline, every, explained, budget)
    weighted = {name: [addition.weighted(shared.problem) for addition in forms] for name, forms in additions.items()}
    return _Table(shared, baseline.parameters, weighted, losses)


def _with_own_noise(leader: Refitted, problem: LeastSquares) -> Linearization:
    """Return the linearization of a refit with rows of independent noise and without a discrepancy.

    Its forces drive the states from then on.
    """
    simulator = leader.linear.simulator.driven_at(leader.linear.solution.parameters)
    bare = with_terms(problem, leader.explanation.terms).over(simulator)
    at = bare.at(leader.linear.solution.parameters, leader.linear.solution.free)
    return replace(leader.linear, problem=bare, solution=at)


@dataclass(eq=False)
class _Table:
    """The explanations that were compared under one noise, by their parts.

    - `absent`, shape (n_parameters,): of the baseline model.
    - `additions`: by name, to the first explanation that lacks the part. Their columns serve for all explanations.
    - `losses`: by how much the score was smaller without a part when this was tried last.
    - `refits`: those that were refitted.
    - `proposed`: those for which a formula was searched.
    - `expanded`: those that were extended and reduced.
    - `scores`: logarithm of the evidence with the prior odds; of others that of the linear problem next to them.
    - `extensions`: of these others, the refit with an effect less.
    """

    shared: Shared
    absent: FloatArray
    additions: dict[str, list[Addition]]
    losses: dict[str, float]
    refits: dict[tuple[str, ...], Refitted] = field(default_factory=dict)
    scores: dict[tuple[str, ...], float] = field(default_factory=dict)
    proposed: set[tuple[str, ...]] = field(default_factory=set)
    expanded: set[tuple[str, ...]] = field(default_factory=set)
    extensions: dict[tuple[str, ...], tuple[str, ...]] = field(default_factory=dict)

    def _possible(self, linear: Linearization) -> list[Addition]:
        """Return the effects that an explanation lacks."""
        for name in linear.lacking:
            if name not in self.additions:
                self.shared.budget.check()
                self.additions[name] = [addition.weighted(self.shared.problem) for addition in linear.of_effect(name)]
        return [addition for name in linear.lacking for addition in self.additions[name]]

    @property
    def explained(self) -> float:
        """Logarithm of the likelihood, not raised to a power, by which the leading explanation is better than none."""
        return (self.leader.evidence - self.refits[()].evidence) * inflation(self.shared.explained)

    def divided_scores(self) -> dict[tuple[str, ...], float]:
        """Return the scores that make the probabilities: without what inexact forms of effects may explain."""
        factor = caution(self.explained)
        priors = {parts: self.refits[base].explanation.log_prior for parts, base in self.extensions.items()}
        priors = {parts: prior + float(np.log(EFFECT_ODDS)) for parts, prior in priors.items()}
        priors |= {parts: refit.explanation.log_prior for parts, refit in self.refits.items()}
        return {parts: priors[parts] + (score - priors[parts]) / factor for parts, score in self.scores.items()}

    @property
    def leader(self) -> Refitted:
        """The refitted explanation with the largest score."""
        return self.refits[max(self.refits, key=lambda parts: graded(self.scores[parts]))]

    @property
    def _roots(self) -> tuple[Refitted, ...]:
        """The leader, and the refitted explanation with the largest probability if it is another one."""
        divided = self.divided_scores()
        probable = self.refits[max(self.refits, key=lambda parts: graded(divided[parts]))]
        return tuple(dict.fromkeys([self.leader, probable]))

    def _root_above(self, parts: Collection[str]) -> Refitted | None:
        """Return the first root that has the parts and one more."""
        above = (root for root in self._roots if set(parts) < set(root.explanation.parts))
        return next((root for root in above if len(root.explanation.parts) == len(parts) + 1), None)

    @property
    def _goes_on(self) -> bool:
        return len(self.expanded) < COMPARED

    def _report(self, sentence: str) -> None:
        """Report what is done, and what leads; from the second pass on also its probability among all compared ones.

        While effects are being added, those that remain are not yet among them.
        """
        divided, parts = self.divided_scores(), self.leader.explanation.parts
        share = float(np.exp(divided[parts] - np.logaddexp.reduce(list(divided.values()))))
        leading = f"{', '.join(parts) or 'the baseline model'} leads"
        compared = f" {len(divided)} explanations, probability {percent(share)}" if self.expanded else ""
        self.shared.budget.report(f"{sentence}; {leading}{compared}")

    def leads_again(self, seen: Collection[tuple[str, ...]], explanation: Explanation) -> bool:
        """Return whether the leader is one of those seen, and not larger than the explanation of the noise."""
        parts = self.leader.explanation.parts
        return parts in seen and len(parts) <= len(explanation.parts)

    def climb(self, linear: Linearization) -> None:
        """Extend the leading explanation while an extension leads; reduce it at the end.

        If the gain is large, estimate the noise again first.
        """
        self._add(refitted(self.shared, Explanation(), [self.absent], linear.simulator))
        if linear.explanation.parts:
            self._add(refitted(self.shared, linear.explanation, [linear.solution.parameters], linear.simulator))
        best, limit = None, GROWTH * inflation(self.shared.explained)
        while best is not self.leader and self._goes_on and inflation(self.explained) < limit:
            best = self.leader
            self._extend(best)
            if best is self.leader:
                self._reduce(best, [part for part in best.explanation.parts if self.losses.get(part, 0.0) < CERTAIN])
                self.expanded.add(best.explanation.parts)

    def compare(self) -> None:
        """Extend the best explanations, and reduce those that nearly lead, until none of them is left."""
        self._reduce(self.leader, self.leader.explanation.parts)
        while self._goes_on:
            remaining = [parts for parts in self._near() if parts not in self.expanded]
            if not remaining:
                return
            refit = self.refits[remaining[0]]
            self._extend(refit)
            if refit in self._roots or self.scores[remaining[0]] > max(self.scores.values()) + REFIT_MARGIN:
                self._reduce(refit, refit.explanation.parts)
            self.expanded.add(remaining[0])

    def propose(self) -> None:
        """Compare formulas for what the leading explanation, those with one part less, and none of them explain.

        Those with less lack one of the `RIVALS` parts that are missed least: a formula may be in its place. The
        smallest explanation is the first one. Where another one leads then, the noise is to be estimated again.
        """
        leader = self.leader
        if UNKNOWN in leader.explanation.parts:
            return
        self._reduce(leader, leader.explanation.parts)
        less = [leader.explanation.without(part).parts for part in leader.explanation.effects]
        less = sorted(less, key=lambda parts: -graded(self.scores.get(parts, -np.inf)))[:RIVALS]
        for parts in dict.fromkeys([(), *less, leader.explanation.parts]):
            if self.leader is not leader or parts not in self.refits:
                break
            self._propose(self.refits[parts])
        self.compare()

    def _propose(self, refit: Refitted) -> None:
        """Compare an explanation with the formula that explains most of what it does not.

        An error of form is no unknown effect, nor is what an effect of the library reproduces.
        """
        parts = (*refit.explanation.parts, UNKNOWN)
        if parts in self.proposed:
            return
        self.proposed.add(parts)
        self._report(f"searching for a formula in addition to {', '.join(parts[:-1]) or 'the baseline model'}")
        formula, errors = best_formula(self.shared, refit), refit.linear.form_errors
        terms = formula.explanation.terms
        if all(errors.contain(term.location, term.depends_on) for term in terms):
            return
        columns = np.stack([term.column for term in terms], axis=-1)
        if not self._reproduced(refit.linear, columns @ np.array(formula.term_sizes)):
            self._add(formula)

    def _reproduced(self, linear: Linearization, change: FloatArray) -> bool:
        """Return whether an effect of the library reproduces a change of the forces, shape (n_channels, n)."""
        effects = self._possible(linear)
        alone = Addition(UNKNOWN, change[:, :, None], np.ones(1))
        sizes = [1, *(len(addition.deviation) for addition in effects)]
        whole = Projected.of(linear.equations([alone, *effects]), sizes)
        return any(whole.correlations(group)[0] > CONFOUNDED for group in whole.groups[1:])

    def _near(self) -> list[tuple[str, ...]]:
        """Return the roots, those with one part less, and those with nearly the score of the leader."""
        roots = [root.explanation.parts for root in self._roots]
        less = [other for other in self.refits if self._root_above(other) is not None]
        near = [other for other in self.refits if self.scores[other] > self.scores[roots[0]] + REFIT_MARGIN]
        return list(dict.fromkeys([*roots, *less, *sorted(near, key=lambda other: -graded(self.scores[other]))]))

    def _add(self, refit: Refitted) -> None:
        """Keep a refit if it is the best one of its explanation; of those that do not lead, without computed forces."""
        parts = refit.explanation.parts
        before = self.leader if self.refits else refit
        if parts not in self.refits or refit.score > self.scores[parts]:
            self.refits[parts], self.scores[parts] = refit, refit.score
        for other in (before, refit):
            if other.linear.simulator is not self.leader.linear.simulator:
                other.linear.simulator.forget()
        self.shared.budget.answered = True

    def _reduce(self, refit: Refitted, parts: Collection[str]) -> None:
        """Refit an explanation without each of some parts."""
        simulator, explanation = refit.linear.simulator, refit.explanation
        for part in parts:
            less = explanation.without(part)
            if less.parts not in self.refits:
                self._report(f"comparing {part} with other explanations")
                self._add(refitted(self.shared, less, [self._start_without(refit, less)], simulator))
            self.losses[part] = refit.score - self.refits[less.parts].score

    def _start_without(self, refit: Refitted, less: Explanation) -> FloatArray:
        """Return the coefficients of a refit, those of the effects that a smaller explanation lacks absent."""
        start, index = refit.linear.solution.parameters.copy(), refit.linear.simulator.index
        forms = [form for effect, form in refit.explanation.forms if effect not in less.effects]
        freed = [index[name] for form in forms for name in form.free]
        start[freed] = self.absent[freed]
        return start

    def _extend(self, refit: Refitted) -> None:
        """Compare an explanation with those that have one effect more; the best ones are refitted.

        Others are from `REFIT_MARGIN` on. If a leading explanation has one part more, effects that are confounded
        with this part are refitted in its place: most act through time and are not linear in their coefficients.
        """
        self._report(f"adding an effect to {', '.join(refit.explanation.parts) or 'the baseline model'}")
        leading = refit.explanation.parts
        base, possible = self.scores[leading], self._possible(refit.linear)
        if not possible:
            return
        columns = projected(refit.linear, possible)
        scored = gains(columns, possible)
        totals = {name: float(np.logaddexp.reduce([form.gain for form in forms])) for name, forms in scored.items()}
        above = self._root_above(leading)
        replaced: Collection[str] = set(above.explanation.parts).difference(leading) if above else ()
        rivals = rivals_of(replaced, columns, possible)
        for name in sorted(totals, key=lambda part: -graded(totals[part])):
            best = max(scored[name], key=lambda form: graded(form.gain))
            parts, score = self._extended(refit, best).parts, base + totals[name]
            if parts in self.refits:
                continue
            if score > self.scores.get(parts, -np.inf):
                self.scores[parts], self.extensions[parts] = score, leading
            if name in rivals or score > max(self.scores.values()) + REFIT_MARGIN:
                self._add(self._with_effect(refit, best, above if name in rivals else None))

    def _extended(self, refit: Refitted, gain: Gain) -> Explanation:
        """Return an explanation with an addition, without terms that are errors of its form."""
        more = refit.explanation.with_effect(gain.addition.name, gain.addition.form)
        errors = form_errors(more, self.shared.candidates, self.shared.problem.simulator.symbolic_model)
        terms = tuple(term for term in more.terms if not errors.contain(term.location, term.depends_on))
        return replace(more, terms=terms)

    def _with_effect(self, refit: Refitted, best: Gain, above: Refitted | None) -> Refitted:
        """Refit an addition of an effect; coefficients of a grid are fitted, so that its points are one explanation.

        `above`: an explanation in which the effect takes the place of another one; the fit also begins there.
        """
        simulator, solution = refit.linear.simulator, refit.linear.solution
        solutions = [solution]
        if above is not None:
            solutions.append(replace(solution, parameters=self._start_without(above, refit.explanation)))
        form, estimate = best.addition.form, best.estimate * best.addition.deviation
        begins = [start for at in solutions for start in starts(simulator, at, form, estimate)]
        return refitted(self.shared, self._extended(refit, best), begins, simulator)
