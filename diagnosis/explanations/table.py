"""The explanations that were compared under one noise, as a value, and their probabilities.

The evidence of an explanation decides between two by chance if both predict a recording equally well. As in a bagged
posterior (Huggins and Miller, Bayesian Analysis 18, 2023), probabilities are therefore averaged over recordings without
a part of the blocks of time. The columns of the refits serve for all of them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ..thresholds import FOLDS, REFIT_MARGIN
from .answer import percent
from .evidence import caution, folds_of, inflation
from .explanation import Explanation
from .linearization import Addition, Linearization
from .refit import Refitted, Shared

Parts = tuple[str, ...]

#: Score, relative to the largest one, below which an explanation is not tried again under another noise, and not at all
#: if the linear problem states so: three margins. Convention: computing time.
FAR = 3.0 * REFIT_MARGIN


@dataclass(frozen=True, eq=False)
class Table:
    """The explanations that were compared under one noise, by their parts.

    - `absent`, shape (n_parameters,): of the baseline model.
    - `additions`: by name, to the first explanation that lacks the part. Their columns serve for all explanations.
    - `refits`: those that were refitted; there is at least the one without parts.
    - `far`: those that were refitted under another noise and were far behind.
    - `linear`: logarithms of evidence and prior odds of others, from the linear problem next to them.
    """

    shared: Shared
    absent: FloatArray
    additions: Mapping[str, list[Addition]]
    refits: Mapping[Parts, Refitted] = field(default_factory=dict)
    linear: Mapping[Parts, tuple[float, float]] = field(default_factory=dict)
    far: frozenset[Parts] = frozenset()

    def with_refit(self, refit: Refitted) -> Table:
        """Return the table with a refit if it is the best one of its explanation.

        Of those that do not lead, computed forces are freed.
        """
        parts, before = refit.explanation.parts, self.leader if self.refits else refit
        before_it = self.refits.get(parts)
        table = (
            self
            if before_it and before_it.score >= refit.score
            else replace(self, refits={**self.refits, parts: refit})
        )
        for other in (before, refit):
            if other.linear.simulator is not table.leader.linear.simulator:
                other.linear.simulator.forget()
        self.shared.budget.answered = True
        return table

    def with_linear(self, parts: Parts, evidence: float, prior: float) -> Table:
        """Return the table with evidence and prior odds from the linear problem at an explanation next to this one."""
        if evidence + prior <= sum(self.linear.get(parts, (-np.inf, 0.0))):
            return self
        return replace(self, linear={**self.linear, parts: (evidence, prior)})

    def is_far(self, parts: Parts) -> bool:
        """Return whether both the score of an explanation and the one that makes its probability are far behind."""
        scores, divided = self.scores, self.divided()
        return all(of[parts] < max(of.values()) + FAR for of in (scores, divided))

    def possible(self, linear: Linearization) -> tuple[Table, list[Addition]]:
        """Return what an explanation lacks, and the table with its columns."""
        missing = [name for name in linear.lacking if name not in self.additions]
        added = {}
        for name in missing:
            self.shared.budget.check()
            added[name] = [addition.weighted(self.shared.problem) for addition in linear.of_effect(name)]
        table = replace(self, additions={**self.additions, **added}) if missing else self
        return table, [addition for name in linear.lacking for addition in table.additions[name]]

    @property
    def scores(self) -> dict[Parts, float]:
        """Logarithm of the evidence with the prior odds of each explanation."""
        of_linear = {parts: evidence + prior for parts, (evidence, prior) in self.linear.items()}
        return of_linear | {parts: refit.score for parts, refit in self.refits.items()}

    @property
    def leader(self) -> Refitted:
        """The refitted explanation with the largest score."""
        return max(self.refits.values(), key=lambda refit: graded(refit.score))

    @property
    def explained(self) -> float:
        """Logarithm of the likelihood, not raised to a power, by which the leader is better than its static effects.

        Errors of the form of these are smooth functions of their inputs. Every explanation contains them, whether the
        effects were found or the baseline model has them.
        """
        static = set(self.leader.linear.responses.static.parts)
        others = [refit for parts, refit in self.refits.items() if static.issuperset(parts)]
        return min(map(self._better_than, others))

    @property
    def caution(self) -> float:
        """The factor by which probabilities divide evidences, by all that the leader explains."""
        return caution(self._better_than(self.refits[()]), self.shared.explained)

    def _better_than(self, other: Refitted) -> float:
        return (self.leader.evidence - other.evidence) * inflation(self.shared.explained)

    def divided(self) -> dict[Parts, float]:
        """Return the scores that make the probabilities: without what inexact forms of effects may explain."""
        refitted = {parts: (refit.evidence, refit.explanation.log_prior) for parts, refit in self.refits.items()}
        factor = self.caution
        return {parts: prior + evidence / factor for parts, (evidence, prior) in {**self.linear, **refitted}.items()}

    def probable(self) -> list[Refitted]:
        """Return the leader, and the refits with nearly the probability of the most probable one."""
        divided, leader = self.divided(), self.leader
        best = max(divided[parts] for parts in self.refits)
        near = [refit for parts, refit in self.refits.items() if divided[parts] > best + REFIT_MARGIN]
        return [leader, *(refit for refit in near if refit is not leader)]

    def probable_with(self, formula: Refitted, parts: Parts) -> bool:
        """Return whether an explanation is more probable with a formula: a better tire alone is no unknown effect."""
        gain, prior = formula.evidence - self.refits[parts].evidence, self.refits[parts].explanation.log_prior
        return gain / self.caution + formula.explanation.log_prior - prior > 0.0

    def condensed(self) -> Table:
        """Return the table without what only more comparisons would need, and refits that have little probability."""
        divided, static = self.divided(), set(self.leader.linear.responses.static.parts)
        best, leader = max(divided.values()) + 2.0 * REFIT_MARGIN, self.leader.explanation.parts
        kept = {
            parts: refit
            for parts, refit in self.refits.items()
            if divided[parts] > best or parts == leader or static.issuperset(parts)
        }
        others = {parts: (refit.evidence, refit.explanation.log_prior) for parts, refit in self.refits.items()}
        return replace(self, additions={}, refits=kept, linear={**self.linear, **others})

    @property
    def roots(self) -> tuple[Parts, ...]:
        """The leader and the most probable refit, which may be smaller."""
        divided = self.divided()
        return self.leader.explanation.parts, max(self.refits, key=lambda parts: graded(divided[parts]))

    def near(self) -> list[Parts]:
        """Return the roots, and the refits with nearly the probability of the second one or the score of the first.

        The most probable one is the first: it has fewer parts, and shows which of the larger ones are far.
        """
        divided, (leader, probable) = self.divided(), self.roots
        order = sorted(self.refits, key=lambda parts: -graded(divided[parts]))
        behind = {
            parts: max(divided[parts] - divided[probable], refit.score - self.refits[leader].score)
            for parts, refit in self.refits.items()
        }
        return list(dict.fromkeys([probable, leader, *(parts for parts in order if behind[parts] > REFIT_MARGIN)]))

    @property
    def doubts(self) -> list[Parts]:
        """For each part that all near explanations have, the best refit without it, unless that is far behind."""
        certain = set.intersection(*map(set, self.near()))
        order = sorted(self.refits, key=lambda parts: -graded(self.refits[parts].score))
        lacking = [next(parts for parts in order if part not in parts) for part in sorted(certain)]
        return [parts for parts in dict.fromkeys(lacking) if not self.is_far(parts)]

    def behind(self, score: float) -> frozenset[Parts]:
        """Return the refits whose divided scores are less than the largest one by more than this (negative) score."""
        divided = self.divided()
        best = max(divided.values())
        return frozenset(parts for parts in self.refits if divided[parts] < best + score)

    def compared(self, explanation: Explanation) -> bool:
        """Return whether an explanation was refitted, or under another noise and was far behind."""
        return explanation.parts in self.refits or explanation.parts in self.far

    def leads_again(self, seen: Collection[Parts], explanation: Explanation) -> bool:
        """Return whether the leader is one of those seen, and not larger than the explanation of the noise."""
        parts = self.leader.explanation.parts
        return parts in seen and len(parts) <= len(explanation.parts)

    def report(self, sentence: str) -> None:
        """Report what is done, what leads, and its probability among all that were compared."""
        divided, parts = self.divided(), self.leader.explanation.parts
        share = float(np.exp(divided[parts] - np.logaddexp.reduce(list(divided.values()))))
        compared = f" {len(divided)} explanations, probability {percent(share)}" if len(divided) > 1 else ""
        self.shared.budget.tell(f"{sentence}; {', '.join(parts) or 'the baseline model'} leads{compared}")

    def without(self, refit: Refitted, less: Explanation) -> FloatArray:
        """Return the coefficients of a refit, those of the effects that another explanation lacks absent."""
        start, index = refit.linear.solution.parameters.copy(), refit.linear.simulator.index
        kept = {name for _, form in less.forms for name in form.free}
        freed = [index[name] for _, form in refit.explanation.forms for name in form.free if name not in kept]
        start[freed] = self.absent[freed]
        return start


def fold_evidences(table: Table) -> dict[Parts, FloatArray]:
    """Return the scores that make the probabilities, without each fold of the blocks, shape (`FOLDS`,).

    Explanations with little probability differ from the leading one as on all rows.
    """
    divided = table.divided()
    best = max(divided.values())
    leading = table.leader.explanation.parts
    chosen = [parts for parts in table.refits if divided[parts] > best + 2.0 * REFIT_MARGIN or parts == leading]
    factor, change = table.caution, dict[Parts, FloatArray]()
    for parts in chosen:
        refit = table.refits[parts]
        change[parts] = (without_folds(refit.linear) - refit.evidence) / factor
        refit.linear.simulator.forget()
    return {parts: divided[parts] + change.get(parts, change[leading]) for parts in divided}


def without_folds(linear: Linearization) -> FloatArray:
    """Return the logarithm of the evidence of an explanation without each fold of the blocks, shape (`FOLDS`,).

    The rows that remain count as often as makes them as many as all.
    """
    equations, fold, problem = linear.equations(), folds_of(linear.simulator.signals), linear.problem
    squares = float(np.sum(problem.weighted(problem.misfit(linear.solution.parameters)) ** 2))
    times, evidences = FOLDS / (FOLDS - 1.0), []
    for k in range(FOLDS):
        part = linear.products(np.flatnonzero(fold == k))
        fewer = replace(
            equations,
            matrix=times * (equations.matrix - part[:-1, :-1]),
            target=times * (equations.target - part[:-1, -1]),
            power=equations.power - squares + times * (squares - float(part[-1, -1])),
        )
        evidences.append(fewer.solved()[1])
    return np.array(evidences)
