"""Explanations and effects with their probabilities."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from .explanation import UNKNOWN, in_order

#: Probability below which an effect is excluded, and above one minus which it is certain. Convention.
UNSURE = 0.1
#: Probability from which an effect is called missing. Convention.
NAMED = 0.5


@dataclass(frozen=True)
class RankedExplanation:
    """An explanation with its probability.

    Attributes
    ----------
    effects : tuple of str
        In alphabetical order.
    unknown : bool
        Whether it has an unknown component.
    probability : float
        0 to 1.
    """

    effects: tuple[str, ...]
    unknown: bool
    probability: float

    @property
    def parts(self) -> tuple[str, ...]:
        """The effects, then `UNKNOWN` if it has an unknown component."""
        return (*self.effects, UNKNOWN) if self.unknown else self.effects


@dataclass(frozen=True)
class OneOf:
    """Effects of which one is missing; the recording does not separate them.

    Attributes
    ----------
    effects : tuple of str
        In falling order of probability.
    probability : float
        Of all explanations that contain exactly one of them, 0 to 1.
    """

    effects: tuple[str, ...]
    probability: float


@dataclass(frozen=True)
class Answer:
    """All compared explanations.

    Attributes
    ----------
    explanations : tuple of RankedExplanation
        In falling order of probability; the sum is 1.
    candidates : tuple of str
        The effects that were compared.
    """

    explanations: tuple[RankedExplanation, ...]
    candidates: tuple[str, ...]

    @property
    def probabilities(self) -> dict[str, float]:
        """The probability of each candidate and of `UNKNOWN`: the sum over the explanations that contain it.

        >>> one = answer_of({("conicity",): 2.0, ("plysteer",): 2.0, (): -50.0}, ["conicity", "plysteer"])
        >>> {name: round(value, 3) for name, value in one.probabilities.items()}
        {'conicity': 0.5, 'plysteer': 0.5, 'UNKNOWN': 0.0}
        """
        sums = dict.fromkeys((*self.candidates, UNKNOWN), 0.0)
        for explanation in self.explanations:
            for name in explanation.parts:
                sums[name] += explanation.probability
        return {name: min(value, 1.0) for name, value in sums.items()}  # sums are rounded

    def one_of(self, effects: Iterable[str]) -> tuple[OneOf, ...]:
        """Return the classes of effects of which one is missing, for each of some effects that is not certain.

        Others are added to an effect while they increase the probability that exactly one is missing. No effect is in
        two classes.

        >>> answer = answer_of({("conicity",): 2.0, ("plysteer",): 2.0, (): -50.0}, ["conicity", "plysteer"])
        >>> answer.one_of(["conicity"])
        (OneOf(effects=('conicity', 'plysteer'), probability=1.0),)
        """
        probabilities, classes = self.probabilities, list[OneOf]()
        unsure = {name for name in self.candidates if UNSURE < probabilities[name] <= 1.0 - UNSURE}
        for effect in effects:
            if effect not in unsure:
                continue
            members, share = [effect], 0.0
            while share <= 1.0 - UNSURE:
                others = sorted(unsure.difference(members))
                other = max(others, key=lambda name: graded(self._exactly_one([*members, name])), default=effect)
                more = self._exactly_one([*members, other])
                if other == effect or more <= self._exactly_one(members):
                    break
                members, share = [*members, other], more
            if share > 1.0 - UNSURE:
                ordered = sorted(members, key=lambda name: (-graded(probabilities[name]), name))
                classes.append(OneOf(tuple(ordered), min(share, 1.0)))
                unsure.difference_update(members)
        return tuple(classes)

    def doubtful(self, effects: Iterable[str]) -> list[str]:
        """Return those of some effects that are not called missing, neither alone nor as one of several.

        >>> answer = answer_of({("a", "b"): 0.0, ("a", "c"): 0.0, ("a", "b", "d"): -2.0}, list("abcd"))
        >>> answer.doubtful("abd")
        ['d']
        """
        names, probabilities = list(effects), self.probabilities
        one_of = {name for alternatives in self.one_of(names) for name in alternatives.effects}
        return [name for name in names if probabilities[name] < NAMED and name not in one_of]

    def with_unproven(self, part: str) -> Answer:
        """Return the answer with odds of at most one to two for a part that the recording does not prove.

        Two thirds of the probability of each explanation with it go to the one without it. Convention: it is rather
        absent than missing, but not excluded.

        >>> answer = answer_of({("conicity",): 0.0}, ["conicity"]).with_unproven("conicity")
        >>> [(explanation.effects, round(explanation.probability, 2)) for explanation in answer.explanations]
        [((), 0.67), (('conicity',), 0.33)]
        """
        shares = dict[tuple[str, ...], float]()
        for explanation in self.explanations:
            parts, probability = explanation.parts, explanation.probability
            less = tuple(name for name in parts if name != part)
            for of, share in ((parts, 1.0 / 3.0), (less, 2.0 / 3.0)):  # the same if it lacks the part
                shares[of] = shares.get(of, 0.0) + share * probability
        return _ranked(shares, self.candidates)

    def with_rival(self, effect: str, rival: str, *, better: bool) -> Answer:
        """Return the answer with odds of two to one between an effect and a rival: for the effect if it is the better.

        Explanations with one of them share their probability with those that have the other in its place. Convention:
        as for a part that is not proven.

        >>> answer = answer_of({("conicity",): 0.0}, ["conicity", "plysteer"])
        >>> shared = answer.with_rival("conicity", "plysteer", better=True)
        >>> [(explanation.effects, round(explanation.probability, 2)) for explanation in shared.explanations]
        [(('conicity',), 0.67), (('plysteer',), 0.33)]
        """
        shares, (first, second) = dict[tuple[str, ...], float](), (effect, rival) if better else (rival, effect)
        for explanation in self.explanations:
            parts, probability = explanation.parts, explanation.probability
            others = {*parts}.difference([effect, rival])
            for name, share in ((first, 2.0 / 3.0), (second, 1.0 / 3.0)):  # the same if it has both or none
                of = in_order({*others, name}) if len(others) == len(parts) - 1 else parts
                shares[of] = shares.get(of, 0.0) + share * probability
        return _ranked(shares, self.candidates)

    def _exactly_one(self, names: Collection[str]) -> float:
        chosen = set(names)
        return sum(ranked.probability for ranked in self.explanations if len(chosen.intersection(ranked.effects)) == 1)

    @property
    def reported(self) -> tuple[RankedExplanation, ...]:
        """The leading explanations that have at least 99 % together."""
        before = np.cumsum([0.0, *(explanation.probability for explanation in self.explanations)])[:-1]
        leading = zip(self.explanations, before, strict=True)
        return tuple(explanation for explanation, sum_before in leading if sum_before < 0.99)


def answer_of(evidences: Mapping[tuple[str, ...], float | FloatArray], candidates: Iterable[str]) -> Answer:
    """Return the answer from the logarithm of the evidence of each explanation, prior odds included, by its parts.

    Arrays have the logarithms on several recordings, over which probabilities are averaged.
    """
    values = np.stack([np.atleast_1d(value) for value in evidences.values()])
    weights = np.exp(values - values.max(axis=0))
    shares = (weights / weights.sum(axis=0)).mean(axis=1).tolist()
    return _ranked(dict(zip(evidences, shares, strict=True)), candidates)


def _ranked(shares: Mapping[tuple[str, ...], float], candidates: Iterable[str]) -> Answer:
    """Return the answer with the probability of each explanation, by its parts."""
    ranked = [
        RankedExplanation(tuple(part for part in parts if part != UNKNOWN), UNKNOWN in parts, share)
        for parts, share in shares.items()
    ]
    return Answer(tuple(sorted(ranked, key=lambda explanation: -graded(explanation.probability))), tuple(candidates))


def percent(probability: float) -> str:
    """Return a probability in percent as a range: the digits would mean nothing.

    In the suites of docs/discovery.md, 90 to 100 % of the effects above 90 % were missing (72 % where the library
    lacks the true one), and 22 of 31 between 50 and 90 %.

    >>> [percent(probability) for probability in (0.9999, 0.625, 0.5, 0.3, 0.01)]
    ['over 90 %', '50 to 90 %', '50 to 90 %', '10 to 50 %', 'under 10 %']
    """
    if not UNSURE <= probability <= 1.0 - UNSURE:
        return "over 90 %" if probability > NAMED else "under 10 %"
    return "50 to 90 %" if probability >= NAMED else "10 to 50 %"
