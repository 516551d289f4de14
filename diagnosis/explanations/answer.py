"""Explanations and effects with their probabilities."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from .explanation import FORM, UNKNOWN


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
        In falling order of probability. The sum is at most 1: the rest is that of explanations that were not compared.
    log_odds : mapping of str to float
        Of each candidate and of `UNKNOWN`: logarithm of the evidence of all explanations that contain it, relative to
        that of all others, prior odds included.
    """

    explanations: tuple[RankedExplanation, ...]
    log_odds: Mapping[str, float]

    @property
    def probabilities(self) -> dict[str, float]:
        """The probability of each candidate and of `UNKNOWN`.

        >>> one = answer_of({("conicity",): 2.0, ("plysteer",): 2.0, (): -50.0}, ["conicity", "plysteer"])
        >>> {name: round(value, 3) for name, value in one.probabilities.items()}
        {'conicity': 0.5, 'plysteer': 0.5, 'UNKNOWN': 0.0}
        """
        return {name: calibrated(value) for name, value in self.log_odds.items()}

    @property
    def reported(self) -> tuple[RankedExplanation, ...]:
        """The first explanation, and others of at least 1 %."""
        first, *others = self.explanations
        return (first, *(explanation for explanation in others if explanation.probability >= 0.01))


def answer_of(evidences: Mapping[tuple[str, ...], float], candidates: Iterable[str]) -> Answer:
    """Return the answer from the logarithm of the evidence of each explanation, prior odds included, by its parts.

    Explanations that differ in errors of the functional form only are one. An explanation with effects is as uncertain
    as these are.
    """
    compared = [(set(parts) - {FORM}, value) for parts, value in evidences.items()]
    log_odds = {name: _log_odds(compared, lambda parts, name=name: name in parts) for name in (*candidates, UNKNOWN)}
    sure = {name: calibrated(value) / expit(value) for name, value in log_odds.items() if value > 0.0}
    ranked = []
    for parts in {frozenset(parts) for parts, _ in compared}:
        share = float(expit(_log_odds(compared, lambda others, parts=parts: others == parts)))
        probability = share * float(np.prod([sure.get(name, 1.0) for name in parts]))
        ranked.append(RankedExplanation(tuple(sorted(parts - {UNKNOWN})), UNKNOWN in parts, probability))
    return Answer(tuple(sorted(ranked, key=lambda explanation: (-explanation.probability, explanation.parts))), log_odds)


def _log_odds(compared: Sequence[tuple[set[str], float]], contained: Callable[[set[str]], bool]) -> float:
    """Return the logarithm of the evidence of some explanations relative to that of all others."""
    inside, outside = (
        np.logaddexp.reduce([value for parts, value in compared if contained(parts) is wanted], initial=-np.inf)
        for wanted in (True, False)
    )
    return float(inside - outside)


def calibrated(log_odds: float) -> float:
    """Return the probability of an effect.

    >>> calibrated(0.0), calibrated(-np.inf), calibrated(np.inf)
    (0.5, 0.0, 1.0)
    """
    return float(expit(log_odds))
