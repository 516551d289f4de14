"""The diagnosis of this project: of tires by its public function; of other systems only the score of explanations.

The diagnosis refits Magic Formula tires; it cannot take another system. What is not of tires is the
evidence of explanations (`tirefmu.diagnosis.explanations.evidence`) and the probabilities that follow from it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np
import pandas as pd

from tirefmu.diagnosis import diagnose
from tirefmu.diagnosis.explanations.answer import answer_of
from tirefmu.diagnosis.explanations.evidence import NormalEquations, inflation, likelihood_power
from tirefmu.diagnosis.thresholds import EFFECT_ODDS, FORM_ERROR, UNKNOWN_SHARE

from ..answers import UNKNOWN, Answer, Case, FloatArray
from .problem import Channel, channels_of, inputs_of, scaled

#: Names of effects; UNKNOWN with its variables.
Parts = tuple[tuple[str, tuple[str, ...]], ...]
#: Effects of an explanation; prior deviation of an effect's columns as a share of the channel; of the baseline's.
MAX_EFFECTS, EFFECT_SHARE, FLAT = 2, 1.0, 1e3


def answer(case: Case) -> Answer:
    """Return the diagnosis of a recording."""
    if case.about["system"] == "tire":
        return _of_tire(case)
    comparison = _Comparison.of(case)
    terms = [(UNKNOWN, pair) for pair in comparison.pairs]
    named = [((name, ()),) for name in case.about["candidates"]]
    parts = [(), *named, *((*a, *b) for a, b in combinations(named, MAX_EFFECTS))]
    explanations = [*parts, *((*part, term) for part in parts for term in terms)]
    evidence, _ = _best(comparison, explanations)
    explained = max(evidence.values()) - evidence[()]
    evidence, best = _best(replace(comparison, power=comparison.power / inflation(explained)), explanations)
    ranked = answer_of(evidence, list(case.about["candidates"]))
    first = best[tuple(sorted(ranked.explanations[0].parts))]
    found = tuple(name for name, value in ranked.probabilities.items() if value >= 0.5)
    variables = next((pair for name, pair in first if name == UNKNOWN), ()) if UNKNOWN in found else ()
    return Answer(found, ranked.probabilities, variables, comparison.forces(first))


def _best(
    comparison: _Comparison, explanations: Sequence[Parts]
) -> tuple[dict[tuple[str, ...], float], dict[tuple[str, ...], Parts]]:
    """Return the evidence of explanations by their names, and the best one of each: formulas are UNKNOWN."""
    evidence: dict[tuple[str, ...], float] = {}
    best: dict[tuple[str, ...], Parts] = {}
    for parts in explanations:
        names, value = tuple(sorted(name for name, _ in parts)), comparison.evidence(parts)
        if value > evidence.get(names, -np.inf):
            evidence[names], best[names] = value, parts
    return evidence, best


def _of_tire(case: Case) -> Answer:
    result = diagnose(case.recording, model="mf61", effects=case.about["base"], nominal=case.about["nominal"])
    content = result.to_json()
    found = tuple(one["effect"] for one in content["found"])
    variables = {name for one in content["unknown"] for name in one["depends_on"]} if UNKNOWN in found else set()
    forces = result.tire.evaluate(case.other, signs="iso")[case.channels]
    return Answer(found, content["probabilities"], tuple(sorted(variables)), forces)


@dataclass(frozen=True, eq=False)
class _Comparison:
    """Explanations of a system by their evidence: baseline, responses and their errors of form, in each channel.

    - `smooth`, shape (m, k): functions of the inputs, for errors of form.
    - `n`: number of rows of the recording.
    - `power`: of the likelihood.
    """

    channels: Mapping[str, Channel]
    smooth: FloatArray
    n: int
    power: float

    @classmethod
    def of(cls, case: Case) -> _Comparison:
        """Return the comparison of a recording."""
        n = len(case.recording)
        values = list(scaled(inputs_of(case), n).values())
        smooth = np.stack([*values, *(one**2 - 1.0 for one in values)], axis=1)
        return cls(channels_of(case), smooth, n, likelihood_power(n))

    @property
    def pairs(self) -> list[tuple[str, ...]]:
        """The pairs of variables of formulas."""
        return sorted({pair for one in self.channels.values() for pair in one.variables if pair})

    def evidence(self, parts: Parts) -> float:
        """Return the logarithm of the evidence of an explanation with its prior odds."""
        odds = [np.log(EFFECT_ODDS / len(self.pairs) if pair else EFFECT_ODDS) for _, pair in parts]
        return sum(self._solved(one, parts)[0] for one in self.channels.values()) + float(np.sum(odds))

    def forces(self, parts: Parts) -> pd.DataFrame:
        """Return the channels on the other maneuvers."""
        return pd.DataFrame({name: one.offset + self._solved(one, parts)[1] for name, one in self.channels.items()})

    def _solved(self, one: Channel, parts: Parts) -> tuple[float, FloatArray]:
        """Return evidence and prediction of a channel; errors of form are in proportion to the estimated responses."""
        labels = list(zip(one.names, one.variables, strict=True))
        of_part = [[i for i, label in enumerate(labels) if label == part] for part in parts]
        shares = [UNKNOWN_SHARE if pair else EFFECT_SHARE for part, (_, pair) in zip(of_part, parts, strict=True)
                  for _ in part]  # fmt: skip
        size = np.linalg.norm(one.base[: self.n], axis=0) / np.sqrt(self.n)
        columns = np.concatenate([one.base / size, *(one.columns[:, part] for part in of_part)], axis=1) / one.noise
        deviation = float(np.std(one.y)) * np.array([*[FLAT] * len(size), *shares])  # of columns of size 1 / noise
        estimate, evidence = self._estimate(columns, one.y / one.noise, deviation)
        ends = np.cumsum([len(size), *map(len, of_part)])
        responses = [columns[:, a:b] @ estimate[a:b] for a, b in pairwise(ends) if b > a]
        if responses:
            forms = np.concatenate([response[:, None] * self.smooth for response in responses], axis=1)
            columns = np.concatenate([columns, forms], axis=1)
            deviation = np.concatenate([deviation, np.full(forms.shape[1], FORM_ERROR)])
            estimate, evidence = self._estimate(columns, one.y / one.noise, deviation)
        return evidence, one.noise * (columns[self.n :] @ estimate)

    def _estimate(self, columns: FloatArray, y: FloatArray, deviation: FloatArray) -> tuple[FloatArray, float]:
        x, none = columns[: self.n], np.zeros(len(deviation))
        products = self.power * x.T @ x, self.power * x.T @ y, self.power * float(y @ y)
        return NormalEquations(*products, deviation**-2.0, none).solved()
