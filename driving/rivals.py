"""Explanations of a drive compared: factors of the tires that changed, entries of the car that its file has wrong.

An explanation states which factors changed and which entry of the car, if any, is wrong. Its prior gives a changed
factor the spread of factors and a wrong entry a multiple of its uncertainty; all others keep theirs. The likelihood of
all is one, the Gaussian of the estimate; integrated over the prior it is the evidence (Laplace; MacKay, Information
Theory, Inference, and Learning Algorithms, 2003, chapter 28).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .estimate import Estimate
from .unknowns import Unknowns

FloatArray = npt.NDArray[np.float64]

#: Prior probability that a factor changed, and that an entry of the car is wrong; a wrong entry has this many times its
#: uncertainty. Judgement: who compares a drive expects another tire as likely as not, and most numbers of a car right.
CHANGED, WRONG, WRONG_SPREAD = 0.5, 0.05, 10.0


@dataclass(frozen=True)
class Probabilities:
    """Posterior probabilities: that a factor changed, by axle and name, and that an entry of the car is wrong."""

    factors: dict[tuple[str, str], float]
    car: dict[str, float]


def probabilities_of(estimate: Estimate, unknowns: Unknowns) -> Probabilities:
    """Return the probabilities over all explanations with at most one wrong entry of the car."""
    lateral = [pair for pair in unknowns.factors if pair[1] in ("LMUY", "LKY")]
    places = [unknowns.factor(*pair) for pair in lateral]
    n_car = len(unknowns.car)
    precision = np.linalg.inv(estimate.covariance)
    information, score = precision - np.eye(len(unknowns)), precision @ estimate.z
    changed = np.array(list(itertools.product((False, True), repeat=len(places))))
    logs = np.empty((len(changed), n_car + 1))
    for row, some in enumerate(changed):
        variance = np.ones(len(unknowns))
        variance[places] = some
        for wrong in range(n_car + 1):
            prior = variance.copy()
            if wrong < n_car:
                prior[wrong] = WRONG_SPREAD**2
            odds = WRONG / (1.0 - WRONG) if wrong < n_car else 1.0
            logs[row, wrong] = np.log(odds) + _evidence(information, score, np.sqrt(prior))
        logs[row] += np.log(np.where(some, CHANGED, 1.0 - CHANGED)).sum()
    share = np.exp(logs - logs.max())
    share /= share.sum()
    return Probabilities(
        {pair: float(share[changed[:, i]].sum()) for i, pair in enumerate(lateral)},
        dict(zip(unknowns.car, share.sum(axis=0).tolist(), strict=False)),
    )


def _evidence(information: FloatArray, score: FloatArray, spread: FloatArray) -> float:
    """Return the logarithm of the evidence for a prior with standard deviations `spread`, up to a constant."""
    scaled = np.eye(len(spread)) + spread[:, None] * information * spread[None, :]
    whole = spread * score
    return float(whole @ np.linalg.solve(scaled, whole) - np.linalg.slogdet(scaled)[1]) / 2
