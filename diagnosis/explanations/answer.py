"""Explanations and effects with their probabilities."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ...numerics.ties import graded
from .explanation import UNKNOWN


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

    @property
    def reported(self) -> tuple[RankedExplanation, ...]:
        """The leading explanations that have at least 99 % together."""
        before = np.cumsum([0.0, *(explanation.probability for explanation in self.explanations)])[:-1]
        leading = zip(self.explanations, before, strict=True)
        return tuple(explanation for explanation, sum_before in leading if sum_before < 0.99)


def answer_of(evidences: Mapping[tuple[str, ...], float], candidates: Iterable[str]) -> Answer:
    """Return the answer from the logarithm of the evidence of each explanation, prior odds included, by its parts."""
    values = np.array(list(evidences.values()))
    weights, ranked = np.exp(values - values.max()), list[RankedExplanation]()
    for parts, weight in zip(evidences, weights / weights.sum(), strict=True):
        effects = tuple(part for part in parts if part != UNKNOWN)
        ranked.append(RankedExplanation(effects, UNKNOWN in parts, float(weight)))
    return Answer(tuple(sorted(ranked, key=lambda explanation: -graded(explanation.probability))), tuple(candidates))


def percent(probability: float) -> str:
    """Return a probability in percent; beyond 10 and 90 % only that it is so.

    Of the effects with more than 90 %, 86 to 92 % were missing in the suites of docs/discovery.md: the digits of a
    larger number would mean nothing.

    >>> percent(0.9999), percent(0.625)
    ('over 90 %', '62 %')
    """
    if not 0.1 <= probability <= 0.9:
        return "over 90 %" if probability > 0.5 else "under 10 %"
    return f"{100.0 * probability:.0f} %"
